#pragma once
// SPDX-License-Identifier: MIT
//
// What a method must offer to be driven.
//
// A method (Dop853, Taylor, CvodeBdf …) is a small value with its settings. For a system and options it makes a stepper:
//
//     auto stepper = method.stepper(system, options);      allocates everything it will ever need, but for machine code
//     stepper.reset(t, y);                                 start, or start afresh after a jump; at any time, also after a failure
//     while (stepper.t() != t_limit)
//       if (!stepper.step(t_limit)) → stepper.failure()    one accepted step, never past t_limit
//
// The driver builds output, observers, events and constraints from step, polynomial and reset, so they work with every method. A
// concept verifies the spelling only. The rest is a contract: reset() forgets all history and makes anew what was recorded or
// factored of functors; the direction of time is that of the next t_limit. step() evaluates f in front of t_limit only, at most a
// rounding unit from it, so that a switch there is not felt early. When it returns false, t() and y() are those of the last good
// step. Exceptions of the user's functors leave both as they are.

#include <Eigen/Core>
#include <concepts>

#include "qdot/integrate/time_point.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/statistics.hpp"
#include "qdot/integrate/steps/polynomial.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot {

/// An integration method bound to one system, with the memory of one run.
///
/// reset() evaluates f at its start and throws its typed errors; it may also take a TimePoint. time_point() says where t() is, counted from the
/// origin (time_point.hpp). A stepper that counts in t alone may leave it out: then short steps at a large t are as rough as its t is. Neither
/// reset() nor step() allocates, but for machine code and to read the model again. y() shows the state that the stepper keeps, not a copy.
/// polynomial() is valid until the next step or reset, and its value at t() is y() up to rounding. reset() does not clear statistics().
template <class S>
concept Stepper =
    std::movable<S> && requires(S& s, const S& c, double t, const Eigen::VectorXd& y, Eigen::Ref<Eigen::VectorXd> out) {
      s.reset(t, y);                                                        // start at (t, y)
      { s.step(t) } -> std::same_as<bool>;                                  // one accepted step towards t
      { c.failure() } -> std::convertible_to<const Failure&>;               // after step() returned false
      { c.t() } -> std::convertible_to<double>;                             // end of the last step
      { c.t_previous() } -> std::convertible_to<double>;                    // its beginning
      { c.y() } -> std::convertible_to<Eigen::Ref<const Eigen::VectorXd>>;  // state at t()
      { s.polynomial() } -> std::same_as<PolynomialView>;                   // dense output of the last step
      { s.interpolate(t, out) };                                            // out ← y(t) within the last step
      { c.order() } -> std::convertible_to<int>;                            // of the last step
      { c.statistics() } -> std::convertible_to<const Statistics&>;         // counts so far
    };

/// A stepper whose state may be replaced by a nearby one between steps, without a fresh start.
///
/// correct(y) keeps the step size and the dense output of the last step. One-step methods can do that; a multistep
/// method, whose past would no longer fit, must project inside its step instead; then projects_itself() returns true.
template <class S>
concept CorrectableStepper = Stepper<S> && requires(S& s, const Eigen::VectorXd& y) { s.correct(y); };

/// A stepper that projects inside its steps where the system has constraints.
template <class S>
concept SelfProjectingStepper = Stepper<S> && requires { requires S::projects_itself; };

namespace detail {

/// Whether the length of a stepper's steps is the user's choice.
template <Stepper S>
constexpr bool has_fixed_step(const S& stepper) {
  if constexpr (requires { stepper.has_fixed_step(); }) {
    return stepper.has_fixed_step();
  } else {
    return false;
  }
}

}  // namespace detail

/// A method's settings, from which it makes a stepper for a system.
template <class M, class F>
concept SteppingMethod = FirstOrderSystem<F> && (requires { typename M::template StepperOfRates<F::size_at_compile_time>; } ||  // by rates alone
                                                  requires(const M& method, const F& system, const Options& options) {
                                                    { method.stepper(system, options) } -> Stepper;
                                                  });

}  // namespace qdot
