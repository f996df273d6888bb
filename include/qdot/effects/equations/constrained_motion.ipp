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

template <class Sizes>
SolutionOf<typename Sizes::N, typename Sizes::M> general_constrained_acceleration(const SceneRows& rows, double t, const typename Sizes::N& q,
                                                                                  const typename Sizes::N& qdot, const Column& z, double cutoff) {
  const Eigen::Index n = q.size();
  const Column x(q.data(), n), v(qdot.data(), n), Q = rows.applied_forces(t, x, v, z), second = rows.gamma(t, x, v, z);
  typename Sizes::MN J;
  J.resize(rows.rows(), n);
  rows.write_jacobian(t, x.data(), v.data(), z.data(), J.data());
  if (all_finite(x.data(), n) && all_finite(v.data(), n) && !(all_finite(J.data(), J.size()) && all_finite(second.data(), second.size()))) {
    Table both(J.rows(), n + 1);  // one after the other: the first row is named
    std::copy_n(second.data(), second.size(), std::copy_n(J.data(), J.size(), both.data()));
    rows.require_finite_rows(t, both);
  }
  if (!all_finite(Q.data(), Q.size())) rows.require_finite_forces(t, x, v, z);
  typename Sizes::NN mass;
  mass.resize(n, n);
  typename Sizes::N f;
  f.resize(n);
  rows.write_mass_and_rhs(t, x, v, mass.data(), f.data());
  const auto require_finite = [&](const double* a) {
    if (!all_finite(a, n)) rows.require_finite_acceleration(t, x, v, Column(a, n));
  };
  Column sums(n, 0.0);  // of M, for one that is not finite is not singular
  for (Eigen::Index j = 0; j < n; ++j)
    for (Eigen::Index i = 0; i < n; ++i) sums[i] += mass(i, j);
  require_finite(sums.data());
  for (Eigen::Index i = 0; i < Q.size(); ++i) f[i] += Q[i];
  typename Sizes::M gamma;
  gamma.resize(rows.rows());
  std::copy_n(second.data(), second.size(), gamma.data());
  const auto solution = FactorsOf<Sizes>(mass, J, cutoff).solution(f, gamma, t, NamesOfRows{rows});
  require_finite(solution.qddot.data());
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
