// SPDX-License-Identifier: MIT
//
// accelerations() of many states at once, T and V summed with qdot::unroll.
#include <cstdlib>

#include "bench/chain_energies.hpp"
#include "bench/peers/peer.hpp"
#include "qdot/mechanics/accelerations.hpp"

namespace {

template <int n>
void chains(const double* q, const double* qdot, double* qddot, int states) {
  using Members = Eigen::Matrix<double, n, qdot::Dynamic, Eigen::RowMajor>;
  static const auto system = qdot::mechanical_system<n>(qdot::bench::UnrolledChain<n>{});
  static Members x, v, a;
  x = Eigen::Map<const Members>(q, n, states);
  v = Eigen::Map<const Members>(qdot, n, states);
  a.resize(n, states);
  if (!accelerations(system, x, v, 0.0, a).empty()) std::abort();
  Eigen::Map<Members>(qddot, n, states) = a;
}

}  // namespace

extern "C" ChainAccelerations accelerations_of_chains(int n) {
  switch (n) {
    case 1: return chains<1>;
    case 2: return chains<2>;
    case 4: return chains<4>;
    default: return nullptr;
  }
}
