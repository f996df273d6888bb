#pragma once
// SPDX-License-Identifier: MIT
//
// The driver: from t₀ to t_end with any method.
//
//     const auto run = simulate(system, State<2>{0.0, q, qdot}, 10.0, CvodeBdf{}, {.rtol = 1e-10});
//     if (!run.completed()) std::cerr << run.message << '\n';
//     const auto half_way = run.trajectory.at(5.0);
//
// The run ends at t_end, or earlier with a named outcome; between, it lands on stop times, fills output times, calls
// an observer and takes events. integrate/driver/driver.hpp is the loop.
//
// Before the first step errors are exceptions; after it they are outcomes, except for exceptions of
// the user's own, which are passed on unchanged (and take the run with them).

#include <Eigen/Core>
#include <memory>
#include <type_traits>
#include <utility>

#include "qdot/integrate/any_stepper.hpp"
#include "qdot/integrate/driver/drive.hpp"
#include "qdot/integrate/driver/run_of_energies.hpp"
#include "qdot/integrate/driver/run_of_form.hpp"
#include "qdot/integrate/driver/run_request.hpp"
#include "qdot/integrate/event.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/integrate/stepper.hpp"
#include "qdot/integrate/watch/any_form.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot {

namespace detail {

// Methods that need rates alone.
template <class Method, int size>
concept MethodOfRatesAlone = requires { typename Method::template StepperOfRates<size>; };
// Whether a run depends on the number of coordinates alone: of a system of few, whose T and V can be recorded, by such a method.
template <class System, class Method>
inline constexpr bool has_hidden_run = false;
template <class E, int n, class Method>
inline constexpr bool has_hidden_run<System<E, n, Inertia::positive_definite>, Method> =
    may_have_rates<n> && RecordableEnergies<E, n> && (MethodOfRatesAlone<Method, 2 * n> || MethodOfAnyForm<Method, 2 * n>);

// Of a method for so many components.
template <int size, class Method>
auto hidden_method(const Method& method) {
  if constexpr (MethodOfRatesAlone<Method, size>) {
    return MethodOfRates{stepper_of_rates<typename Method::template StepperOfRates<size>>, Method::name};
  } else {
    return MethodOfForm{&method, [](const void* settings, std::shared_ptr<const AnyForm> form, const Options& options) {
                          return AnyStepper::made_by([&] { return static_cast<const Method*>(settings)->template stepper_of_form<size>(form, options); });
                        }};
  }
}

}  // namespace detail

/// Runs a system from its start to t_end, forward or backward in time.
///
/// Keeps dense output of every step unless options.keep_trajectory is off. With t_end equal to the
/// start's time the run is complete at once and returns the start.
///
/// @param system    a mechanical system, or anything that models FirstOrderSystem
/// @param start     State{t, q, qdot}, or FirstOrderState{t, y}
/// @param t_end     where to land exactly
/// @param method    CvodeBdf{}, CvodeAdams{}, …: anything that makes a Stepper
/// @param options   accuracy, output, limits
/// @param observer  called after every accepted step with a StepView; may return false or Control::stop
/// @param events    one event(…), or events(event(…), …): zero crossings to record, to stop at, or that change the state
/// @return          outcome, last good state, trajectory, samples, events, statistics
/// @throws DimensionError, InvalidValue  wrong sizes, T or V that read more entries than there are coordinates, NaN in the start,
///                                       options outside their range
/// @throws NonFinite, MassMatrixError    the equations of motion cannot be evaluated at the start
/// @throws                               whatever the user's functors and observer throw
template <class System, class Start, class Method, Observer O, class... Events>
auto simulate(const System& system, const Start& start, double t_end, const Method& method, const Options& options,
              O&& observer, const EventList<Events...>& events) {
  constexpr bool is_observed = !std::is_same_v<std::remove_cvref_t<O>, NoObserver>, has_events = sizeof...(Events) > 0;
  auto show = [&observer](const StepView& step) {
    using Answer = std::invoke_result_t<O&, const StepView&>;
    if constexpr (std::is_void_v<Answer>) return observer(step), true;
    else if constexpr (std::is_same_v<Answer, bool>) return observer(step);
    else return observer(step) == Control::proceed;
  };
  const detail::Onlooker onlooker{&show, [](void* shown, const StepView& step) { return (*static_cast<decltype(show)*>(shown))(step); }};
  if constexpr (detail::has_hidden_run<System, Method>) {
    constexpr int n = System::dof_at_compile_time;
    constexpr bool timed = !System::autonomous;
    return detail::RunOfEnergies<n, timed>::by(
        detail::hidden_method<2 * n>(method), detail::AnyEnergies<n, timed>(system.energies()), system.parts(), detail::numbers_of<n>(start),
        {start.t, t_end, options, detail::drive<has_events, is_observed>, onlooker, detail::listed_events<n>(events)});
  } else {
    const auto form = detail::form_by(system, options.by);
    using Form = std::remove_cvref_t<decltype(form)>;
    static_assert(SteppingMethod<Method, Form>, "qdot: the method cannot make a stepper for this system");
    constexpr int n = detail::dof_at_compile_time<Form>();
    constexpr bool watches = has_events || SwitchingSystem<Form>;
    const auto stepper = [&method](const Form& stepped, const Options& of_run) { return any_stepper(method, stepped, of_run); };
    return detail::run_of<n>(detail::run_of_form(
        form, stepper, detail::packed(form, start),
        {start.t, t_end, options, detail::drive<watches, is_observed>, onlooker, detail::listed_events<n>(events)}));
  }
}

