#pragma once
// SPDX-License-Identifier: MIT
//
// CVODE's two families of multistep methods, for any system that can be stepped.
//
//     CvodeBdf      backward differentiation formulas, order 1 to 5:  Σ αᵢ yₙ₋ᵢ = h f(tₙ, yₙ)
//                   stable for stiff motion: dampers and springs that are fast beside the motion of
//                   interest. Each step solves its implicit equations by Newton's method with the
//                   exact Jacobian of the system (dual numbers; never a difference quotient).
//     CvodeAdams    Adams–Moulton formulas, order 1 to 12:  yₙ = yₙ₋₁ + h Σ βᵢ f(tₙ₋ᵢ, yₙ₋ᵢ)
//                   more accurate per step where the motion is smooth and not stiff.
//
//     const auto run = simulate(system, start, 10.0, CvodeBdf{}, {.rtol = 1e-10});
//
// What a step costs, measured on a pendulum: 1.1 µs (BDF) to 1.3 µs (Adams) of CVODE's own, and about
// 1.1 evaluations of the right-hand side; dense output adds half a microsecond. A Jacobian is needed
// every sixty steps. Adams may also be corrected by functional iteration. On pendulums and chains at tolerances from 1e-6 to
// 1e-12 that took 1.3 to 2.3 times the evaluations of Newton's iteration at the same accuracy. It was as fast for one or two
// coordinates and slower beyond. It failed where the motion turns stiff for a while, so Newton is the default.
//
// Reference: A. C. Hindmarsh et al., SUNDIALS: Suite of nonlinear and differential/algebraic equation
// solvers, ACM TOMS 31 (2005) 363–396.

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
