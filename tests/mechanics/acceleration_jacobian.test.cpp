// SPDX-License-Identifier: MIT
//
// Exact derivatives of q̈ against quotients of differences of q̈.
#include "catch2_bridge.hpp"

#include <algorithm>

#include "bench/chain_energies.hpp"
#include "qdot/mechanics/acceleration_jacobian.hpp"

using namespace qdot;

namespace {

// Central differences with h = 1e-5 leave h² times a third derivative, and rounding over h.
constexpr double differenced = 1e-7;

// The worst difference between exact and differenced columns, relative to the largest entry.
template <class Sys, int n>
double difference_from_quotients(const Sys& system, const Vector<double, n>& q, const Vector<double, n>& qdot, double t = 0.0) {
  using V = Vector<double, n>;
  constexpr double h = 1e-5;
  const auto J = acceleration_jacobian(system, q, qdot, t);
  const double scale = 1.0 + J.d_q.cwiseAbs().maxCoeff() + J.d_qdot.cwiseAbs().maxCoeff();
  double worst = (J.qddot - acceleration(system, q, qdot, t)).norm() / scale;
  const auto column = [&](const V& dq, const V& dv) {
    return V((acceleration(system, V(q + dq), V(qdot + dv), t) - acceleration(system, V(q - dq), V(qdot - dv), t)) / (2.0 * h));
  };
  const V zero = V::Zero(q.size());
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    V step = zero;
    step[j] = h;
    worst = std::max(worst, (J.d_q.col(j) - column(step, zero)).cwiseAbs().maxCoeff() / scale);
    worst = std::max(worst, (J.d_qdot.col(j) - column(zero, step)).cwiseAbs().maxCoeff() / scale);
  }
  return worst;
}

template <int n>
Vector<double, n> spread(Eigen::Index size, double from, double to) {
  return Vector<double, n>::LinSpaced(size, from, to);
}

}  // namespace

TEST_CASE("derivatives of accelerations are limits of quotients: chains") {
  CHECK(difference_from_quotients(mechanical_system<3>(bench::LoopedChain{}), spread<3>(3, -1.0, 1.2), spread<3>(3, 1.0, -0.7)) < differenced);
}

TEST_CASE("derivatives of accelerations are limits of quotients: sizes known at run time, within the limit of the records and beyond") {
  for (const Eigen::Index n : {2, 7, 33})
    CHECK(difference_from_quotients(mechanical_system(n, bench::LoopedChain{}), spread<Dynamic>(n, -1.0, 1.2), spread<Dynamic>(n, 1.0, -0.7)) <
          differenced);
}

TEST_CASE("derivatives of accelerations are limits of quotients: indefinite mass matrices") {
  const auto exchanged = mechanical_system<2>([](const auto& q, const auto& v) { return (1.0 + q[0] * q[0]) * v[0] * v[1]; },
                                              [](const auto& q) { return sin(q[0]) * q[1]; })
                             .with_indefinite_mass_matrix();
  const Vector<double, 2> q(0.6, -0.4), v(0.9, 0.5);
  CHECK(difference_from_quotients(exchanged, q, v) < differenced);
}

TEST_CASE("derivatives of accelerations do not exist where the mass matrix is singular") {
  const auto s = mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] + v[1]) * (v[0] + v[1]); });
  CHECK_THROWS_AS(acceleration_jacobian(s, Vector<double, 2>(0, 0), Vector<double, 2>(0, 0)), SingularMassMatrix);
}