/// Simulates without events, with an observer or none.
template <class System, class Start, class Method, Observer O = NoObserver>
auto simulate(const System& system, const Start& start, double t_end, const Method& method, const Options& options = {},
              O&& observer = {}) {
  return simulate(system, start, t_end, method, options, observer, EventList<>{});
}

/// Simulates with an observer and a single event.
template <class System, class Start, class Method, Observer O, class G, class Action>
auto simulate(const System& system, const Start& start, double t_end, const Method& method, const Options& options, O&& observer,
              const Event<G, Action>& event) {
  return simulate(system, start, t_end, method, options, observer, events(event));
}

/// Simulates with an event or events(…), without an observer.
template <class System, class Start, class Method, class Happening>
  requires detail::is_event<Happening>
auto simulate(const System& system, const Start& start, double t_end, const Method& method, const Options& options, const Happening& happening) {
  return simulate(system, start, t_end, method, options, NoObserver{}, happening);
}

/// Simulates with the events before the observer.
template <class System, class Start, class Method, class Happening, Observer O>
  requires detail::is_event<Happening>
auto simulate(const System& system, const Start& start, double t_end, const Method& method, const Options& options, const Happening& happening, O&& observer) {
  return simulate(system, start, t_end, method, options, std::forward<O>(observer), happening);
}

/// Simulates with default options, an observer and events in either order.
template <class System, class Start, class Method, class First, class Second>
  requires(detail::is_event<std::remove_cvref_t<First>> != detail::is_event<std::remove_cvref_t<Second>>) && (Observer<First> != Observer<Second>)
auto simulate(const System& system, const Start& start, double t_end, const Method& method, First&& first, Second&& second) {
  return simulate(system, start, t_end, method, Options{}, std::forward<First>(first), std::forward<Second>(second));
}

/// Simulates with default options, and an observer or events.
template <class System, class Start, class Method, class Further>
  requires(detail::is_event<std::remove_cvref_t<Further>> || Observer<Further>)
auto simulate(const System& system, const Start& start, double t_end, const Method& method, Further&& further) {
  return simulate(system, start, t_end, method, Options{}, std::forward<Further>(further));
}

/// Without a method nothing can be simulated.
template <class System, class Start>
void simulate(const System&, const Start&, double, const Options& = {}) {
  static_assert(std::is_void_v<System>,
                "qdot: simulate() needs a method after t_end: Automatic{} of <qdot/integrate/cvode_automatic.hpp>, which chooses, or Dop853{} of "
                "<qdot/integrate/runge_kutta.hpp>, which needs no SUNDIALS");
}

}  // namespace qdot
