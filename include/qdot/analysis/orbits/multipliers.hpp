#pragma once
// SPDX-License-Identifier: MIT
//
// Multipliers of an orbit, the trivial ones taken out.
//
// Take a unit vector a along ẋ, b along ∇h, and U orthonormal and normal to both. Then M is a block triangle in the basis [a, U,
// b], since M a = a and bᵀM = bᵀ:
//
//     ⎡ 1  *     * ⎤
//     ⎢ 0  UᵀMU  * ⎥        UᵀMU has the multipliers that are not trivial
//     ⎣ 0  0     1 ⎦
//
// On constraints M is that of the tangent space: what they forbid is taken out as well.
//
// All in units of the extents of the orbit, so that metres and radians do not decide what is normal.

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "qdot/analysis/linear/exponents.hpp"
#include "qdot/analysis/linear/shortest_step.hpp"
#include "qdot/analysis/orbit.hpp"

namespace qdot::detail {

// ∂x/∂x with x in units of `scale`, which may have more entries.
template <class = void>  // compiled only where it is called
Eigen::MatrixXd in_units_of(const Eigen::VectorXd& scale, const Eigen::MatrixXd& M) {
  const auto of_x = scale.head(M.rows());
  return of_x.cwiseInverse().asDiagonal() * M * of_x.asDiagonal();
}

// UᵀMU in units of `scale`; `taken` is orthonormal: what is forbidden, along ẋ, along ∇h.
template <class = void>  // compiled only where it is called
Eigen::MatrixXd without_trivial(const Eigen::MatrixXd& M, const Eigen::VectorXd& scale, const std::vector<Eigen::VectorXd>& taken) {
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(taken.size()), M.rows());
  for (Eigen::Index i = 0; i < rows.rows(); ++i) rows.row(i) = taken[static_cast<std::size_t>(i)];
  const Eigen::MatrixXd U = shortest_step(rows, Eigen::VectorXd::Zero(rows.rows()), 0.5).open;  // all singular values are 1 or 0
  const Eigen::MatrixXd right = in_units_of(scale, M).lazyProduct(U);
  return U.transpose().lazyProduct(right);
}

// Multipliers of B, whose entries are as wrong as their difference from those of `coarser`.
template <class = void>  // compiled only where it is called
std::vector<Multiplier> multipliers_of(const Eigen::MatrixXd& B, const Eigen::MatrixXd& coarser, std::size_t trivial) {
  const Exponents all = exponents_of(B);
  const double wrong = in_units_of(all.scale, B - coarser).norm();
  std::vector<Multiplier> multipliers(trivial, Multiplier{1.0, 0.0, true});
  for (Eigen::Index i = 0; i < B.rows(); ++i) {
    const double condition = all.radius[i] / (32.0 * std::numeric_limits<double>::epsilon() * all.size);
    const double moved = std::min(condition * wrong, std::sqrt(wrong * all.size));  // a double one moves by the root
    multipliers.push_back({all.lambda[i], all.radius[i] + (std::isfinite(moved) ? moved : 0.0), false});
  }
  std::sort(multipliers.begin(), multipliers.end(), [](const Multiplier& a, const Multiplier& b) {
    const double larger = std::abs(a.value), smaller = std::abs(b.value);
    return larger != smaller ? larger > smaller : a.value.imag() > b.value.imag();
  });
  return multipliers;
}

template <class = void>  // compiled only where it is called
OrbitStability stability_of(const std::vector<Multiplier>& multipliers) {
  bool on_circle = false, doubtful = false, others = false;
  for (const Multiplier& m : multipliers) {
    if (m.trivial) continue;
    others = true;
    const double size = std::abs(m.value);
    if (size > 1.0 + m.radius) return OrbitStability::unstable;
    if (size < 1.0 - m.radius) continue;
    on_circle = true;
    doubtful = doubtful || std::abs(m.value - 1.0) <= m.radius || std::abs(m.value + 1.0) <= m.radius;
    for (const Multiplier& other : multipliers)
      doubtful = doubtful || (&other != &m && !other.trivial && std::abs(m.value - other.value) <= m.radius + other.radius);
  }
  if (doubtful) return OrbitStability::not_decided;
  return on_circle || !others ? OrbitStability::stable_to_first_order : OrbitStability::asymptotically_stable;
}

}  // namespace qdot::detail
