#pragma once
// SPDX-License-Identifier: MIT
//
// The direction in which friction in a plane begins to slide.
//
// At an onset the sliding velocity v is zero, and its acceleration must point along the direction s of sliding that the friction F_k brakes: v̇ = a s with
// a > 0. With v̇₀ the acceleration without friction, and G the response of v̇ to forces F_k along its components,
//
//     (G + a I) s = v̇₀ ,    |s| = 1 .
//
// G is symmetric and positive, so |s| falls as a grows: there is one a, or none where |G⁻¹ v̇₀| < 1, since then F_k holds v. Where G is a multiple of I,
// s is the direction of the force; otherwise it is not.

#include <Eigen/Core>
#include <limits>
#include <optional>

#include "qdot/mechanics/equations/cholesky.hpp"

namespace qdot::detail {

// (G + a I)⁻¹ x; nothing where that has no solution.
template <class = void>  // compiled only where it is called
std::optional<Eigen::VectorXd> damped_solution(const Eigen::MatrixXd& G, double a, const Eigen::VectorXd& x) {
  Cholesky<double, Dynamic> factors;
  if (!factors.compute(G + a * Eigen::MatrixXd::Identity(G.rows(), G.cols()))) return {};
  return factors.solve(x);
}

// s, for v̇₀ that is not zero; nothing where friction holds v.
template <class = void>  // compiled only where it is called
std::optional<Eigen::VectorXd> onset_direction(const Eigen::MatrixXd& G, const Eigen::VectorXd& x) {
  constexpr double rounding = 1e-12;
  if (const auto held = damped_solution(G, 0.0, x); held && held->norm() < 1.0 - rounding) return {};
  double low = 0.0, high = x.norm();  // at a = |v̇₀| no s is longer than 1
  while (high - low > 4 * std::numeric_limits<double>::epsilon() * high) {
    const double a = 0.5 * (low + high);
    const auto s = damped_solution(G, a, x);
    (!s || s->norm() > 1.0 ? low : high) = a;
  }
  return damped_solution(G, high, x)->normalized();
}

}  // namespace qdot::detail
