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
#include "qdot/integrate/cvode/bridge.hpp"
#include "qdot/mechanics/equations/banded_equations.hpp"

namespace qdot::detail::cvode {

class BandedNewton {
 public:
  BandedNewton(Eigen::Index n, SUNContext context) : context_(context), right_(zeros<Eigen::VectorXd>(n)) {
    right_vector_ = owned<VectorHandle>(N_VMake_Serial(index(n), right_.data(), context_), "vector");
    placeholder_ = owned<MatrixHandle>(SUNDenseMatrix(1, 1, context_), "matrix");
    SUNLinearSolver raw = SUNLinSolNewEmpty(context_);
    outer_ = owned<LinearSolverHandle>(raw, "linear solver");
    raw->content = this;
    raw->ops->gettype = [](SUNLinearSolver) { return SUNLINEARSOLVER_DIRECT; };
    raw->ops->getid = [](SUNLinearSolver) { return SUNLINEARSOLVER_CUSTOM; };
    raw->ops->setup = [](SUNLinearSolver s, SUNMatrix) {
      auto& self = *static_cast<BandedNewton*>(s->content);
      return static_cast<int>(SUNLinSolSetup(self.inner_.get(), self.band_.get()));
    };
    raw->ops->solve = [](SUNLinearSolver s, SUNMatrix, N_Vector x, N_Vector b, sunrealtype) {
      return static_cast<BandedNewton*>(s->content)->solve(N_VGetArrayPointer(x), N_VGetArrayPointer(b));
    };
    raw->ops->free = [](SUNLinearSolver s) {
      s->content = nullptr;
      SUNLinSolFreeEmpty(s);
      return 0;
    };
  }
  BandedNewton(const BandedNewton&) = delete;
  BandedNewton& operator=(const BandedNewton&) = delete;

  SUNLinearSolver solver() const noexcept { return outer_.get(); }
  SUNMatrix matrix() const noexcept { return placeholder_.get(); }  // CVODE wants one, and never looks into it

  /// Takes over M, C and K of a state.
  void linearize(BandedLinearization at) { at_ = std::move(at); }

  /// Fills M + γ C + γ² K.
  void assemble(double gamma) {
    gamma_ = gamma;
    const Eigen::Index n = right_.size(), w = at_.reach;
    if (band_ == nullptr || w != assembled_reach_) {
      inner_.reset();
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

  int solve(double* x, const double* b) {
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

  SUNContext context_;
  Eigen::VectorXd right_;
  VectorHandle right_vector_;
  BandedLinearization at_;
  double gamma_ = 0.0;
  Eigen::Index assembled_reach_ = -1;
  MatrixHandle band_, placeholder_;
  LinearSolverHandle inner_, outer_;
};

}  // namespace qdot::detail::cvode
