#pragma once
// SPDX-License-Identifier: MIT
//
// Many motions of one system, several at once in each thread.
//
//     const auto ends = ensemble(pendulum, 1'000'000, [&](std::size_t i) { return start_of(i); }, 10.0, Dop853{}, options);
//     const auto turns = ensemble(pendulum, count, start_of, 10.0, Dop853{}, options, event("over", over).stop());
//
// Motions that differ only in their starts, or in parameters (family()), and of which only the end is wanted, go eight side by side,
// a lane each (integrate/lanes/lane_run.hpp). One instruction carries out a line of their equations for four or eight of them. A lane
// that has arrived takes the next motion.
//
// A motion goes on alone, by simulate(), where its lane cannot go on: M is singular, a number is not finite, a step gets too small, an
// event was passed. One of which the watchdog has something to report is done again alone. So outcomes and messages are those of
// simulate(). The results are the same bits for any number of threads, any chunk and any order. They differ from those of simulate()
// within the tolerance, for the step control of lanes has its own exp and ln. An event is looked for at five places of a step: two
// zeros that are closer are passed over.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/integrate/event.hpp"
#include "qdot/integrate/lanes/lane_run.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/ensemble.hpp"

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

/// Systems, or scenes, that differ in parameters; made by family().
template <int n, class EnergiesOf, class EffectsOf, class ParametersOf>
struct Family {
  EnergiesOf energies_of;      ///< p → T and V, for p of any scalar
  EffectsOf effects_of;        ///< p → a tuple of effects
  ParametersOf parameters_of;  ///< i → Vector<double, k>
};

/// Systems of n coordinates that differ in parameters, for ensemble().
///
/// @param energies_of    p → energies, an object with T and V, for a vector p of any scalar: double, or one that records what is done to
///                       parameters. Energies with a template parameter for the type of their constants are of that kind
/// @param parameters_of  i → Vector<double, k>; called from several threads at once
template <int n, class EnergiesOf, class ParametersOf>
auto family(EnergiesOf energies_of, ParametersOf parameters_of) {
  return Family<n, EnergiesOf, detail::NoEffects, ParametersOf>{std::move(energies_of), {}, std::move(parameters_of)};
}

/// Scenes that differ in parameters of their energies and effects.
///
/// @param effects_of  p → a tuple of effects, for the same p: std::tuple(viscous_damping(…), generalized_force(…))
template <int n, class EnergiesOf, class EffectsOf, class ParametersOf>
auto family(EnergiesOf energies_of, EffectsOf effects_of, ParametersOf parameters_of) {
  return Family<n, EnergiesOf, EffectsOf, ParametersOf>{std::move(energies_of), std::move(effects_of), std::move(parameters_of)};
}

namespace detail {

template <class... Events>
inline constexpr bool only_stop = (Events::stops && ...) && !(Events::is_timed || ...);

inline bool asks_for_lanes(const Options& o) {
  const auto is_free = [](double x) { return x == std::numeric_limits<double>::infinity(); };
  return o.by == By::fastest && o.stop_times.empty() && o.output_times.empty() && is_free(o.max_wall_seconds) && is_free(o.state_norm_limit);
}

// Whether motions go in lanes, as far as types tell.
template <class Systems, class Method, class... Events>
inline constexpr bool may_share_packs = std::is_same_v<Method, Dop853> && Systems::goes_in_lanes && only_stop<Events...>;

// A function of a motion's number that returns its State.
template <class StartOf>
concept GivesStarts = requires(const StartOf& start_of, std::size_t i) { start_of(i).qdot; };

template <class Sys>
using SystemIn = typename decltype(systems_of(std::declval<const Sys&>()))::System;

// The first-order form of such a system.
template <class System>
using FormOf = std::remove_cvref_t<decltype(first_order_form(std::declval<const System&>()))>;

// use(work) with a function work(first, last) → ends of these motions, in lanes where that can be.
template <class Systems, class StartOf, class Method, class... Events, class Use>
void use_ends(const Systems& systems, const StartOf& start_of, double t_end, const Method& method, Options options,
              const EventList<Events...>& events, const Use& use) {
  require_option(std::isfinite(t_end), "t_end", "must be finite", t_end, "choose a time to end at");
  options.keep_trajectory = false;
  constexpr int size = FormOf<typename Systems::System>::size_at_compile_time;
  require_valid(options, size == Dynamic ? options.atol.size() : size);
  if constexpr (may_share_packs<Systems, Method, Events...>) {
    std::optional<RecordedMotion> recorded;
    OwnedLines lines;
    try {
      if (asks_for_lanes(options)) {
        recorded.emplace(systems.recorded());
        lines = lines_of_recorded<Systems::n>(*recorded, Systems::parameters);
      }
    } catch (...) {  // what functors throw they throw again, where they are asked for values
    }
    if (lines && lanes_pay(*lines)) {
      using Run = LaneRun<Systems, StartOf, LanePack, Events...>;
      return use([&](std::size_t first, std::size_t last) { return Run(systems, *recorded, *lines, start_of, t_end, options, events).run(first, last); });
    }
  }
  const auto motion = [&](std::size_t i) { return motion_alone(systems.of(i), start_of(i), t_end, method, options, events); };
  use([&](std::size_t first, std::size_t last) { return kept_of_some(motion, first, last); });
}

template <class Systems, class StartOf, class Method, class... Events, class HandOn>
void hand_on_ends(const Systems& systems, std::size_t count, const StartOf& start_of, double t_end, const Method& method, const Options& options,
                  const EventList<Events...>& events, EnsembleOptions many, const HandOn& hand_on) {
  if (many.chunk == 0) {  // a chunk ends with lanes that have nothing to do
    constexpr std::size_t least = may_share_packs<Systems, Method, Events...> ? 8 * LanePack::size : 1;
    const std::size_t each = (count + threads_of(many) - 1) / threads_of(many);
    many.chunk = std::clamp<std::size_t>(each / 16, std::clamp<std::size_t>(each, 1, least), 1024);
  }
  use_ends(systems, start_of, t_end, method, options, events, [&](const auto& work) { Queue(count, many).run(work, hand_on); });
}

// The end of a motion of this system, or of one of this family.
template <class Sys>
using MotionEndOf = MotionEnd<dof_at_compile_time<FormOf<SystemIn<Sys>>>()>;
template <class Sys>
using EndOf = Kept<MotionEndOf<Sys>>;

}  // namespace detail

