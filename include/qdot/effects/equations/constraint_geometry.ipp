#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of constraint_geometry.hpp. A program that links qdot::compiled has them from there.

#include <Eigen/Core>
#include <cmath>

#include "qdot/effects/equations/constraint_geometry.hpp"
#include "qdot/effects/rows/columns.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/mechanics/equations/cholesky.hpp"

namespace qdot::detail {

template <class Sizes>
void DenseGeometry<Sizes>::move_to(const Column& q, const Column& qdot, const Column& z, const Column* kept) {
  Table J = rows_.jacobian(t_, q, qdot, z);
  if (kept != nullptr)
    for (Eigen::Index j = 0; j < J.cols(); ++j)
      for (Eigen::Index i = 0; i < J.rows(); ++i) J(i, j) *= (*kept)[i];
  factor(rows_.mass_matrix(t_, q, qdot), J);
}

template <class Sizes>
void DenseGeometry<Sizes>::factor(const Table& M, const Table& J) {
  J_ = J;
  factors_.emplace(M, J_, cutoff_);
}

template <class Sizes>
void DenseGeometry<Sizes>::require_finite() const {
  rows_.require_finite_rows(t_, J_);
}

template <class Sizes>
Column DenseGeometry<Sizes>::displacement(const Column& r) {
  return factors_->displacement(r, t_, NamesOfRows{rows_});
}

template <class Sizes>
Column DenseGeometry<Sizes>::displacement(const Column& r, const Column& size) {
  Table metric(size.size(), size.size(), 0.0);
  for (Eigen::Index j = 0; j < size.size(); ++j) metric(j, j) = 1.0 / (size[j] * size[j]);
  return FactorsOf<Sizes>(metric, J_, cutoff_).displacement(r, t_, NamesOfRows{rows_});
}

template <class Sizes>
Eigen::Index DenseGeometry<Sizes>::rank() const {
  return factors_->rank();
}

template <class Sizes>
bool DenseGeometry<Sizes>::has_dependent_rows() const {
  Eigen::Index asked = 0;
  for (Eigen::Index i = 0; i < J_.rows(); ++i) asked += length(i) > 0.0 ? 1 : 0;
  return rank() < asked;
}

template <class Sizes>
double DenseGeometry<Sizes>::reach(Eigen::Index row, const Column& x) const {
  double sum = 0.0;
  for (Eigen::Index j = 0; j < J_.cols(); ++j) sum += std::abs(J_(row, j)) * x[j];
  return sum;
}

template <class Sizes>
double DenseGeometry<Sizes>::length(Eigen::Index row) const {
  double sum = 0.0;
  for (Eigen::Index j = 0; j < J_.cols(); ++j) sum += J_(row, j) * J_(row, j);
  return std::sqrt(sum);
}

template <class>
Conditioning dense_conditioning(const SceneRows& rows, double t, const Column& q, const Column& qdot, const Column& z, bool is_free) {
  const Table M = rows.mass_matrix(t, q, qdot);
  if (is_free) {
    CholeskyOf<double, Table> cholesky;
    cholesky.compute(M);
    return {.mass = cholesky.smallest_pivot()};
  }
  const FactorsOf<AnySizes> factors(M, rows.jacobian(t, q, qdot, z), default_rank_cutoff);
  return {factors.mass_pivot(), factors.constraint_pivot(), factors.weakest_constraint()};
}

}  // namespace qdot::detail
