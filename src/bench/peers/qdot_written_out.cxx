// SPDX-License-Identifier: MIT
//
// acceleration() of T and V that sum over the links with a loop, written out by the compiler.
#include "bench/chain_energies.hpp"
#include "bench/peers/peer.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"
#include "qdot/mechanics/written_out.hpp"

namespace {

template <int n>
void chain(const double* q, const double* qdot, double* qddot) {
  using V = qdot::Vector<double, n>;
  static const auto system = qdot::mechanical_system<n>(qdot::written_out<n>(qdot::bench::LoopedChain{}));
  Eigen::Map<V>{qddot} = acceleration(system, V(Eigen::Map<const V>(q)), V(Eigen::Map<const V>(qdot)));
}

}  // namespace

extern "C" ChainAcceleration acceleration_of_chain(int n) {
  return of_links<1, 2, 4, 8>(n, []<int links>() -> ChainAcceleration { return chain<links>; });
}
