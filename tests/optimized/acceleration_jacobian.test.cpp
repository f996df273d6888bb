// SPDX-License-Identifier: MIT
//
// Exact derivatives of q̈ as straight-line code, which exists only with the optimizer on, against quotients of differences.
#include "catch2_bridge.hpp"

#include <algorithm>

#include "bench/chain_energies.hpp"
#include "qdot/mechanics/acceleration_jacobian.hpp"
#include "scenes/heavy_top.hpp"
#include "scenes/rod_and_ring.hpp"

using namespace qdot;

namespace {

// Central differences with h = 1e-5 leave h² times a third derivative, and rounding over h.
constexpr double differenced = 1e-7;

template <int n, class E>
double difference_from_quotients(const E& energies, const Vector<double, n>& q, const Vector<double, n>& v) {
  using V = Vector<double, n>;
  constexpr double h = 1e-5;
  const auto system = mechanical_system<n>(energies);
  const auto J = acceleration_jacobian(system, q, v);
  const double scale = 1.0 + J.d_q.cwiseAbs().maxCoeff() + J.d_qdot.cwiseAbs().maxCoeff();
  double worst = (J.qddot - acceleration(system, q, v)).norm() / scale;
  for (int j = 0; j < n; ++j) {
    const V step = h * V::Unit(j);
    const V of_q = (acceleration(system, V(q + step), v) - acceleration(system, V(q - step), v)) / (2.0 * h);
    const V of_v = (acceleration(system, q, V(v + step)) - acceleration(system, q, V(v - step))) / (2.0 * h);
    worst = std::max(worst, (J.d_q.col(j) - of_q).cwiseAbs().maxCoeff() / scale);
    worst = std::max(worst, (J.d_qdot.col(j) - of_v).cwiseAbs().maxCoeff() / scale);
  }
  return worst;
}

}  // namespace

TEST_CASE("derivatives of accelerations in straight-line code are limits of quotients") {
  CHECK(difference_from_quotients<2>(scenes::RodAndRing{}, {0.9, 0.4}, {-0.3, 1.1}) < differenced);
  CHECK(difference_from_quotients<3>(scenes::HeavyTop{}, {0.9, 0.4, 0.2}, {-0.3, 1.1, 5.0}) < differenced);
  CHECK(difference_from_quotients<2>(bench::UnrolledChain<2>{}, {0.9, 0.4}, {-0.3, 1.1}) < differenced);
  CHECK(difference_from_quotients<3>(bench::LoopedChain{}, {0.9, 0.4, -0.5}, {-0.3, 1.1, 0.7}) < differenced);
}
