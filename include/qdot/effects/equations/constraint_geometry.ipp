#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of constraint_geometry.hpp. A program that links qdot::compiled has them from there.

#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "qdot/effects/equations/constraint_geometry.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/mechanics/equations/cholesky.hpp"

namespace qdot::detail {

template <class = void>  // compiled only where it is called
class DenseGeometry final : public ConstraintGeometry {
  using Factors = ConstrainedFactors<Dynamic, Dynamic>;

 public:
  DenseGeometry(const SceneRows& rows, double t, double cutoff) : rows_(rows), t_(t), cutoff_(cutoff) {}

  void move_to(const VectorXd& q, const VectorXd& qdot, const VectorXd& z, const VectorXd* kept) override {
    Eigen::MatrixXd J = rows_.jacobian(t_, q, qdot, z);
    if (kept != nullptr)
      for (Eigen::Index j = 0; j < J.cols(); ++j)
        for (Eigen::Index i = 0; i < J.rows(); ++i) J(i, j) *= (*kept)[i];
    factor(rows_.mass_matrix(t_, q, qdot), std::move(J));
  }
  void factor(const Eigen::MatrixXd& M, Eigen::MatrixXd J) {
    J_ = std::move(J);
    factors_.emplace(M, J_, cutoff_);
  }
  void require_finite() const override { rows_.require_finite_rows(t_, J_); }

  VectorXd displacement(const VectorXd& r) override { return factors_->displacement(r, t_, NamesOfRows{rows_}); }
  VectorXd displacement(const VectorXd& r, const VectorXd& size) override {
    Eigen::MatrixXd metric = Eigen::MatrixXd::Zero(size.size(), size.size());
    for (Eigen::Index j = 0; j < size.size(); ++j) metric(j, j) = 1.0 / (size[j] * size[j]);
    return Factors(metric, J_, cutoff_).displacement(r, t_, NamesOfRows{rows_});
  }

  Eigen::Index rank() const override { return factors_->rank(); }
  bool has_dependent_rows() const override {
    Eigen::Index asked = 0;
    for (Eigen::Index i = 0; i < J_.rows(); ++i) asked += length(i) > 0.0 ? 1 : 0;
    return rank() < asked;
  }
  double reach(Eigen::Index row, const VectorXd& x) const override {
    double sum = 0.0;
    for (Eigen::Index j = 0; j < J_.cols(); ++j) sum += std::abs(J_(row, j)) * x[j];
    return sum;
  }
  double length(Eigen::Index row) const override {
    double sum = 0.0;
    for (Eigen::Index j = 0; j < J_.cols(); ++j) sum += J_(row, j) * J_(row, j);
    return std::sqrt(sum);
  }

 private:
  const SceneRows& rows_;
  double t_, cutoff_;
  Eigen::MatrixXd J_;
  std::optional<Factors> factors_;
};

template <class>
std::unique_ptr<ConstraintGeometry> dense_geometry(const SceneRows& rows, double t, double cutoff) {
  return std::make_unique<DenseGeometry<>>(rows, t, cutoff);
}

template <class>
std::unique_ptr<ConstraintGeometry> dense_geometry(const SceneRows& rows, double t, double cutoff, Eigen::MatrixXd M, Eigen::MatrixXd J) {
  auto geometry = std::make_unique<DenseGeometry<>>(rows, t, cutoff);
  geometry->factor(M, std::move(J));
  return geometry;
}

template <class>
Conditioning dense_conditioning(const SceneRows& rows, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, const Eigen::VectorXd& z) {
  const Eigen::MatrixXd M = rows.mass_matrix(t, q, qdot);
  if (rows.is_free(z)) {
    Cholesky<double, Dynamic> cholesky;
    cholesky.compute(M);
    return {.mass = cholesky.smallest_pivot()};
  }
  const ConstrainedFactors<Dynamic, Dynamic> factors(M, rows.jacobian(t, q, qdot, z), default_rank_cutoff);
  return {factors.mass_pivot(), factors.constraint_pivot(), factors.weakest_constraint()};
}

}  // namespace qdot::detail
