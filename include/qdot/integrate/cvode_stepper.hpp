#pragma once
// SPDX-License-Identifier: MIT
//
// CVODE behind the interface that all methods share (stepper.hpp).
//
// Everything lives in one heap block that never moves, since CVODE keeps pointers into it; so the
// stepper itself may be moved freely. It does not depend on the type of the system either, which is
// erased when the stepper is made: a program with many systems compiles CVODE's side once.
//
// The constructor allocates, and so does CVODE's first step; reset() and further steps do not.

#include <Eigen/Core>
#include <memory>
#include <utility>

#include "qdot/integrate/cvode/core.hpp"
#include "qdot/integrate/cvode/newton.hpp"
#include "qdot/integrate/stepper.hpp"
#include "qdot/integrate/watch/any_form.hpp"
#include "qdot/integrate/watch/driven_form_of.hpp"

namespace qdot {

namespace detail::cvode {

#ifdef QDOT_COMPILED
extern template std::unique_ptr<NewtonEquations> newton_equations<double>(const MethodForm&, SUNContext);
#endif

// What makes them for systems of a type, if some of the type may want them: a sparse solver takes the compiler seconds.
template <FirstOrderSystem F>
constexpr NewtonMaker newton_maker() {
  if constexpr (SparseFormOf<MethodForm, F>::may_be_sparse) return &newton_equations<double>;
  else return nullptr;
}

}  // namespace detail::cvode

/// A Stepper driven by CVODE. Movable; one object serves one thread at a time.
class CvodeStepper {
 public:
  static constexpr bool projects_itself = true;  // BDF; Adams refuses a system with constraints

  /// @throws InvalidValue, DimensionError  for options outside their range
  template <FirstOrderSystem F>
  CvodeStepper(const F& system, CvodeSettings settings, const Options& options)
      : core_(detail::cvode::new_core(std::make_unique<detail::SparseFormOf<detail::MethodForm, F>>(system), detail::cvode::newton_maker<F>(),
                                      std::move(settings), options)) {}

  /// Of a system whose type is hidden.
  CvodeStepper(std::unique_ptr<detail::MethodForm> form, CvodeSettings settings, const Options& options)
      : core_(detail::cvode::new_core(std::move(form), nullptr, std::move(settings), options)) {}

  /// Starts (afresh) at (t, y); evaluates f once there.
  ///
  /// @throws DimensionError, InvalidValue  y has the wrong size, or t or y is not finite
  /// @throws NonFinite, MassMatrixError    the model has no finite derivative there; and the model's own
  void reset(const TimePoint& at, const Eigen::Ref<const Eigen::VectorXd>& y) { detail::cvode::reset(*core_, at, y); }

  /// One accepted step towards t_limit, landing on it exactly if it comes that far.
  bool step(double t_limit) { return detail::cvode::step(*core_, t_limit); }

  /// Takes other absolute tolerances, before a reset.
  void tolerate(const Eigen::VectorXd& atol) { detail::cvode::tolerate(*core_, atol); }

  const Failure& failure() const noexcept { return core_->failure; }
  double t() const noexcept { return core_->t; }
  double t_previous() const noexcept { return core_->t_previous; }
  TimePoint time_point() const noexcept { return core_->guard.clock.time_point(core_->elapsed); }
  [[deprecated("qdot: say time_point()")]] TimePoint moment() const noexcept { return time_point(); }
  const Eigen::VectorXd& y() const noexcept { return core_->y; }
  int order() const noexcept { return core_->statistics.last_order; }
  const Statistics& statistics() const noexcept { return core_->statistics; }

  /// The last step's Nordsieck vector as a polynomial.
  PolynomialView polynomial() { return detail::cvode::polynomial(*core_); }

  /// out ← y(t) for t within the last step.
  void interpolate(double t, Eigen::Ref<Eigen::VectorXd> out) { polynomial().evaluate(t, out); }

 private:
  std::unique_ptr<detail::cvode::Core> core_;
};

static_assert(Stepper<CvodeStepper>);

}  // namespace qdot

#ifndef QDOT_COMPILED
#include "qdot/integrate/cvode/sparse.hpp"
#endif
