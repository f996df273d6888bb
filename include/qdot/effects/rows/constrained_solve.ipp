#pragma once
// SPDX-License-Identifier: MIT
//
// What constrained_solve.hpp asks where M is singular or rows contradict each other. A program that links qdot::compiled has it from there.

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/effects/rows/dependent_rows.hpp"
#include "qdot/error.hpp"

namespace qdot::detail {

template <class>
void throw_contradiction(const std::vector<std::string>& names, const Eigen::VectorXd& miss, Eigen::Index rank, double t) {
  const Eigen::Index worst = place_of_largest(miss.data(), miss.size());
  const double most = std::abs(miss[worst]);
  const std::string& name = names[static_cast<std::size_t>(worst)];
  throw ConstraintError(name, t, most,
                        sentence({"constraints must not contradict each other, but at t = ", std::to_string(t), " only ", rank, " of ", miss.size(),
                                  " are independent and '", name,
                                  "' asks for an acceleration that the others exclude (by ", std::to_string(most),
                                  "); remove one of the dependent constraints, or make their explicit times agree"}));
}

template <class>
std::vector<double> pivoted_solution(const Eigen::MatrixXd& M, const Eigen::MatrixXd& J, const double* f, const double* gamma, double t,
                                     const std::vector<std::string>& constraints, const std::vector<std::string>& coordinates) {
  const Eigen::Index size = M.rows(), rows = J.rows(), all = size + rows;
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(all, all);
  std::vector<double> both(static_cast<std::size_t>(all)), right_side(both), scales(both);
  double *const x = both.data(), *const right = right_side.data(), *const scale = scales.data();
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index j = 0; j < size; ++j) K(i, j) = M(i, j);
    right[i] = f[i];
  }
  for (Eigen::Index i = 0; i < rows; ++i) {
    bool idle = gamma[i] == 0.0;
    for (Eigen::Index j = 0; j < size; ++j) {
      K(size + i, j) = J(i, j);
      K(j, size + i) = -J(i, j);
      idle = idle && J(i, j) == 0.0;
    }
    if (idle) K(size + i, size + i) = 1.0;  // λ = 0
    right[size + i] = gamma[i];
  }
  // Equilibrate: rows, then columns, to largest entry one.
  for (Eigen::Index i = 0; i < all; ++i) {
    double most = 0.0;
    for (Eigen::Index j = 0; j < all; ++j) most = std::max(most, std::abs(K(i, j)));
    if (!(most > 0.0)) continue;
    for (Eigen::Index j = 0; j < all; ++j) K(i, j) /= most;
    right[i] /= most;
  }
  for (Eigen::Index j = 0; j < all; ++j) {
    const double most = largest(K.data() + j * all, all);
    scale[j] = most > 0.0 ? most : 1.0;
    for (Eigen::Index i = 0; i < all; ++i) K(i, j) /= scale[j];
  }
  const bool regular = pivoted_elimination(K, right, x);
  for (Eigen::Index i = 0; i < all; ++i) x[i] /= scale[i];
  if (regular) return both;
  const double longest = largest(x, all);
  for (Eigen::Index i = 0; i < all; ++i) x[i] /= longest;
  if (largest(x, size) > 1e-9) {
    const std::vector<double> direction(x, x + size);
    throw SingularMassMatrix(sentence({"every motion must have inertia or be determined by a constraint, but at t = ", {t, 6},
                                       " the motion with velocity along ", direction_text(direction, coordinates),
                                       " has neither; give it a mass or a constraint"}),
                             t, direction, 0.0);
  }
  const Eigen::Index worst = place_of_largest(x + size, rows);
  const std::string& name = constraints[static_cast<std::size_t>(worst)];
  throw ConstraintError(name, t, 0.0,
                        sentence({"constraints on massless coordinates must be independent, but at t = ", {t, 6}, " '", name,
                                  "' depends on the others; remove it"}));
}

}  // namespace qdot::detail
