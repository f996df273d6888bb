#pragma once
// SPDX-License-Identifier: MIT
//
// q̈ of a planar chain of unit masses and lengths as derived by hand, absolute angles from the downward vertical:
//
//     M_ij = (n − max(i,j)) cos(θ_i − θ_j),  r_i = −(n − i) g sin θ_i − Σ_j (n − max(i,j)) sin(θ_i − θ_j) θ̇_j² .
//
// The formulas of bench/hand_derived.hpp in loops: where nothing is optimized, what is written out for n = 48 takes the compiler half a minute.

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include "systems/solution_by_pivots.hpp"

namespace qdot {

inline Eigen::VectorXd chain_by_loops(const Eigen::VectorXd& q, const Eigen::VectorXd& v) {
  constexpr double g = 9.81;
  const Eigen::Index n = q.size();
  Eigen::MatrixXd M(n, n);
  Eigen::VectorXd r(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    r[i] = -static_cast<double>(n - i) * g * std::sin(q[i]);
    for (Eigen::Index j = 0; j < n; ++j) {
      const double weight = static_cast<double>(n - std::max(i, j));
      M(i, j) = weight * std::cos(q[i] - q[j]);
      r[i] -= weight * std::sin(q[i] - q[j]) * v[j] * v[j];
    }
  }
  return solution_by_pivots<Dynamic>(M, r);
}

}  // namespace qdot
