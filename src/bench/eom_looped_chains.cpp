// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench eom`: chains summed with a plain `for`, as they are, in a run, and with equations
// derived when the object is made.
#include <utility>
#include <vector>

#include "bench/chain_energies.hpp"
#include "bench/eom.hpp"
#include "bench/hand_derived.hpp"
#include "qdot/mechanics/derived.hpp"

namespace qdot::bench {

namespace {

template <int n, class E>
EquationsRow row(const char* door) {
  return {.system = "chain", .n = n, .door = door, .baseline = chain_by_hand<n>, .measured = by_general_door<n, E>, .lowest = -2.0, .highest = 2.0};
}

template <int... n>
std::vector<EquationsRow> rows_as_they_are() {
  return {row<n, LoopedChain>("general, for")...};
}
template <int n>
inline const auto benched_run = in_a_run(mechanical_system<n>(LoopedChain{}));

template <int n>
[[gnu::noinline]] void by_run(const double* q, const double* qdot, double* qddot) {
  using V = Vector<double, n>;
  Eigen::Map<V>{qddot} = acceleration(benched_run<n>, V(Eigen::Map<const V>(q)), V(Eigen::Map<const V>(qdot)));
}
template <int... n>
std::vector<EquationsRow> rows_in_a_run() {
  return {EquationsRow{.system = "chain", .n = n, .door = "general, for, in a run", .baseline = chain_by_hand<n>, .measured = by_run<n>, .lowest = -2.0, .highest = 2.0}...};
}
template <int... n>
std::vector<EquationsRow> derived_rows() {
  return {row<n, Derived<n, LoopedChain>>("general, for, derived")...};
}

}  // namespace

std::vector<EquationsRow> looped_chain_rows() {
  std::vector<EquationsRow> rows = rows_as_they_are<1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 24, 32>();
  for (EquationsRow& derived : derived_rows<1, 2, 3, 4, 5, 6, 7, 8>()) rows.push_back(std::move(derived));
  for (EquationsRow& in_a_run : rows_in_a_run<1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 24, 32, 48, 64>()) rows.push_back(std::move(in_a_run));
  rows.push_back(row<8, PairedChain>("general, for over pairs"));
  rows.push_back(row<8, Derived<8, PairedChain>>("general, for over pairs, derived"));
  rows.push_back(row<16, PairedChain>("general, for over pairs"));
  rows.push_back(row<16, Derived<16, PairedChain>>("general, for over pairs, derived"));
  return rows;
}

}  // namespace qdot::bench
