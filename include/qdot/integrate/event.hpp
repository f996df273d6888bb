#pragma once
// SPDX-License-Identifier: MIT
//
// Events: moments at which a function of the motion crosses zero.
//
//     simulate(system, start, t_end, Dop853{}, {},
//              events(event("apex", [](const auto& q, const auto& qdot) { return qdot[1]; }).falling(),
//                     event("floor", [](const auto& q) { return q[1]; }).falling().stop(),
//                     every("controller", 0.01).action([&](State<2>& s) { force = -K * s.q; })));
//
// g(q), g(q, q̇), g(q, q̇, t), or g(q, q̇, z, t) with the effects' own states z, is watched on the dense output of every step. So all
// methods have events, and no stepper has code for them. The run keeps the time and name of each (Run::events). An event then
// records and costs nothing but the search, ends the run with .stop(), or changes the state with .action(f).
//
// The search (integrate/driver/event_finder.hpp) follows a g that is much faster than the motion. A short excursion across zero may
// lie between all samples, unless g is declared a .formula(): then intervals prove that none was passed over. What could not be
// followed is counted in Statistics::unresolved_events and reported in the run's message, for then roots may have been missed.

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "qdot/ad/forward/functor_result.hpp"
#include "qdot/ad/vector.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot {

/// Which crossings of zero count, in the direction in which the run goes.
enum class Direction {
  either,   ///< all
  falling,  ///< g goes from positive to negative along the run
  rising    ///< from negative to positive
};

/// What was found: when, and which.
struct RecordedEvent {
  double t = 0.0;    ///< when
  std::string name;  ///< of the event
};

namespace detail {

struct RecordOnly {};
struct StopThere {};

// The times of an event of a clock; in place of a function, which as such has no zeros.
struct Timetable {
  double period = 1.0;
  double first = std::numeric_limits<double>::quiet_NaN();  // NaN: the start of the run

  double operator()(const auto&) const { return 1.0; }
};

// A function that takes every scalar, by the word of its user.
template <class G>
struct ForEveryScalar : G {
  static constexpr bool is_formula = true;
};

}  // namespace detail

/// A function to watch and what to do when it crosses zero. Made by event().
template <class G, class Action = detail::RecordOnly>
struct Event {
  std::string name;  ///< as it is recorded
  G g;  ///< zero where it happens; of q, (q, q̇) or (q, q̇, t)
  Direction direction = Direction::either;  ///< which crossings count
  Action change;  ///< what it does to the state; without an initializer, for it may have no default, which clang asks for

  static constexpr bool records = std::is_same_v<Action, detail::RecordOnly>;  ///< whether it only looks
  static constexpr bool stops = std::is_same_v<Action, detail::StopThere>;     ///< whether it ends the run
  /// True when the action turns g back to g ≥ 0, as an impact does: then g < 0 is never passed without it.
  static constexpr bool is_barrier = requires { requires Action::is_barrier; };
  /// True when zeros of g are proved.
  static constexpr bool is_formula = requires { requires G::is_formula; };

  /// True when it happens by the clock.
  static constexpr bool is_timed = std::is_same_v<G, detail::Timetable>;

  /// Counts only where g becomes negative.
  Event falling() const {
    static_assert(!is_timed, "qdot: an event of a clock, every(), has no direction");
    return {name, g, Direction::falling, change};
  }

  /// Counts only where g becomes positive.
  Event rising() const {
    static_assert(!is_timed, "qdot: an event of a clock, every(), has no direction");
    return {name, g, Direction::rising, change};
  }

  /// Says that g is a formula that takes every scalar: it is then called with intervals too, which prove that no zero is passed over,
  /// however short the excursion.
  ///
  /// One or two evaluations in intervals for a step in which g is slow. A comparison in g is allowed; what it leaves undecided, and what
  /// touches zero to within rounding, is counted in Statistics::unresolved_events.
  Event<detail::ForEveryScalar<G>, Action> formula() const {
    static_assert(!is_timed, "qdot: an event of a clock, every(), needs no formula: its times are known");
    static_assert(std::is_class_v<G>, "qdot: a formula must take every scalar, and a plain function takes one: write a lambda with const auto&");
    return {name, {g}, direction, change};
  }

  /// Ends the run.
  Event<G, detail::StopThere> stop() const { return {name, g, direction, {}}; }

  /// An event that changes the state: how(State<n>& s), or how(double t, Eigen::VectorXd& y) for all of y.
  ///
  /// The method starts afresh from the changed state; Trajectory::before(t) and at(t) are the two sides of the jump. What lasting constraints
  /// forbid of the change is taken back by projection. A closed contact opens by a kick, or where its gap is moved; friction that sticks slips.
  /// NaN or infinity ends the run as non_finite, another time or size of the state as invalid_change.
  ///
  /// Afterwards g counts again once it has left zero. An action that turned or stopped g lets it leave to the side it came from. Events that
  /// follow each other as closely as t can tell end the run as zeno; those that only record are counted in Statistics::unresolved_events.
  template <class Change>
  [[nodiscard("qdot: action(how) returns another event; change is what it does")]] Event<G, Change> action(Change how) const {
    return {name, g, direction, std::move(how)};
  }
  /// The old name of action(), accepted until 0.4.
  template <class Change>
  [[deprecated("qdot: say action()")]] Event<G, Change> then(Change how) const {
    return action(std::move(how));
  }
};

