#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of constrained_motion.hpp. A program that links qdot::compiled has them from there.

#include <Eigen/Core>
#include <algorithm>

#include "qdot/ad/vector.hpp"
#include "qdot/effects/equations/constrained_motion.hpp"

namespace qdot::detail {

template <class>
AnySolution general_constrained_acceleration(const SceneRows& rows, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const Eigen::VectorXd& z,
                                             double cutoff) {
  const Eigen::VectorXd Q = rows.applied_forces(t, q, qdot, z);
  const Eigen::MatrixXd J = rows.jacobian(t, q, qdot, z);
  const Eigen::VectorXd gamma = rows.gamma(t, q, qdot, z);
  if (all_finite(q) && all_finite(qdot)) {
    Eigen::MatrixXd both(J.rows(), J.cols() + 1);  // one after the other: the first row is named
    std::copy_n(gamma.data(), gamma.size(), std::copy_n(J.data(), J.size(), both.data()));
    rows.require_finite_rows(t, both);
  }
  if (!all_finite(Q)) rows.require_finite_forces(t, q, qdot, z);
  MassAndRhs<double, Dynamic> both = rows.mass_and_rhs(t, q, qdot);
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(q.size());  // for M that is not finite is not singular
  for (Eigen::Index j = 0; j < q.size(); ++j)
    for (Eigen::Index i = 0; i < q.size(); ++i) sums[i] += both.M(i, j);
  rows.require_finite_acceleration(t, q, qdot, sums);
  for (Eigen::Index i = 0; i < Q.size(); ++i) both.r[i] += Q[i];
  const ConstrainedFactors<Dynamic, Dynamic> factors(both.M, J, cutoff);
  AnySolution solution = factors.solution(both.r, gamma, t, NamesOfRows{rows});
  rows.require_finite_acceleration(t, q, qdot, solution.qddot);
  return solution;
}

template <class>
Eigen::MatrixXd constrained_slopes(const SceneRows& rows, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const Eigen::VectorXd& z,
                                   const Eigen::MatrixXd& dr, const Eigen::MatrixXd& dc) {
  const ConstrainedFactors<Dynamic, Dynamic> factors(rows.mass_matrix(t, q, qdot), rows.jacobian(t, q, qdot, z), default_rank_cutoff);
  Eigen::MatrixXd slopes(dr.rows(), dr.cols());
  for (Eigen::Index j = 0; j < dr.cols(); ++j) {
    const Eigen::VectorXd right = vector_at<Dynamic>(dr.data() + j * dr.rows(), dr.rows()), rate = vector_at<Dynamic>(dc.data() + j * dc.rows(), dc.rows());
    const Eigen::VectorXd column = factors.solution(right, rate, t, NamesOfRows{rows}).qddot;
    std::copy_n(column.data(), column.size(), slopes.data() + j * dr.rows());
  }
  return slopes;
}

}  // namespace qdot::detail
