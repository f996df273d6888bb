// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench eom`: chains given as positions of their masses, with qdot::unroll for few of them and with a plain
// loop for many.
#include "bench/chain_rows.hpp"
#include "qdot/mechanics/kinematic_system.hpp"

namespace qdot::bench {

namespace {

template <int n, class Place>
[[gnu::noinline]] void by_kinematic_door(const double* q, const double* qdot, double* qddot) {
  static const auto system = kinematic_system<n>(Place{}, uniform_gravity(0.0, -9.81));
  using V = Vector<double, n>;
  Eigen::Map<V>{qddot} = acceleration(system, V(Eigen::Map<const V>(q)), V(Eigen::Map<const V>(qdot)));
}

template <int n>
[[gnu::noinline]] void by_kinematic_run(const double* q, const double* qdot, double* qddot) {
  static const auto form = as_in_a_run(first_order_form(kinematic_system<n>(LoopedPositions{}, uniform_gravity(0.0, -9.81))));
  by_form<n>(form, q, qdot, qddot);
}

}  // namespace

std::vector<EquationsRow> kinematic_chain_rows() {
  return joined({chain_rows<1, 2, 3, 4, 5, 6, 7, 8>(
                     "kinematic", []<int n>() -> AccelerationFunction { return by_kinematic_door<n, UnrolledPositions<n>>; }),
                 chain_rows<12, 16, 32>("kinematic", []<int n>() -> AccelerationFunction { return by_kinematic_door<n, LoopedPositions>; }),
                 chain_rows<1, 2, 3, 4, 6, 8, 12, 16, 32>("kinematic, for, in a run", []<int n>() -> AccelerationFunction { return by_kinematic_run<n>; })});
}

}  // namespace qdot::bench
