#pragma once
// SPDX-License-Identifier: MIT
//
// Many motions of one system, several at once in each thread.
//
//     const auto ends = simulate_many(pendulum, 1'000'000, [&](std::size_t i) { return start_of(i); }, 10.0, Dop853{}, options);
//     const auto turns = simulate_many(pendulum, count, start_of, 10.0, Dop853{}, options, event("over", over).stop());
//
// simulate_many(count, motion) of integrate/simulate_many.hpp does motions one after the other. Where they differ only in their starts, or in
// parameters (family()), and all that is wanted of each is where it ends, they go through the same instructions: a processor adds four or
// eight doubles by one instruction (ad/pack.hpp), and as many motions go side by side, a lane each (integrate/steps/lane_steps.hpp). A
// lane that has arrived takes the next motion.
//
// What a lane cannot do, or what needs a closer look, leaves the pack and goes on alone as simulate() does it: where M is singular, where a number is not
// finite, where the step gets too small, where an event has been passed. So outcomes and messages are those of simulate(). An event's function
// is asked at both ends of a step and at three places between; two zeros closer than that are passed over, which simulate() finds. What
// the watchdog has to say is asked at the end of a motion, and if it has something, the motion is done again alone, all of it.
//
// The results are the same bits for any number of threads, any chunk, any order of motions. From simulate() they differ by what the tolerance
// allows: a lane computes exp, ln, sine and cosine by other formulas in the last bit, and so steps may end elsewhere.
//
// Alone go: systems that simulate() has no packs for (more than 6 coordinates, an indefinite M, a loop in T or V that stays a loop, code without
// optimization), all scenes with effects, systems that depend on t, events that do not stop the run, and options beyond tolerances, steps
// and evaluations. The result is the same.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <exception>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/integrate/event.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/simulate_many.hpp"
#include "qdot/integrate/steps/first_step.hpp"
#include "qdot/integrate/steps/lane_events.hpp"
#include "qdot/integrate/steps/lane_steps.hpp"
#include "qdot/integrate/watch/watch.hpp"
#include "qdot/mechanics/ensemble.hpp"

namespace qdot {

/// Where one of many motions ended.
template <int n>
struct MotionEnd {
  State<n> state;                         ///< and its time
  Outcome outcome = Outcome::completed;  ///< as simulate() has it
  std::string message;   ///< what simulate() says of an end before t_end; empty where it completed
  std::string event;     ///< the event that stopped it
  long steps = 0;        ///< accepted
  long evaluations = 0;  ///< of q̈

  /// Whether it came to t_end.
  bool completed() const noexcept { return outcome == Outcome::completed; }
};

/// Systems that differ in parameters: T and V are energies_of(p) for the parameters_of(i) of motion i; made by family().
template <int n, class EnergiesOf, class ParametersOf>
struct Family {
  EnergiesOf energies_of;      ///< p → T and V, for p of any scalar
  ParametersOf parameters_of;  ///< i → Vector<double, k>
};

/// Systems of n coordinates that differ in parameters, for simulate_many().
///
/// @param energies_of    p → energies, an object with T and V, for a vector p of any scalar: double, or a Pack with the parameters of several
///                       motions. Energies with a template parameter for the type of their constants are of that kind
/// @param parameters_of  i → Vector<double, k>; called from several threads at once
template <int n, class EnergiesOf, class ParametersOf>
Family<n, EnergiesOf, ParametersOf> family(EnergiesOf energies_of, ParametersOf parameters_of) {
  return {std::move(energies_of), std::move(parameters_of)};
}

namespace detail {

inline constexpr int lanes_of_many = register_lanes;

// One system for all motions.
template <class Sys>
struct OneSystem {
  using System = Sys;
  using Packed = std::false_type;  // no parameters
  using PackEnergies = std::false_type;
  static constexpr bool is_common = true;
  const Sys& system;

  const Sys& of(std::size_t) const { return system; }
};

template <int n, class EnergiesOf, class ParametersOf>
struct SystemsOfFamily {
  using P = std::remove_cvref_t<std::invoke_result_t<const ParametersOf&, std::size_t>>;
  using System = decltype(mechanical_system<n>(std::declval<const EnergiesOf&>()(std::declval<const P&>())));
  static constexpr bool is_common = false;
  static constexpr int k = P::SizeAtCompileTime;
  static_assert(k != Dynamic, "qdot: the parameters of a family are a Vector<double, k> with k known when compiled");
  using Packed = Vector<Pack<lanes_of_many>, k>;
  using PackEnergies = std::remove_cvref_t<std::invoke_result_t<const EnergiesOf&, const Packed&>>;
  const Family<n, EnergiesOf, ParametersOf>& family;

