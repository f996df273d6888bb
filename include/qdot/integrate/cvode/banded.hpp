#pragma once
// SPDX-License-Identifier: MIT
//
// Newton's equations of an implicit step for many coordinates whose neighbours meet.
//
// With y = [q; q̇] and M δq̈ + C δq̇ + K δq = 0 for small changes, (1 − γ ∂f/∂y) x = b is
//
//     x_q − γ x_q̇ = b_q                          x_q = b_q + γ x_q̇
//     M x_q̇ + γ (K x_q + C x_q̇) = M b_q̇         (M + γ C + γ² K) x_q̇ = M b_q̇ − γ K b_q ,
//
// one banded system of n equations. This is for functors that are no formulas, springs that are there on one side only; of formulas the equations are traced
// (integrate/cvode/sparse.hpp). A dense Jacobian of a thousand masses has four million entries; this has as many as the
// band. M need not be diagonal: its inverse, which is dense, never appears.

#include <sunlinsol/sunlinsol_band.h>
#include <sunmatrix/sunmatrix_band.h>

#include <Eigen/Core>
#include <algorithm>
#include <utility>

#include "qdot/ad/vector.hpp"
#include "qdot/integrate/cvode/newton.hpp"
#include "qdot/mechanics/equations/banded_equations.hpp"

namespace qdot::detail::cvode {

/// Of a system that knows M, C and K within their band.
class BandedNewton final : public NewtonEquations {
 public:
  BandedNewton(const MethodForm& system, SUNContext context)
      : NewtonEquations(context), system_(system), context_(context), right_(zeros<Eigen::VectorXd>(system.size() / 2)) {
    right_vector_ = owned<VectorHandle>(N_VMake_Serial(index(right_.size()), right_.data(), context_), "vector");
  }

  void linearize(double t, const Eigen::Ref<const Eigen::VectorXd>& y) override { at_ = std::move(*system_.linearization(t, y)); }

  /// Fills M + γ C + γ² K.
  void assemble(double gamma) override {
    gamma_ = gamma;
    const Eigen::Index n = right_.size(), w = at_.reach;
    if (band_.get() == nullptr || w != assembled_reach_) {
      inner_ = LinearSolverHandle();
      band_ = owned<MatrixHandle>(SUNBandMatrix(index(n), index(w), index(w), context_), "matrix");
      inner_ = owned<LinearSolverHandle>(SUNLinSol_Band(right_vector_.get(), band_.get(), context_), "linear solver");
      SUNLinSolInitialize(inner_.get());
      assembled_reach_ = w;
    }
    SUNMatZero(band_.get());
    for (Eigen::Index j = 0; j < n; ++j) {
      sunrealtype* const column = SUNBandMatrix_Column(band_.get(), index(j));  // entry (i, j) at i − j
      for (Eigen::Index i = std::max<Eigen::Index>(0, j - w); i < std::min(n, j + w + 1); ++i)
        column[i - j] = mass(i, j) + gamma * (at_.C(i - j + w, j) + gamma * at_.K(i - j + w, j));
    }
  }

 private:
  double mass(Eigen::Index i, Eigen::Index j) const {
    const Eigen::Index below = std::max(i, j), left = std::min(i, j);
    return below - left <= at_.M.reach() ? at_.M(below, left) : 0.0;
  }

  int factor() override { return static_cast<int>(SUNLinSolSetup(inner_.get(), band_.get())); }
  int solve(double* x, const double* b) override {
    const Eigen::Index n = right_.size(), w = at_.reach;
    std::fill_n(right_.data(), n, 0.0);
    for (Eigen::Index j = 0; j < n; ++j)
      for (Eigen::Index i = std::max<Eigen::Index>(0, j - w); i < std::min(n, j + w + 1); ++i)
        right_[i] += mass(i, j) * b[n + j] - gamma_ * at_.K(i - j + w, j) * b[j];
    const VectorHandle velocities = owned<VectorHandle>(N_VMake_Serial(index(n), x + n, context_), "vector");
    const int flag = SUNLinSolSolve(inner_.get(), band_.get(), velocities.get(), right_vector_.get(), 0.0);
    for (Eigen::Index i = 0; i < n; ++i) x[i] = b[i] + gamma_ * x[n + i];
    return flag;
  }

  const MethodForm& system_;
  SUNContext context_;
  Eigen::VectorXd right_;
  VectorHandle right_vector_;
  BandedLinearization at_;
  double gamma_ = 0.0;
  Eigen::Index assembled_reach_ = -1;
  MatrixHandle band_;
  LinearSolverHandle inner_;
};

}  // namespace qdot::detail::cvode
