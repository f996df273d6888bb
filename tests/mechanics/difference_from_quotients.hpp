#pragma once
// SPDX-License-Identifier: MIT
//
// Exact derivatives of q̈ against quotients of differences of q̈.

#include <algorithm>

#include "qdot/mechanics/acceleration_jacobian.hpp"

// Central differences with h = 1e-5 leave h² times a third derivative, and rounding over h.
inline constexpr double differenced = 1e-7;

// The worst difference between exact and differenced columns, relative to the largest entry.
template <class Sys, int n>
double difference_from_quotients(const Sys& system, const qdot::Vector<double, n>& q, const qdot::Vector<double, n>& qdot, double t = 0.0) {
  using V = qdot::Vector<double, n>;
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
