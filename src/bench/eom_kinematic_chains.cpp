// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench eom`: chains given as positions of their masses, with qdot::unroll for few of them and with a plain
// loop for many.
#include "bench/chain_energies.hpp"
#include "bench/eom.hpp"
#include "bench/hand_derived.hpp"
#include "qdot/mechanics/written_out_kinematics.hpp"

namespace qdot::bench {

namespace {

template <int n, class Place>
[[gnu::noinline]] void by_kinematic_door(const double* q, const double* qdot, double* qddot) {
  static const auto system = kinematic_system<n>(Place{}, uniform_gravity(0.0, -9.81));
  using V = Vector<double, n>;
  Eigen::Map<V>{qddot} = acceleration(system, V(Eigen::Map<const V>(q)), V(Eigen::Map<const V>(qdot)));
}

template <int n>
[[gnu::noinline]] void by_written_out_door(const double* q, const double* qdot, double* qddot) {
  static const auto system = written_out_kinematic_system<n>(LoopedPositions{}, gravity_along<1>(-9.81));
  using V = Vector<double, n>;
  Eigen::Map<V>{qddot} = acceleration(system, V(Eigen::Map<const V>(q)), V(Eigen::Map<const V>(qdot)));
}

template <int n, class Place>
EquationsRow row(const char* door) {
  return {.system = "chain",
          .n = n,
          .door = door,
          .baseline = chain_by_hand<n>,
          .measured = by_kinematic_door<n, Place>,
          .lowest = -2.0,
          .highest = 2.0};
}

template <int... n>
std::vector<EquationsRow> unrolled() {
  return {row<n, UnrolledPositions<n>>("kinematic")...};
}

template <int... n>
void add_written_out(std::vector<EquationsRow>& rows) {
  (rows.push_back({.system = "chain",
                   .n = n,
                   .door = "kinematic, for, written out",
                   .baseline = chain_by_hand<n>,
                   .measured = by_written_out_door<n>,
                   .lowest = -2.0,
                   .highest = 2.0}),
   ...);
}

}  // namespace

std::vector<EquationsRow> kinematic_chain_rows() {
  std::vector<EquationsRow> rows = unrolled<1, 2, 3, 4, 5, 6, 7, 8>();
  rows.push_back(row<12, LoopedPositions>("kinematic"));
  rows.push_back(row<16, LoopedPositions>("kinematic"));
  rows.push_back(row<32, LoopedPositions>("kinematic"));
  add_written_out<1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 24, 32>(rows);
  return rows;
}

}  // namespace qdot::bench
