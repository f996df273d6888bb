// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench scenes`: hanging chains with as many constraints as masses.
#include "bench/hanging_chain.hpp"
#include "bench/scenes.hpp"

namespace qdot::bench {

namespace {

template <int masses>
[[gnu::noinline]] void by_hand_of_hanging_chain(const double* q, const double* v, double* a) {
  static const HangingChainByHand hand{.masses = masses};
  hand(q, v, a);
}

template <int masses>
[[gnu::noinline]] void by_hanging_chain(const double* q, const double* v, double* a) {
  static const auto chain = hanging_chain(masses);
  const auto solution = constrained_acceleration(chain, Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(q, 2 * masses)),
                                                 Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(v, 2 * masses)));
  Eigen::Map<Eigen::VectorXd>(a, 2 * masses) = solution.qddot;
  Eigen::Map<Eigen::VectorXd>(a + 2 * masses, masses) = solution.lambda;
}

double straight_down(int i) { return i % 2 == 0 ? 0.0 : -(i + 1) / 2; }

template <int... masses>
std::vector<SceneRow> rows() {
  return {SceneRow{.evaluation = {.system = "hanging chain, Cartesian",
                                  .n = 2 * masses,
                                  .door = "",
                                  .baseline = by_hand_of_hanging_chain<masses>,
                                  .measured = by_hanging_chain<masses>,
                                  .lowest = -0.3,
                                  .highest = 0.3,
                                  .numbers_out = 3 * masses,
                                  .middle = straight_down},
                   .constraints = masses,
                   .effect = "rods"}...};
}

}  // namespace

std::vector<SceneRow> hanging_chain_scene_rows() { return rows<10, 40, 160, 640>(); }

}  // namespace qdot::bench
