#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of constrained_motion.hpp. A program that links qdot::compiled has them from there.

#include <Eigen/Core>
#include <algorithm>

#include "qdot/ad/vector.hpp"
#include "qdot/effects/equations/constrained_motion.hpp"
#include "qdot/effects/rows/columns.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"

namespace qdot::detail {

template <class>
AnySolution general_constrained_acceleration(const SceneRows& rows, double t, const Column& q, const Column& qdot, const Column& z,
                                             double cutoff) {
  const Column Q = rows.applied_forces(t, q, qdot, z);
  const Table J = rows.jacobian(t, q, qdot, z);
  const Column gamma = rows.gamma(t, q, qdot, z);
  if (all_finite(q.data(), q.size()) && all_finite(qdot.data(), qdot.size())) {
    Table both(J.rows(), J.cols() + 1);  // one after the other: the first row is named
    std::copy_n(gamma.data(), gamma.size(), std::copy_n(J.data(), J.size(), both.data()));
    rows.require_finite_rows(t, both);
  }
  if (!all_finite(Q.data(), Q.size())) rows.require_finite_forces(t, q, qdot, z);
  Table M;
  Column f, sums(q.size(), 0.0);  // of M, for one that is not finite is not singular
  rows.write_mass_and_rhs(t, q, qdot, M, f);
  for (Eigen::Index j = 0; j < q.size(); ++j)
    for (Eigen::Index i = 0; i < q.size(); ++i) sums[i] += M(i, j);
  rows.require_finite_acceleration(t, q, qdot, sums);
  for (Eigen::Index i = 0; i < Q.size(); ++i) f[i] += Q[i];
  AnySolution solution = FactorsOf<AnySizes>(M, J, cutoff).solution(f, gamma, t, NamesOfRows{rows});
  rows.require_finite_acceleration(t, q, qdot, solution.qddot);
  return solution;
}

template <class>
Table constrained_slopes(const SceneRows& rows, double t, const Column& q, const Column& qdot, const Column& z,
                         const Table& dr, const Table& dc) {
  const FactorsOf<AnySizes> factors(rows.mass_matrix(t, q, qdot), rows.jacobian(t, q, qdot, z), default_rank_cutoff);
  Table slopes(dr.rows(), dr.cols());
  for (Eigen::Index j = 0; j < dr.cols(); ++j) {
    const Column right(dr.data() + j * dr.rows(), dr.rows()), rate(dc.data() + j * dc.rows(), dc.rows());
    const Column column = factors.solution(right, rate, t, NamesOfRows{rows}).qddot;
    std::copy_n(column.data(), column.size(), slopes.data() + j * dr.rows());
  }
  return slopes;
}

}  // namespace qdot::detail
