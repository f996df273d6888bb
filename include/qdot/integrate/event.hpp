#pragma once
// SPDX-License-Identifier: MIT
//
// Events: moments at which a function of the motion crosses zero.
//
//     simulate(system, start, t_end, Dop853{}, {},
//              events(event("apex", [](const auto& q, const auto& qdot) { return qdot[1]; }).falling(),
//                     event("floor", [](const auto& q) { return q[1]; }).falling().stop()));
//
// g(q), g(q, q̇), g(q, q̇, t), or g(q, q̇, z, t) with the effects' own states z, is watched on the dense output of every step. So all methods have
// events, and no stepper has code for them. Of an event the run keeps its time and name (Run::events), and then it
//
//     records     goes on in the same step: an event that only looks costs nothing but the looking;
//     .stop()     ends the run there, outcome stopped_by_event;
//     .action(f)  lets f change the state, f(State<n>&) or f(t, y), and starts the method afresh from the
//                 changed state. Trajectory::before(t) and at(t) are the two sides of the jump. What lasting constraints
//                 forbid of a change is taken back by projection: a push on a constrained body is felt along its freedom.
//                 A closed contact opens by a kick, or where f moves its gap; friction that sticks slips.
//                 What leaves NaN or infinity behind ends the run as non_finite, and what sets the time or another
//                 size of the state as invalid_change; the motion up to there is kept.
//
// Events of a clock need no function: every("sample", 0.01) happens at the start of the run, 0.01 later, and so on while t < t_end, and takes
// .stop() and .action(f) like any other. The run lands on these times (the k-th is t₀ + 0.01 k, not a sum), so a digital controller is
//
//     every("controller", 0.01).action([&](State<2>& s) { force = -K * s.q; })      what functors read may change there,
//
// or one that keeps its output among the effects' own states, .action([](double t, Eigen::VectorXd& y) { y[4] = …; }).
//
// An event whose function takes every scalar, `[](const auto& q, const auto& qdot, const auto& t) { using std::sin; return … }`, may be declared
// a formula: .formula(). Then g is called with intervals as well, which proves of every step that no zero was passed over
// (integrate/driver/event_proof.hpp). No signature tells a formula from what only looks like one, so this has to be asked for.
//
// The rules, each with a test:
//   crossing    Motion through zero is an event, in the asked direction of time's arrow: falling means that g becomes
//               negative as the run goes on. A jump across zero is none, nor is a pole, nor is g ≡ 0; a jump onto zero is one.
//               The time handed out is the first double on the far side of the root. Of a g that stays zero for a while, it is where that
//               begins, and where it ends if g was zero at t₀.
//   noise       Where an event only records, a g that begins at zero to within the method's tolerance has no sign before it has left that: the
//               velocity of what sticks, a gap that is closed, and what a constraint keeps at zero have no events.
//   fast g      g may be much faster than the motion: the step is searched in panels as short as g asks for (integrate/driver/event_finder.hpp), which
//               for a slow g is the whole step. What is followed only with an effort without end, noise for one, is
//               counted in Statistics::unresolved_events, for then roots may have been missed, and the run's message reports it. An
//               excursion across zero that is narrow beside everything else that g does may lie between all samples, unless g is a
//               formula(): then it is found, and what rounding does not decide, a touching of zero, is counted as well.
//   touching    Between samples g is looked at for its extremum; so two roots close together are found when g gets farther
//               across zero than the extremum's own accuracy.
//   order       All roots of a step are taken in the order of time, those at the same time in the order of the list.
//   muting      After an event has changed the state, g may still be zero: it counts again once it has left zero. If its action has
//               turned or stopped the motion of g, it leaves zero to the side it came from: g is watched from the first
//               instant behind the action, and the run ends as zeno where g returns sooner than t can tell.
//               What another event's action puts onto zero is treated as at t₀.
//   at t₀       g = 0 at the start counts if g then moves in the asked direction.
//   barriers    An action that keeps g ≥ 0 (an impact) is a barrier: then g < 0 is never passed in silence.
//   Zeno        Infinitely many events before a finite time end the run as zeno, when they follow each
//               other as closely as t can tell. Those that only record are then counted in Statistics::unresolved_events, and the run goes on. A contact
//               (effects/contact.hpp) comes to rest instead.

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

/// Which crossings of zero count.
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
  /// True when the action turns g back to g ≥ 0, as an impact does.
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
/// @param name  as it appears in Run::events
/// @param g     real and continuous; called some ten times for each step, and for each of its own fast turns
template <class G>
Event<G> event(std::string name, G g) {
  return {std::move(name), std::move(g), Direction::either, {}};
}

/// The event that happens each time a period has passed; by itself it is recorded.
///
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