  System of(std::size_t i) const { return mechanical_system<n>(family.energies_of(P(family.parameters_of(i)))); }
};

template <class Sys>
inline constexpr bool goes_in_lanes = false;
template <class E, int n, Inertia I>
inline constexpr bool goes_in_lanes<System<E, n, I>> =
    goes_in_packs<System<E, n, I>> && !TimeWatch<FirstOrderForm<System<E, n, I>>>::watches;

template <class... Events>
inline constexpr bool only_stop = (Events::stops && ...) && !(Events::is_timed || ...);

inline bool asks_for_lanes(const Options& o) {
  const auto is_free = [](double x) { return x == std::numeric_limits<double>::infinity(); };
  return o.stop_times.empty() && o.output_times.empty() && is_free(o.max_wall_seconds) && is_free(o.state_norm_limit);
}

// A motion by simulate().
template <class Sys, int n, class Method, class... Events>
MotionEnd<n> motion_alone(const Sys& system, const State<n>& start, double t_end, const Method& method, const Options& options, const EventList<Events...>& events) {
  auto run = simulate(system, start, t_end, method, options, NoObserver{}, events);
  const Eigen::Index dof = start.q.size();
  MotionEnd<n> end{{run.t, run.y.head(dof), run.y.segment(dof, dof)}, run.outcome, {}, {}, run.statistics.steps, run.statistics.evaluations};
  if (!run.completed()) end.message = std::move(run.message);
  if (run.outcome == Outcome::stopped_by_event && !run.events.empty()) end.event = run.events.back().name;
  return end;
}

// Motions first … last − 1 of a system that goes in lanes.
template <class Systems, class StartOf, class... Events>
class LaneRun {
  using Sys = typename Systems::System;
  using Form = FirstOrderForm<Sys>;
  static constexpr int n = Sys::dof_at_compile_time, lanes = lanes_of_many;
  using P = Pack<lanes>;
  using Mask = PackMask<lanes>;
  using Ends = std::vector<Kept<MotionEnd<n>>>;

 public:
  LaneRun(const Systems& systems, const StartOf& start_of, double t_end, const Options& options, const EventList<Events...>& events)
      : systems_(systems), start_of_(start_of), t_end_(t_end), options_(options), events_(events), pack_(options) {}

  Ends run(std::size_t first, std::size_t last) {
    first_ = next_ = first;
    last_ = last;
    Ends ends(last - first);
    ends_ = &ends;
    for (int lane = 0; lane < lanes; ++lane) load(lane);
    const auto seen = [&] { return lanes_that_pass<n>(pack_, events_); };
    while (moving_ > 0) {
      Mask told;
      try {
        if constexpr (!Systems::is_common)
          if (!energies_) energies_.emplace(systems_.family.energies_of(parameters_));
        told = pack_.step([&](const P* q, const P* qdot, const P& t, P* qddot) { return accelerations(q, qdot, t, qddot); }, seen);
      } catch (...) {  // by T, V or an event for some lane, which will do so again alone
        told = pack_.abandoned();
      }
      for (int lane = 0; lane < lanes; ++lane)
        if (told[lane] || (pack_.is_active(lane) && is_over_budget(lane))) finish(lane);
    }
    return ends;
  }

 private:
  struct Lane {
    std::size_t motion = 0;
    State<n> start;
    std::optional<Form> form;
    std::optional<Watchdog<Form>> dog;
  };

  Mask accelerations(const P* q, const P* qdot, const P& t, P* qddot) const {
    if constexpr (Systems::is_common) {
      return unchecked_accelerations(systems_.system, q, qdot, t, qddot);
    } else {
      const auto line = straight_line_accelerations<n, lanes>(*energies_, q, qdot, t, singular_pivot<double>(n), qddot);
      return line.good & Mask(line.is_straight);
    }
  }

  Kept<MotionEnd<n>>& kept(std::size_t motion) { return (*ends_)[motion - first_]; }

  // The next motion that can be begun into a lane.
  void load(int lane) {
    while (next_ < last_)
      if (begin(lane, next_++)) return void(++moving_);
    pack_.unload(lane);
  }

  // False where the motion is done already, or cannot be begun.
  bool begin(int lane, std::size_t motion) {
    Lane& l = lanes_[lane];
    try {
      l.motion = motion;
      l.start = start_of_(motion);
      l.dog.reset();
      l.form.emplace(systems_.of(motion));
      if (is_ordinary(l.start) && begin_at(lane, l)) return true;
      kept(motion).value = alone(l, l.start, options_);
    } catch (...) {
      kept(motion).error = std::current_exception();
    }
    return false;
  }

