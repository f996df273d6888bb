#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of constraint_geometry.hpp. A program that links qdot::compiled has them from there.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "qdot/effects/equations/constraint_geometry.hpp"
#include "qdot/effects/rows/columns.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/mechanics/equations/cholesky.hpp"

namespace qdot::detail {

template <class Sizes>
void DenseGeometry<Sizes>::move_to(const N& q, const N& qdot, const Column& z, const M* kept) {
  typename Sizes::MN J;
  J.resize(rows_.rows(), q.size());
  rows_.write_jacobian(t_, q.data(), qdot.data(), z.data(), J.data());
  if (kept != nullptr)
    for (Eigen::Index j = 0; j < J.cols(); ++j)
      for (Eigen::Index i = 0; i < J.rows(); ++i) J(i, j) *= (*kept)[i];
  typename Sizes::NN mass;
  mass.resize(q.size(), q.size());
  rows_.write_mass_matrix(t_, q.data(), qdot.data(), mass.data());
  factor(mass, J);
}

template <class Sizes>
void DenseGeometry<Sizes>::factor(const typename Sizes::NN& mass, const typename Sizes::MN& J) {
  J_ = J;
  factors_.emplace(mass, J_, cutoff_);
}

template <class Sizes>
void DenseGeometry<Sizes>::require_finite() const {
  for (Eigen::Index j = 0; j < J_.cols(); ++j)
    for (Eigen::Index i = 0; i < J_.rows(); ++i)
      if (!std::isfinite(J_(i, j))) rows_.require_finite_rows(t_, Table(J_));
}

template <class Sizes>
auto DenseGeometry<Sizes>::displacement(const M& r) -> N {
  return factors_->displacement(r, t_, NamesOfRows{rows_});
}

template <class Sizes>
auto DenseGeometry<Sizes>::displacement(const M& r, const N& size) -> N {
  typename Sizes::NN metric;
  metric.resize(size.size(), size.size());
  std::fill_n(metric.data(), metric.size(), 0.0);
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
double DenseGeometry<Sizes>::reach(Eigen::Index row, const N& x) const {
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

template <class Sizes>
Conditioning dense_conditioning(const SceneRows& rows, double t, const double* q, const double* qdot, const double* z, bool is_free) {
  typename Sizes::NN mass;
  mass.resize(rows.dof(), rows.dof());
  rows.write_mass_matrix(t, q, qdot, mass.data());
  if (is_free) {
    CholeskyOf<double, typename Sizes::NN> cholesky;
    cholesky.compute(mass);
    return {.mass = cholesky.smallest_pivot()};
  }
  typename Sizes::MN J;
  J.resize(rows.rows(), rows.dof());
  rows.write_jacobian(t, q, qdot, z, J.data());
  const FactorsOf<Sizes> factors(mass, J, default_rank_cutoff);
  return {factors.mass_pivot(), factors.constraint_pivot(), factors.weakest_constraint()};
}

}  // namespace qdot::detail
