#pragma once
// SPDX-License-Identifier: MIT
//
// Outcomes: how a run ended.
//
// A run from t₀ to t_end can end in more ways than "done" and "crashed". The observer had seen enough, or a budget of steps or
// seconds was spent. The model gave NaN at t = 0.73. The solution runs away to infinity and the step shrinks to nothing in front of
// the pole. In all of these the motion *up to there* is good, and the user needs it to find out why. So they are values and not
// exceptions: an Outcome has a name that programs compare and logs print, and one sentence of advice. The driver adds a message
// with the numbers: t, h, order, component.
//
//     completed                             t_end was reached
//     stopped_by_observer … state_limit     the user asked for this end
//     non_finite … solver_error             the run failed
//
// Exceptions remain for what is wrong before the first step (sizes, NaN, tolerances), and for exceptions of the user's own.

#include <string>
#include <string_view>
#include <utility>

#include "qdot/error.hpp"

namespace qdot {

/// How a run ended. Later methods and effects add to this list; none is ever renumbered by meaning.
enum class Outcome {
  completed,              ///< t_end was reached
  stopped_by_observer,    ///< an observer asked to stop
  stopped_by_model,       ///< the right-hand side threw StopRequest
  stopped_by_event,       ///< an event asked to stop; the last end that is no failure
  step_limit,             ///< options.max_steps were taken
  evaluation_limit,       ///< options.max_evaluations were spent
  time_limit,             ///< options.max_wall_seconds were spent
  state_limit,            ///< a component exceeded options.state_norm_limit
  non_finite,             ///< the right-hand side (or its Jacobian) gave NaN or infinity at every step size tried
  singular_mass_matrix,   ///< M could not be factored at any step size tried, or its condition fell below options.rcond_limit
  constraint_failure,     ///< the constraints contradict each other, or could not be met, at every step size tried
  refused_by_model,       ///< the model threw RecoverableError at every step size tried, or T or V jumps, which is a blow
  invalid_change,         ///< an event's action set the time, or another size of the state
  zeno,                   ///< events followed each other without end before t could go on, or each branch led back to the other
  step_too_small,         ///< the error test failed down to the smallest step that t can still feel
  error_test_failure,     ///< the error test failed too often in one step
  corrector_failure,      ///< the implicit equations of a step could not be solved
  linear_solver_failure,  ///< the linear equations of a step could not be solved
  accuracy_not_reached,   ///< what was asked for needs more digits than double has
  model_changed,          ///< a functor gives another value than before at the same time and state
  not_differentiable,     ///< derivatives of the motion were asked for (analysis/sensitivity.hpp), and at an event there are none
  energy_drift,           ///< T and V conserve an energy, but it changed far more than the tolerances allow
  solver_error,           ///< the method reports a fault of its own; please report it
  event_accumulation [[deprecated("qdot: say zeno")]] = zeno,                ///< the old name of zeno, accepted until 0.4
  step_collapse [[deprecated("qdot: say step_too_small")]] = step_too_small  ///< the old name of step_too_small, accepted until 0.4
};

/// The outcome's name as printed in JSON and compared in tests, e.g. "completed".
constexpr std::string_view name(Outcome outcome) noexcept {
  return detail::name_in(
      {"completed",          "stopped_by_observer", "stopped_by_model",      "stopped_by_event",     "step_limit",
       "evaluation_limit",   "time_limit",          "state_limit",           "non_finite",           "singular_mass_matrix",
       "constraint_failure", "refused_by_model",    "invalid_change",        "zeno",                 "step_too_small",
       "error_test_failure", "corrector_failure",   "linear_solver_failure", "accuracy_not_reached", "model_changed",
       "not_differentiable", "energy_drift",        "solver_error"},
      outcome);
}

/// One sentence on what to do about the outcome.
constexpr std::string_view advice(Outcome outcome) noexcept {
  switch (outcome) {
    case Outcome::completed: return "nothing to do.";
    case Outcome::stopped_by_observer: return "continue from the last state if the observer stopped too early.";
    case Outcome::stopped_by_model: return "look at the condition under which the model throws StopRequest.";
    case Outcome::stopped_by_event: return "continue from the last state if the event was not the one to stop at.";
    case Outcome::step_limit: return "raise max_steps, relax the tolerances, or ask why the steps are so small.";
    case Outcome::evaluation_limit:
      return "raise max_evaluations, relax the tolerances, or ask why the steps are so small.";
    case Outcome::time_limit: return "raise max_wall_seconds, or relax the tolerances.";
    case Outcome::state_limit:
      return "the motion left the range that state_norm_limit allows; look for a missing force.";
    case Outcome::non_finite:
      return "evaluate the model at the last state: look for a division by zero, or a root or logarithm of a negative "
             "number.";
    case Outcome::singular_mass_matrix:
      return "some direction of motion lost its inertia; choose other coordinates, or add the missing mass.";
    case Outcome::constraint_failure:
      return "look at the constraint that is named: it depends on the others there, or cannot be met together with them.";
    case Outcome::refused_by_model: return "look at the condition under which the model throws RecoverableError, or at what jumps.";
    case Outcome::invalid_change: return "let the action of the event change the numbers in q and qdot, and nothing else.";
    case Outcome::zeno:
      return "infinitely many impacts come to rest here: give the system a resting phase, as contact() has, or stop at "
             "the event.";
    case Outcome::step_too_small:
      return "the solution may run to infinity here, or the right-hand side may jump: bound the run before this time, "
             "or give the time of the jump in stop_times.";
    case Outcome::error_test_failure:
      return "the right-hand side may jump: give the time of the jump in stop_times, or loosen atol of the component.";
    case Outcome::corrector_failure:
      return "the Jacobian may be wrong or the right-hand side may jump; check both at the last state.";
    case Outcome::linear_solver_failure: return "check the Jacobian at the last state for huge or missing entries.";
    case Outcome::accuracy_not_reached: return "ask for less accuracy (raise rtol and atol), or for a shorter time.";
    case Outcome::model_changed:
      return "change what functors read in the action of an event or at a stop time (stop_times), or make it the state of a "
             "controller(Q, zdot, z0).";
    case Outcome::not_differentiable:
      return "choose a start or parameters whose motion meets its events one at a time and not at a tangent, or end the run before.";
    case Outcome::energy_drift:
      return "let T and V be smooth and depend on nothing but their arguments: T(q, qdot, t) or V(q, t) where the time matters, "
             "an event where V jumps; or tighten rtol and atol; or raise energy_drift_limit.";
    case Outcome::solver_error: return "please report this message together with the program that gave it.";
  }
  return "";
}

/// True when the run ended for a reason that the user did not ask for.
constexpr bool failed(Outcome outcome) noexcept { return outcome > Outcome::stopped_by_event; }

/// Thrown by a model to end the run in good order: the trajectory up to the last accepted step is kept.
class StopRequest : public Error {
 public:
  using Error::Error;
};

/// Why a step could not be taken: the outcome, and a sentence with the numbers.
struct Failure {
  Outcome outcome = Outcome::solver_error;  ///< what kind of failure
  std::string message;                      ///< with the numbers
};

namespace detail {

// Thrown where an action or a system itself finds that the run cannot go on, with the outcome it ends with.
struct EndOfRun : Error {
  explicit EndOfRun(Failure why) : Error(why.message), failure(std::move(why)) {}
  Failure failure;
};

}  // namespace detail
}  // namespace qdot