  // False where there is something about the start that simulate() has a word for.
  bool begin_at(int lane, Lane& l) {
    try {
      l.dog.emplace(*l.form, options_);
      Eigen::VectorXd y(2 * n), f(2 * n);
      y << l.start.q, l.start.qdot;
      l.form->derivative(l.start.t, y, f);
      l.dog->begin(l.start.t, y, 0);
      if (!f.allFinite() || l.dog->look_at_values_and_mass(l.start.t, y)) return false;
      const double way = t_end_ - l.start.t;
      pack_.load(lane, l.start.t, way, std::copysign(first_step(l, y, f, std::abs(way)), way), y.data(), f.data());
      if constexpr (!Systems::is_common) {
        const auto p = systems_.family.parameters_of(l.motion);
        for (int j = 0; j < Systems::k; ++j) parameters_[j] = P::of([&](int other) { return other == lane ? p[j] : parameters_[j][other]; });
        energies_.reset();
      }
      return true;
    } catch (...) {
      return false;
    }
  }

  bool is_ordinary(const State<n>& s) const { return std::isfinite(s.t) && s.q.allFinite() && s.qdot.allFinite() && s.t != t_end_; }

  double first_step(const Lane& l, const Eigen::VectorXd& y, const Eigen::VectorXd& f, double way) const {
    const double longest = std::min(options_.max_step, way), sign = t_end_ < l.start.t ? -1.0 : 1.0;
    if (options_.initial_step > 0.0) return std::min(options_.initial_step, way);
    Eigen::VectorXd later(2 * n);
    const auto weight = [&](Eigen::Index i) { return options_.atol[i] + options_.rtol * std::abs(y[i]); };
    return detail::first_step(Dop853Coefficients::order, 2 * n, y.data(), f.data(), weight, longest, [&](double h) -> const double* {
      try {
        l.form->derivative(l.start.t + sign * h, y + sign * h * f, later);
        return later.data();
      } catch (const Error&) {
        return nullptr;
      }
    });
  }

  bool is_over_budget(int lane) const { return pack_.steps(lane) >= options_.max_steps || pack_.evaluations(lane) >= options_.max_evaluations; }

  // Takes what a lane came to, and gives it the next motion.
  void finish(int lane) {
    Lane& l = lanes_[lane];
    --moving_;
    try {
      State<n> state{pack_.has_arrived(lane) ? t_end_ : pack_.t(lane), {}, {}};
      for (int i = 0; i < n; ++i) state.q[i] = pack_.y(i, lane), state.qdot[i] = pack_.y(n + i, lane);
      const long steps = pack_.steps(lane), evaluations = pack_.evaluations(lane) + 2;
      if (pack_.has_arrived(lane)) {
        Eigen::VectorXd y(2 * n);
        y << state.q, state.qdot;
        if (l.dog->look(t_end_, y, steps, true)) {
          kept(l.motion).value = alone(l, l.start, options_);
        } else {
          kept(l.motion).value = MotionEnd<n>{state, Outcome::completed, {}, {}, steps, evaluations};
        }
      } else if (sizeof...(Events) > 0 && pack_.was_seen(lane)) {
        Options rest = options_;
        rest.max_steps = std::max(1L, options_.max_steps - steps);
        rest.max_evaluations = std::max(1L, options_.max_evaluations - evaluations);
        rest.initial_step = std::min(std::abs(pack_.last_step(lane)), options_.max_step);
        MotionEnd<n> end = alone(l, state, rest);
        end.steps += steps;
        end.evaluations += evaluations;
        kept(l.motion).value = std::move(end);
      } else {
        kept(l.motion).value = alone(l, l.start, options_);
      }
    } catch (...) {
      kept(l.motion).error = std::current_exception();
    }
    load(lane);
  }

  MotionEnd<n> alone(const Lane& l, const State<n>& start, const Options& options) const {
    return motion_alone(l.form->system(), start, t_end_, Dop853{}, options, events_);
  }