/// The ends of motions i = 0 … count − 1 of a system, from start_of(i) to t_end or to an event that stops them.
///
/// By Dop853 two to five times as fast as one by one on x86-64 with AVX2 or AVX-512 under Linux, wherever that can be; else as fast.
///
/// Systems go one by one, with the same result, that have more than 16 coordinates (four without machine code for lanes) or an indefinite M. So do
/// scenes with constraints, contacts, dry friction or effects with states. So do functors that compare numbers or take plain numbers only, equations
/// of more than 4000 lines, and families with terms in L. So do events that do not stop the run, and options beyond tolerances, steps and evaluations.
///
/// @param system    a system or scene, or a family() of them
/// @param start_of  i → State<n>; called from several threads at once
/// @param happening an event, or a list of them
/// @return          for each motion, by its number, where it ended; or what start_of, T, V or the parameters threw
/// @throws InvalidValue, DimensionError  options, t_end or the number of threads outside their range
template <class Sys, class StartOf, class Method, class Happening>
  requires(detail::GivesStarts<StartOf> && detail::is_event<Happening>)
auto ensemble(const Sys& system, std::size_t count, const StartOf& start_of, double t_end, const Method& method, const Options& options,
              const Happening& happening, const EnsembleOptions& many = {}) {
  std::vector<detail::EndOf<Sys>> all(count);
  detail::hand_on_ends(detail::systems_of(system), count, start_of, t_end, method, options, events(happening), many, detail::into(all));
  return all;
}

template <class Sys, class StartOf, class Method>
  requires detail::GivesStarts<StartOf>
auto ensemble(const Sys& system, std::size_t count, const StartOf& start_of, double t_end, const Method& method, const Options& options = {},
              const EnsembleOptions& many = {}) {
  return ensemble(system, count, start_of, t_end, method, options, EventList<>{}, many);
}

/// Many motions in lanes, reduced to one value as they end, in the order of i: reduce(value, i, kept).
///
/// @throws  what reduce throws; the motions that are under way are finished, and no more are begun
template <class Sys, class StartOf, class Method, class... Events, class Value, class Reduce>
  requires std::invocable<const Reduce&, Value&, std::size_t, detail::EndOf<Sys>&&>
Value ensemble(const Sys& system, std::size_t count, const StartOf& start_of, double t_end, const Method& method, const Options& options,
               const EventList<Events...>& happening, Value value, const Reduce& reduce, const EnsembleOptions& many = {}) {
  detail::hand_on_ends(detail::systems_of(system), count, start_of, t_end, method, options, happening, many, detail::reducing(value, reduce));
  return value;
}

// Old names, accepted until 0.4.

/// ensemble() by its old name.
template <class Sys, class StartOf, class Method, class Happening>
  requires(detail::GivesStarts<StartOf> && detail::is_event<Happening>)
[[deprecated("qdot: say ensemble()")]]
auto simulate_many(const Sys& system, std::size_t count, const StartOf& start_of, double t_end, const Method& method, const Options& options,
                   const Happening& happening, const EnsembleOptions& many = {}) {
  return ensemble(system, count, start_of, t_end, method, options, happening, many);
}
template <class Sys, class StartOf, class Method>
  requires detail::GivesStarts<StartOf>
[[deprecated("qdot: say ensemble()")]]
auto simulate_many(const Sys& system, std::size_t count, const StartOf& start_of, double t_end, const Method& method, const Options& options = {},
                   const EnsembleOptions& many = {}) {
  return ensemble(system, count, start_of, t_end, method, options, many);
}
template <class Sys, class StartOf, class Method, class... Events, class Value, class Reduce>
  requires std::invocable<const Reduce&, Value&, std::size_t, detail::EndOf<Sys>&&>
[[deprecated("qdot: say ensemble()")]]
Value simulate_many(const Sys& system, std::size_t count, const StartOf& start_of, double t_end, const Method& method, const Options& options,
                    const EventList<Events...>& happening, Value value, const Reduce& reduce, const EnsembleOptions& many = {}) {
  return ensemble(system, count, start_of, t_end, method, options, happening, std::move(value), reduce, many);
}

}  // namespace qdot
