// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench eom`: chains summed with a plain `for`, as they are, in a run, with equations derived when the object is made,
// and by nested duals.
#include "bench/chain_rows.hpp"
#include "qdot/mechanics/equations/lagrange_terms.hpp"

namespace qdot::bench {

namespace {

template <int n>
inline const auto benched_run = in_a_run(mechanical_system<n>(LoopedChain{}));

template <int n>
[[gnu::noinline]] void by_run(const double* q, const double* qdot, double* qddot) {
  using V = Vector<double, n>;
  Eigen::Map<V>{qddot} = acceleration(benched_run<n>, V(Eigen::Map<const V>(q)), V(Eigen::Map<const V>(qdot)));
}

// What is left where no other way is taken.
template <int n>
[[gnu::noinline]] void by_nested_duals(const double* q, const double* qdot, double* qddot) {
  using V = Vector<double, n>;
  const LoopedChain chain;
  const V at = Eigen::Map<const V>(q), velocity = Eigen::Map<const V>(qdot);
  const Matrix<double, n> M = qdot::detail::general_mass_matrix<n>(chain, at, velocity, 0.0);
  Eigen::Map<V>{qddot} = M.ldlt().solve(qdot::detail::general_rhs<n>(chain, at, velocity, 0.0));
}

template <int n>
using Looped = LoopedChain;
template <int n>
using Paired = PairedChain;

}  // namespace

std::vector<EquationsRow> looped_chain_rows() {
  return joined({general_chain_rows<Looped, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 24, 32>("general, for"),
                 chain_rows<1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 24, 32, 48, 64>("general, for, in a run",
                                                                            []<int n>() -> AccelerationFunction { return by_run<n>; }),
                 chain_rows<2, 4, 8, 16>("general, for, nested duals", []<int n>() -> AccelerationFunction { return by_nested_duals<n>; }),
                 general_chain_rows<Paired, 8>("general, for over pairs"),
                 general_chain_rows<Paired, 16>("general, for over pairs")});
}

}  // namespace qdot::bench