  const Systems& systems_;
  const StartOf& start_of_;
  double t_end_;
  const Options& options_;
  const EventList<Events...>& events_;
  LaneSteps<Dop853Coefficients, n, lanes> pack_;
  std::size_t first_ = 0, next_ = 0, last_ = 0;
  int moving_ = 0;
  Ends* ends_ = nullptr;
  Lane lanes_[lanes];
  [[no_unique_address]] typename Systems::Packed parameters_{};  // of a family
  [[no_unique_address]] std::optional<typename Systems::PackEnergies> energies_;  // with these parameters, unless a lane has changed its own
};

// Whether motions go in lanes, as far as types tell.
template <class Systems, class Method, class... Events>
inline constexpr bool may_share_packs = std::is_same_v<Method, Dop853> && goes_in_lanes<typename Systems::System> && only_stop<Events...>;

// use(work) with a function work(first, last) → ends of these motions, in lanes where that can be.
template <class Systems, class StartOf, class Method, class... Events, class Use>
void use_ends(const Systems& systems, const StartOf& start_of, double t_end, const Method& method, Options options, const EventList<Events...>& events, const Use& use) {
  require_option(std::isfinite(t_end), "t_end", "must be finite", t_end, "choose a time to end at");
  options.keep_trajectory = false;
  if constexpr (may_share_packs<Systems, Method, Events...>) {
    require_valid(options, 2 * Systems::System::dof_at_compile_time);
    if (asks_for_lanes(options))
      return use([&](std::size_t first, std::size_t last) { return LaneRun<Systems, StartOf, Events...>(systems, start_of, t_end, options, events).run(first, last); });
  }
  const auto motion = [&](std::size_t i) { return motion_alone(systems.of(i), start_of(i), t_end, method, options, events); };
  use([&](std::size_t first, std::size_t last) { return kept_of_some(motion, first, last); });
}

template <class Systems, class StartOf, class Method, class... Events, class HandOn>
void hand_on_ends(const Systems& systems, std::size_t count, const StartOf& start_of, double t_end, const Method& method, const Options& options,
                  const EventList<Events...>& events, ManyOptions many, const HandOn& hand_on) {
  if (many.chunk == 0) many.chunk = std::clamp<std::size_t>(count / (16 * threads_of(many)), 1, 1024);  // a chunk ends with lanes that have nothing to do
  use_ends(systems, start_of, t_end, method, options, events, [&](const auto& work) { Queue(count, many).run(work, hand_on); });
}

// A function of a motion's number that returns its State.
template <class StartOf>
concept GivesStarts = requires(const StartOf& start_of, std::size_t i) { start_of(i).qdot; };

template <class Sys>
OneSystem<Sys> systems_of(const Sys& system) {
  return {system};
}
template <int n, class EnergiesOf, class ParametersOf>
SystemsOfFamily<n, EnergiesOf, ParametersOf> systems_of(const Family<n, EnergiesOf, ParametersOf>& family) {
  return {family};
}

template <class Sys>
using SystemIn = typename decltype(systems_of(std::declval<const Sys&>()))::System;

// The end of a motion of this system, or of one of this family.
template <class Sys>
using MotionEndOf = MotionEnd<dof_at_compile_time<std::remove_cvref_t<decltype(first_order_form(std::declval<const SystemIn<Sys>&>()))>>()>;
template <class Sys>
using EndOf = Kept<MotionEndOf<Sys>>;

}  // namespace detail

/// The ends of motions i = 0 … count − 1 of a system, from start_of(i) to t_end or to an event that stops them.
///
/// With a processor of 4 or 8 lanes (-march=native) and Dop853 several times as fast as one by one, wherever that can be; else as fast.
///
/// @param system    a system or scene, or a family() of them
/// @param start_of  i → State<n>; called from several threads at once
/// @param happening an event, or a list of them
/// @return          for each motion, by its number, where it ended; or what start_of, T, V or the parameters threw
/// @throws InvalidValue, DimensionError  options, t_end or the number of threads outside their range
template <class Sys, class StartOf, class Method, class... Events>
  requires detail::GivesStarts<StartOf>
auto simulate_many(const Sys& system, std::size_t count, const StartOf& start_of, double t_end, const Method& method, const Options& options,
                   const EventList<Events...>& happening, const ManyOptions& many = {}) {
  std::vector<detail::EndOf<Sys>> all(count);
  detail::hand_on_ends(detail::systems_of(system), count, start_of, t_end, method, options, happening, many, detail::into(all));
  return all;
}

template <class Sys, class StartOf, class Method, class G, class Action>
  requires detail::GivesStarts<StartOf>
auto simulate_many(const Sys& system, std::size_t count, const StartOf& start_of, double t_end, const Method& method, const Options& options,
                   const Event<G, Action>& happening, const ManyOptions& many = {}) {
  return simulate_many(system, count, start_of, t_end, method, options, events(happening), many);
}

template <class Sys, class StartOf, class Method>
  requires detail::GivesStarts<StartOf>
auto simulate_many(const Sys& system, std::size_t count, const StartOf& start_of, double t_end, const Method& method, const Options& options = {},
                   const ManyOptions& many = {}) {
  return simulate_many(system, count, start_of, t_end, method, options, EventList<>{}, many);
}

/// The same reduced to one value as it goes, in the order of i: reduce(value, i, kept).
///
/// @throws  what reduce throws; the motions that are under way are finished, and no more are begun
template <class Sys, class StartOf, class Method, class... Events, class Value, class Reduce>
  requires std::invocable<const Reduce&, Value&, std::size_t, detail::EndOf<Sys>&&>
Value simulate_many(const Sys& system, std::size_t count, const StartOf& start_of, double t_end, const Method& method, const Options& options,
                    const EventList<Events...>& happening, Value value, const Reduce& reduce, const ManyOptions& many = {}) {
  detail::hand_on_ends(detail::systems_of(system), count, start_of, t_end, method, options, happening, many, detail::reducing(value, reduce));
  return value;
}

}  // namespace qdot
