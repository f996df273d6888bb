// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench eom`: the scenes whose equations fit into a line or two.
#include "bench/eom.hpp"
#include "bench/hand_derived.hpp"
#include "qdot/mechanics/written_out.hpp"
#include "scenes/double_pendulum.hpp"
#include "scenes/elastic_pendulum.hpp"
#include "scenes/heavy_top.hpp"
#include "scenes/kepler.hpp"
#include "scenes/rod_and_ring.hpp"
#include "scenes/spherical_pendulum.hpp"

namespace qdot::bench {

namespace {

// As the scene is, and written out.
template <int n, class E, class Hand>
void add_rows(std::vector<EquationsRow>& rows, const char* system, double lowest, double highest) {
  EquationsRow row{.system = system,
                   .n = n,
                   .door = "general",
                   .baseline = by_hand<Hand>,
                   .measured = by_general_door<n, E>,
                   .lowest = lowest,
                   .highest = highest};
  rows.push_back(row);
  row.door = "general, written out";
  row.measured = by_general_door<n, WrittenOut<n, E>>;
  rows.push_back(row);
}

}  // namespace

std::vector<EquationsRow> system_rows() {
  std::vector<EquationsRow> rows;
  add_rows<2, scenes::RodAndRing, RodAndRingByHand>(rows, "rod_and_ring", 0.3, 1.2);
  add_rows<2, scenes::DoublePendulum, DoublePendulumByHand>(rows, "double_pendulum", -2.0, 2.0);
  add_rows<2, scenes::SphericalPendulum, SphericalPendulumByHand>(rows, "spherical_pendulum", 0.3, 1.2);
  add_rows<2, scenes::Kepler, KeplerByHand>(rows, "kepler", 0.3, 1.2);
  add_rows<2, scenes::ElasticPendulum, ElasticPendulumByHand>(rows, "elastic_pendulum", 0.3, 1.2);
  add_rows<3, scenes::HeavyTop, HeavyTopByHand>(rows, "heavy_top", 0.3, 1.2);
  return rows;
}

}  // namespace qdot::bench
