#pragma once
// SPDX-License-Identifier: MIT
//
// Taylor steps: the motion's own power series, as far as the accuracy asks, which *is* the dense output.
//
// Each step computes the series of q and q̇ to order p (integrate/steps/taylor_equations.hpp) and evaluates it at t + h. With radius of
// convergence ρ it errs by about (h/ρ)^p, and one more order costs ~ p operations of p² in all. The cheapest pair for an error ε is
//
//     h = ρ/e² ,      p = 1 − ½ ln ε          8, 12, 15, 20 for 1e-6, 1e-9, 1e-12, 1e-16   (plus a little: orders are cheap).
//
// With a_j = max_i |y_{i,j}| / (rtol |y_i| + atol_i) and σ = ε^{1/(p+1)}, coefficient j foretells an error of a_j h^j σ^{p+1−j}. Of the
// last six *each* must foretell less than one unit: after a start at rest every second one is zero. All may vanish and the series still
// be wrong (ẍ = −x¹⁵ from x = 0). So h |P′(h) − f(P(h))| / (p + 1) is tested, where the next expansion starts anyway. It is the error of
// P(h) if that grows like h^{p+1}. Reference: À. Jorba, M. Zou, Experimental Mathematics 14 (2005) 99.
//
// Effects and constraints that are formulas take part, and functors that compare (steps/taylor_branches.hpp). What does not fit: functors
// that ask for plain numbers, constraints that branch, contacts, friction that sticks, stiff systems.

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
