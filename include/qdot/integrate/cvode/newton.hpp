#pragma once
// SPDX-License-Identifier: MIT
//
// Newton's equations of an implicit step, (1 − γ ∂f/∂y) x = b, in a form that is better than a dense matrix.

#include <Eigen/Core>

#include "qdot/integrate/cvode/bridge.hpp"

namespace qdot::detail::cvode {

/// What CVODE asks for a state (linearize), for each γ (assemble), and for each b (the solver, whose matrix is a placeholder).
class NewtonEquations {
 public:
  virtual ~NewtonEquations() = default;
  virtual SUNLinearSolver solver() const noexcept = 0;
  virtual SUNMatrix matrix() const noexcept = 0;
  virtual void renew() {}  ///< the system's functors may be others by now
  virtual void linearize(double t, const Eigen::Ref<const Eigen::VectorXd>& y) = 0;
  virtual void assemble(double gamma) = 0;
};

}  // namespace qdot::detail::cvode
