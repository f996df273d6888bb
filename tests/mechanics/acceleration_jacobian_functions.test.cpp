// SPDX-License-Identifier: MIT
//
// Exact derivatives of q̈ against quotients of differences of q̈.
#include "catch2_bridge.hpp"

#include <algorithm>
#include <cmath>

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

// Every function that energies are made of, with velocities inside them.
struct Everything {
  template <class S>
  S T(const Vector<S, 2>& q, const Vector<S, 2>& v, const S& t) const {
    using std::atan2, std::cos, std::exp, std::hypot, std::log, std::pow, std::sin, std::sqrt, std::tanh;
    S sum{};  // a value that nothing was assigned to is zero
    sum += (2.0 + sin(q[0] * q[1]) + 0.1 * t) * v[0] * v[0] + exp(0.2 * q[1]) * v[1] * v[1];
    sum += 0.1 * sqrt(1.0 + v[0] * v[0] + q[1] * q[1]) + 0.05 * pow(1.0 + v[1] * v[1], 1.5) + 0.1 * hypot(v[0], 2.0 + q[0]);
    sum += 0.1 * atan2(q[0] * v[1], 3.0 + v[0]) + 0.1 * log(4.0 + v[0] * q[1]) / (3.0 + q[0]) + 0.1 * tanh(v[0] * v[1]);
    sum += 0.1 * pow(2.0 + q[0], 0.3 * v[1]) + 0.02 * max(v[0], v[1]) * abs(v[1]);
    return sum;
  }
  template <class S>
  S V(const Vector<S, 2>& q, const S& t) const {
    using std::cos;
    return cos(q[0] - q[1] + t) + q[0] * q[0] / (1.0 + q[1] * q[1]);
  }
};

}  // namespace

TEST_CASE("derivatives of accelerations are limits of quotients: every function that energies are made of") {
  const Vector<double, 2> q(0.6, -0.4), v(0.9, 0.5);
  CHECK(difference_from_quotients(mechanical_system<2>(Everything{}), q, v, 0.3) < differenced);
}

