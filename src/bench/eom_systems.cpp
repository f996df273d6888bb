// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench eom`: the scenes whose equations fit into a line or two.
#include "bench/eom.hpp"
#include "bench/hand_derived.hpp"
#include "scenes/double_pendulum.hpp"
#include "scenes/elastic_pendulum.hpp"
#include "scenes/heavy_top.hpp"
#include "scenes/kepler.hpp"
#include "scenes/rod_and_ring.hpp"
#include "scenes/spherical_pendulum.hpp"

namespace qdot::bench {

namespace {

template <int n, class E, class Hand>
std::vector<EquationsRow> rows_of(const char* system, double lowest, double highest) {
  const auto row = [&](const char* door, AccelerationFunction measured) -> EquationsRow {
    return {.system = system, .n = n, .door = door, .baseline = by_hand<Hand>, .measured = measured, .lowest = lowest, .highest = highest};
  };
  return {row("general", by_general_door<n, E>), row("in a run", by_run<n, E>), row("in a run, duals", by_way<n, E, By::duals>),
          row("in a run, lines", by_way<n, E, By::lines>), row("in a run, machine code", by_way<n, E, By::machine_code>)};
}

}  // namespace

std::vector<EquationsRow> system_rows() {
  return joined({rows_of<2, scenes::RodAndRing, RodAndRingByHand>("rod_and_ring", 0.3, 1.2),
                 rows_of<2, scenes::DoublePendulum, DoublePendulumByHand>("double_pendulum", -2.0, 2.0),
                 rows_of<2, scenes::SphericalPendulum, SphericalPendulumByHand>("spherical_pendulum", 0.3, 1.2),
                 rows_of<2, scenes::Kepler, KeplerByHand>("kepler", 0.3, 1.2),
                 rows_of<2, scenes::ElasticPendulum, ElasticPendulumByHand>("elastic_pendulum", 0.3, 1.2),
                 rows_of<3, scenes::HeavyTop, HeavyTopByHand>("heavy_top", 0.3, 1.2)});
}

}  // namespace qdot::bench
