#pragma once
// SPDX-License-Identifier: MIT
//
// CVODE's two families of multistep methods, for any system that can be stepped.
//
//     CvodeBdf      backward differentiation formulas, order 1 to 5:  Σ αᵢ yₙ₋ᵢ = h f(tₙ, yₙ)
//     CvodeAdams    Adams–Moulton formulas, order 1 to 12:  yₙ = yₙ₋₁ + h Σ βᵢ f(tₙ₋ᵢ, yₙ₋ᵢ)
//
// BDF is for stiff motion, with dampers and springs that are fast beside the motion of interest. Newton's method solves its
// implicit equations with the exact Jacobian (dual numbers), about every sixty steps a new one. Adams is more accurate per step
// where the motion is smooth and not stiff. On a pendulum a step costs 1.1 µs (BDF) to 1.3 µs (Adams) of CVODE's own, and about
// 1.1 evaluations; dense output adds half a microsecond. Functional iteration, an option of Adams, took 1.3 to 2.3 times the
// evaluations of Newton's at the same accuracy, and failed where the motion turns stiff for a while. So Newton is the default.
//
// Reference: A. C. Hindmarsh et al., SUNDIALS: Suite of nonlinear and differential/algebraic equation solvers, ACM TOMS 31
// (2005) 363–396.

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "qdot/integrate/cvode_stepper.hpp"
#include "qdot/integrate/stepper.hpp"
#include "qdot/integrate/watch/any_form.hpp"
#ifndef QDOT_COMPILED
#include "qdot/integrate/driver/any_form_of.hpp"
#endif

namespace qdot {

/// Backward differentiation formulas with Newton's method and the exact Jacobian; for stiff systems.
struct CvodeBdf {
  static constexpr std::string_view name = "cvode_bdf";  ///< as statistics call it
  using MakerOfSteppers = CvodeBdf;                      ///< integrate/watch/any_form.hpp

  int max_order = 5;                                      ///< 1 … 5
  std::function<void(std::string_view)> on_message = {};  ///< sink for SUNDIALS' own messages

  /// A stepper for `system`, which it copies. Allocates all its memory here.
  template <FirstOrderSystem F>
  CvodeStepper stepper(const F& system, const Options& options) const {
    return CvodeStepper(system, settings(), options);
  }
  /// A stepper of so many components for a system whose type is hidden.
  template <int size>
  CvodeStepper stepper_of_form(const std::shared_ptr<const detail::AnyForm>& form, const Options& options) const {
    return CvodeStepper(form->method_form(), settings(), options);
  }

 private:
  CvodeSettings settings() const { return {std::string(name), CV_BDF, max_order, Corrector::newton, on_message}; }
};

/// Adams–Moulton formulas of variable order; for smooth motion that is not stiff.
struct CvodeAdams {
  static constexpr std::string_view name = "cvode_adams";  ///< as statistics call it
  using MakerOfSteppers = CvodeAdams;                      ///< integrate/watch/any_form.hpp

  int max_order = 12;                                     ///< 1 … 12
  Corrector corrector = Corrector::newton;                ///< Newton also where the motion turns stiff for a while
  std::function<void(std::string_view)> on_message = {};  ///< sink for SUNDIALS' own messages

  /// A stepper for `system`, which it copies. Allocates all its memory here.
  template <FirstOrderSystem F>
  CvodeStepper stepper(const F& system, const Options& options) const {
    return CvodeStepper(system, settings(), options);
  }
  /// A stepper of so many components for a system whose type is hidden.
  template <int size>
  CvodeStepper stepper_of_form(const std::shared_ptr<const detail::AnyForm>& form, const Options& options) const {
    return CvodeStepper(form->method_form(), settings(), options);
  }

 private:
  CvodeSettings settings() const { return {std::string(name), CV_ADAMS, max_order, corrector, on_message}; }
};

}  // namespace qdot