/// The event that g(q), g(q, qdot), g(q, qdot, t) or g(q, qdot, z, t) is zero, z the effects' own states; by itself it is recorded, in either direction.
///
/// Motion of g through zero is an event; a jump across zero, a pole and g ≡ 0 are none, a jump onto zero is one. Its time is the first double on
/// the far side of the root. Where g stays zero, it is where that begins, or where it ends if g was zero at the start. g = 0 at the start counts
/// if g then moves in the asked direction. What begins at zero to within the tolerance has no events, where they only record, before it has left
/// that. Two roots close together are found when g gets farther across zero than its extremum is known. All roots of a step are taken in the
/// order of time, those at the same time in the order of the list.
///
/// @param name  as it appears in Run::events
/// @param g     real and continuous; called some ten times for each step, and for each of its own fast turns
template <class G>
Event<G> event(std::string name, G g) {
  return {std::move(name), std::move(g), Direction::either, {}};
}

/// The event that happens each time a period has passed; by itself it is recorded.
///
/// It happens while t < t_end, the k-th time at t₀ + k · period and not at a sum; what functors read may change there, as for a digital controller.
/// Each time costs a landing, and with an action a fresh start of the method: for many times a second a one-step method is the right one.
/// Forward runs only.
///
/// @param period  positive, in units of t
/// @param first   when it happens first; left out, at the start of the run. Times before the start are passed over
/// @throws InvalidValue  a period that is not positive and finite, a first time that is not finite
inline Event<detail::Timetable> every(std::string name, double period) {
  if (!(period > 0.0) || !std::isfinite(period))
    detail::throw_invalid_value({"the period of event '", name, "' must be positive and finite, but is ", period, "; give the time between two of them"});
  return {std::move(name), {period}, Direction::either, {}};
}
inline Event<detail::Timetable> every(std::string name, double period, double first) {
  if (!std::isfinite(first))
    detail::throw_invalid_value({"the first time of event '", name, "' must be finite, but is ", first, "; leave it out for the start of the run"});
  Event<detail::Timetable> result = every(std::move(name), period);
  result.g.first = first;
  return result;
}

/// The events of a run. Made by events().
template <class... Events>
struct EventList {
  std::tuple<Events...> list;  ///< in the order given
};

/// A list of events for simulate(), in any order.
template <class... Events>
EventList<Events...> events(Events... each) {
  return {{std::move(each)...}};
}
template <class... Events>
EventList<Events...> events(EventList<Events...> list) { return list; }

namespace detail {

// One event, or a list of them.
template <class Happening>
inline constexpr bool is_event = false;
template <class G, class Action>
inline constexpr bool is_event<Event<G, Action>> = true;
template <class... Events>
inline constexpr bool is_event<EventList<Events...>> = true;

using OwnStates = Eigen::Map<const Eigen::VectorXd>;  // z in y = [q; q̇; z]

// g at y in whichever form the user wrote it; n coordinates.
template <int n, class G>
double event_value(const G& g, double t, const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Index dof) {
  using Q = Vector<double, n>;
  const Eigen::Index count = dof > 0 ? dof : y.size();
  const Q q = Eigen::Map<const Q>(y.data(), count);
  const Q qdot = Eigen::Map<const Q>(y.data() + dof, count);
  if constexpr (detail::is_callable<const G&, const Q&, const Q&, const double&>) {
    return static_cast<double>(result_of(g, q, qdot, t));
  } else if constexpr (detail::is_callable<const G&, const Q&, const Q&>) {
    return static_cast<double>(result_of(g, q, qdot));
  } else if constexpr (detail::is_callable<const G&, const Q&, const Q&, const OwnStates&, const double&>) {
    return static_cast<double>(result_of(g, q, qdot, OwnStates(y.data() + 2 * dof, dof > 0 ? y.size() - 2 * dof : 0), t));
  } else {
    static_assert(detail::is_callable<const G&, const Q&>,
                  "qdot: the function of an event must be callable as g(q), g(q, qdot), g(q, qdot, t) or g(q, qdot, z, t), z the effects' own states");
    return static_cast<double>(result_of(g, q));
  }
}

// y after the change that an event asks for; what it must not have done, if it has.
template <int n, class Change>
std::optional<Failure> change_state(const std::string& name, const Change& change, double t, Eigen::VectorXd& y, Eigen::Index dof) {
  const Eigen::Index size = y.size();
  const auto resized = [&](const char* what, Eigen::Index before, Eigen::Index after) {
    return Failure{Outcome::invalid_change, sentence({"the action of event '", name, "' at t = ", t, " must keep the size of ", what, ", but made ",
                                                      after, " numbers of ", before})};
  };
  if constexpr (detail::is_callable<const Change&, State<n>&>) {
    using Q = Vector<double, n>;
    State<n> state{t, Eigen::Map<const Q>(y.data(), dof), Eigen::Map<const Q>(y.data() + dof, dof)};
    change(state);
    if (state.q.size() != dof) return resized("q", dof, state.q.size());
    if (state.qdot.size() != dof) return resized("qdot", dof, state.qdot.size());
    if (state.t != t)
      return Failure{Outcome::invalid_change, sentence({"the action of event '", name, "' at t = ", t, " must leave the time alone, but set it to ",
                                                        state.t, "; only q and qdot can be changed"})};
    std::copy_n(state.qdot.data(), dof, std::copy_n(state.q.data(), dof, y.data()));
  } else {
    static_assert(detail::is_callable<const Change&, double, Eigen::VectorXd&>,
                  "qdot: the change of an event must be callable as change(State<n>&) or change(t, y)");
    change(t, y);
    if (y.size() != size) return resized("y", size, y.size());
  }
  return std::nullopt;
}

}  // namespace detail
}  // namespace qdot
