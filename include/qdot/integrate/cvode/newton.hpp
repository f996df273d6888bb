#pragma once
// SPDX-License-Identifier: MIT
//
// Newton's equations of an implicit step, (1 − γ ∂f/∂y) x = b, in a form that is better than a dense matrix.

#include <sundials/sundials_linearsolver.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <Eigen/Core>
#include <memory>

#include "qdot/integrate/cvode/bridge.hpp"
#include "qdot/integrate/watch/driven_form.hpp"

namespace qdot::detail::cvode {

/// What CVODE asks for a state (linearize), for each γ (assemble), and for each b: it takes them for a linear solver of its own, whose
/// matrix it wants, and never looks into.
class NewtonEquations {
 public:
  explicit NewtonEquations(SUNContext context) {
    placeholder_ = owned<MatrixHandle>(SUNDenseMatrix(1, 1, context), "matrix");
    SUNLinearSolver raw = SUNLinSolNewEmpty(context);
    solver_ = owned<LinearSolverHandle>(raw, "linear solver");
    raw->content = this;
    raw->ops->gettype = [](SUNLinearSolver) { return SUNLINEARSOLVER_DIRECT; };
    raw->ops->getid = [](SUNLinearSolver) { return SUNLINEARSOLVER_CUSTOM; };
    raw->ops->setup = [](SUNLinearSolver s, SUNMatrix) { return static_cast<NewtonEquations*>(s->content)->factor(); };
    raw->ops->solve = [](SUNLinearSolver s, SUNMatrix, N_Vector x, N_Vector b, sunrealtype) {
      return static_cast<NewtonEquations*>(s->content)->solve(N_VGetArrayPointer(x), N_VGetArrayPointer(b));
    };
    raw->ops->free = [](SUNLinearSolver s) {
      s->content = nullptr;
      SUNLinSolFreeEmpty(s);
      return 0;
    };
  }
  NewtonEquations(const NewtonEquations&) = delete;
  NewtonEquations& operator=(const NewtonEquations&) = delete;
  virtual ~NewtonEquations() = default;

  SUNLinearSolver solver() const noexcept { return solver_.get(); }
  SUNMatrix matrix() const noexcept { return placeholder_.get(); }
  virtual void renew() {}  ///< the system's functors may be others by now
  virtual void linearize(double t, const Eigen::Ref<const Eigen::VectorXd>& y) = 0;
  virtual void assemble(double gamma) = 0;

 private:
  virtual int factor() = 0;  // a positive number where another γ may do
  virtual int solve(double* x, const double* b) = 0;

  MatrixHandle placeholder_;
  LinearSolverHandle solver_;
};

/// What makes them for a system; nothing where a dense Jacobian is as good.
using NewtonMaker = std::unique_ptr<NewtonEquations> (*)(const MethodForm& system, SUNContext context);

/// Newton's equations of many coordinates that do not all meet, from traced equations or, where there are none, within the band that a tape shows.
/// Nothing where a dense Jacobian is as good (integrate/cvode/sparse.hpp).
template <class Number = double>
std::unique_ptr<NewtonEquations> newton_equations(const MethodForm& system, SUNContext context);

}  // namespace qdot::detail::cvode
