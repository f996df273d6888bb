#pragma once
// SPDX-License-Identifier: MIT
//
// Taylor steps: the motion's own power series, as far as the accuracy asks.
//
//     const auto run = simulate(system, start, 10.0, Taylor{}, {.rtol = 1e-13, .atol = 1e-15});
//
// At each step the series of q and q̇ about the present state are computed to order p
// (integrate/steps/taylor_equations.hpp) and evaluated at t + h. The series *is* the dense output.
//
// Order. A series with radius of convergence ρ, cut after order p and used at h, errs by about (h/ρ)^p. One more order costs ~ p
// operations of p² in all. The cheapest pair for an error ε is h = ρ/e² with
//
//     p = 1 − ½ ln ε          8, 12, 15, 20 for 1e-6, 1e-9, 1e-12, 1e-16   (plus a little: orders are cheap).
//
// Step. With a_j = max_i |y_{i,j}| / (rtol |y_i| + atol_i), each component by its own measure, and σ = ε^{1/(p+1)}
// the ratio h/ρ aimed at, coefficient j foretells an error of a_j h^j σ^{p+1−j} in order p + 1. The step is the
// longest for which *each of the last six* coefficients foretells less than one unit. One or two would not do:
// a pendulum released at rest has every second coefficient zero, from the horizontal three of four.
//
// Test. Coefficients may all vanish and the series still be wrong: ẍ = −x¹⁵ from x = 0 begins t + 0 t² + …,
// and a foretold error of zero allows any step. So no step is believed. At its end, where the next expansion
// starts anyway and gives f(y₁) at once, the polynomial P must fulfil the equation it solves:
//
//     h |P′(h) − f(P(h))| / (p + 1)    is the error of P(h) if that grows like h^{p+1}.
//
// If it exceeds the tolerance (beyond the rounding of the subtraction itself), the step is rejected and a shorter one is
// evaluated from the same series. A rejection costs one evaluation, not an expansion.
//
// Sums are compensated (integrate/steps/fixed_step.hpp), so that rounding does not pile up with the number of steps. What the
// series leaves out has a sign, though, and pulls the energy one way step after step, 5e-13 over 10⁴ Kepler
// periods at rtol = 2.5e-15. So with rtol < 1e-14 the foretold error must stay 256 times below a unit: half as many
// steps again, and the energy walks at random, 1e-14 over the same time.
//
// Scenes. Effects that are formulas take part: forces, dissipation, drag, drives, springs, potentials, controllers with states, and
// constraints (integrate/steps/taylor_constraints.hpp). Where there are some, P(h) is projected onto them before the next expansion starts there,
// so that the test compares with the equations on the constraints. A step whose end cannot be projected is rejected. Six rejections in a row
// beside rows that are nearly dependent are a singular position, and end the run as constraint_failure.
//
// Recordings. At each reset the functors are run again, which costs a few hash look-ups for each of their operations. Where their
// formulas or constants have changed, everything is made anew. The driver asks for the same at its looks.
//
// Branches. Functors that compare have a series on each branch, and a step ends where the motion leaves the branch that it is on
// (integrate/steps/taylor_branches.hpp). Where there are none, that costs nothing.
//
// What does not fit: functors that ask for plain numbers and constraints that branch (NotAnalytic). At points where formulas are
// not analytic (a root or a broken power of zero) the outcome is non_finite. Contacts and friction that sticks are refused by the
// compiler. Nor do stiff systems fit.
//
// Reference: À. Jorba, M. Zou, A software package for the numerical integration of ODEs by means of
// high-order Taylor methods, Experimental Mathematics 14 (2005) 99.

#include <memory>
#include <string_view>

#include "qdot/integrate/any_stepper.hpp"
#include "qdot/integrate/stepper.hpp"
#include "qdot/integrate/steps/taylor_branches.hpp"
#include "qdot/integrate/steps/taylor_stepper.hpp"
#include "qdot/integrate/watch/any_form.hpp"
#ifndef QDOT_COMPILED
#include "qdot/integrate/driver/any_form_of.hpp"
#endif

namespace qdot {

namespace detail {

/// The stepper of a system whose type is hidden, with so many components.
template <int size>
AnyStepper taylor_stepper(const AnyForm& form, int order, const Options& options) {
  const auto series = [&](int highest_order) { return power_series(form.motion_source(), highest_order); };
  return AnyStepper::made_by([&] { return TaylorStepper<size>(form.rates(), series, order, options); });
}

#ifdef QDOT_COMPILED
extern template AnyStepper taylor_stepper<2>(const AnyForm&, int, const Options&);
extern template AnyStepper taylor_stepper<4>(const AnyForm&, int, const Options&);
extern template AnyStepper taylor_stepper<6>(const AnyForm&, int, const Options&);
#endif

}  // namespace detail

/// Taylor series of the motion: energies and forces that are smooth, or smooth by pieces; 1e-9 to 1e-15, long runs at full accuracy.
struct Taylor {
  static constexpr std::string_view name = "taylor";  ///< as statistics call it
  using MakerOfSteppers = Taylor;                     ///< integrate/watch/any_form.hpp

  int order = 0;  ///< 4 … 60; 0: chosen from rtol

  /// A stepper for `system`, which it copies; runs T, V and the effects once to record them. Allocates all its memory here, but for machine
  /// code that is made after some thirty steps.
  ///
  /// What branches is recorded on each branch that a motion meets: then, and not here.
  template <FirstOrderSystem F>
    requires requires { detail::Mechanics<F>::n; }
  TaylorStepper<F::size_at_compile_time> stepper(const F& system, const Options& options) const {
    static_assert(!SwitchingSystem<F>,
                  "qdot: the Taylor method takes no contacts or dry friction, whose equations switch; use Dop853, CvodeBdf or Gauss");
    static_assert(detail::is_recordable<F>::value,
                  "qdot: the Taylor method runs T, V and the effects once with a scalar that records operations, but they do not "
                  "take every scalar: take `const auto& q`, or make them a template <class S>; or use Dop853");
    return {detail::rates_of(system), [&](int highest_order) { return detail::PowerSeriesOf<F>::made(system, highest_order); }, order, options};
  }
  /// A stepper of so many components for a system whose type is hidden.
  template <int size>
  AnyStepper stepper_of_form(const std::shared_ptr<const detail::AnyForm>& form, const Options& options) const {
    return detail::taylor_stepper<size>(*form, order, options);
  }
};

}  // namespace qdot
