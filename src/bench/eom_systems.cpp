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
EquationsRow row_of(const char* system, double lowest, double highest) {
  return {.system = system,
          .n = n,
          .door = "general",
          .baseline = by_hand<Hand>,
          .measured = by_general_door<n, E>,
          .lowest = lowest,
          .highest = highest};
}

}  // namespace

std::vector<EquationsRow> system_rows() {
  return {row_of<2, scenes::RodAndRing, RodAndRingByHand>("rod_and_ring", 0.3, 1.2),
          row_of<2, scenes::DoublePendulum, DoublePendulumByHand>("double_pendulum", -2.0, 2.0),
          row_of<2, scenes::SphericalPendulum, SphericalPendulumByHand>("spherical_pendulum", 0.3, 1.2),
          row_of<2, scenes::Kepler, KeplerByHand>("kepler", 0.3, 1.2),
          row_of<2, scenes::ElasticPendulum, ElasticPendulumByHand>("elastic_pendulum", 0.3, 1.2),
          row_of<3, scenes::HeavyTop, HeavyTopByHand>("heavy_top", 0.3, 1.2)};
}

}  // namespace qdot::bench
