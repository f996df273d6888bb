#pragma once
// SPDX-License-Identifier: MIT
//
// The simulator: for programs that own the clock, such as a controller in the loop, a game or a co-simulation.
//
//     Simulator plant(scene(system, input("motor", 0)), start, Dop853{});
//     for (long k = 1; k <= 10'000; ++k) {
//       plant.set_input("motor", controller(plant.q(), plant.qdot()));
//       if (!plant.advance_to(1e-3 * k)) return complain(plant.message());
//     }
//
// Each advance is a run of its own with inputs held. y = [q; q̇; z] holds the inputs and all other states of effects, and the method
// begins afresh, so the future depends on (t, y) alone. (An event that stopped the last advance has to leave zero first.) Therefore
// to save, go on, restore and go on gives the same bits, in another process on such a machine as well. A variable that functors
// capture is no part of it: the caller keeps it. A fresh start costs some evaluations to choose the first step. A multistep method
// begins at order one, and is worth it only where an advance is long against its steps. For sizes fixed while compiling, an advance
// that completes allocates nothing, but for events and contacts that act and, once, machine code (ad/native/line_evaluator.ipp).

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/effects/input.hpp"
#include "qdot/effects/interpolated_input.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/driver/engine.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/simulator_state.hpp"

namespace qdot {

/// How an advance ended; true if it came where it was told to go.
struct Advance {
  Outcome outcome = Outcome::completed;  ///< why it ended there
  double t = 0.0;                        ///< as far as it came
  /// Whether it came where it was told to go.
  bool completed() const noexcept { return outcome == Outcome::completed; }
  /// True if it came where it was told to go: completed().
  explicit operator bool() const noexcept { return completed(); }
};

/// A motion that the calling program advances. Movable; two simulators share nothing.
class Simulator {
 public:
  /// @param system   a mechanical system or a scene, or anything that models FirstOrderSystem; copied
  /// @param start    State{t, q, qdot} or FirstOrderState{t, y}
  /// @param method   as for simulate(); best a one-step method
  /// @param options  tolerances, and limits of each advance
  /// @param events   one event(…) or events(…): reported in events(); one that stops ends the advance in which it happens
  /// @throws         as simulate() before its first step
  template <class System, class Start, class Method, class... Events>
  Simulator(const System& system, const Start& start, const Method& method, const Options& options, const EventList<Events...>& events) {
    static_assert(!(Events::is_timed || ...), "qdot: whoever owns a simulator owns its clock: advance to the times of every(), and act there");
    constexpr bool has_events = sizeof...(Events) > 0;
    if constexpr (detail::has_hidden_run<System, Method>) {
      constexpr int n = System::dof_at_compile_time;
      constexpr bool timed = !System::autonomous;
      engine_ = detail::RunOfEnergies<n, timed>::engine(detail::hidden_method<2 * n>(method), detail::AnyEnergies<n, timed>(system.energies()), system.parts(),
                                                        start.t, detail::numbers_of<n>(start), detail::engine_request<n, has_events>(options, events));
    } else {
      auto form = detail::form_by(system, options.by);
      using Form = decltype(form);
      static_assert(SteppingMethod<Method, Form>, "qdot: the method cannot make a stepper for this system");
      const auto stepper = [&method](const Form& stepped, const Options& of_run) { return any_stepper(method, stepped, of_run); };
      const Eigen::VectorXd y = detail::packed(form, start);
      constexpr bool watches = has_events || SwitchingSystem<Form>;
      const auto request = detail::engine_request<detail::dof_at_compile_time<Form>(), watches>(options, events);
      engine_ = std::make_unique<detail::EngineOf<Form>>(std::move(form), stepper, start.t, y, request);
    }
    for (const std::string& name : engine_->components) names_ = detail::checksum(names_, name.c_str(), name.size() + 1);
    start_ = save();
  }
  template <class System, class Start, class Method>
  Simulator(const System& system, const Start& start, const Method& method, const Options& options = {})
      : Simulator(system, start, method, options, EventList<>{}) {}
  template <class System, class Start, class Method, class G, class Action>
  Simulator(const System& system, const Start& start, const Method& method, const Options& options, const Event<G, Action>& event)
      : Simulator(system, start, method, options, qdot::events(event)) {}

  /// Goes on to t, landing on it exactly, with inputs held, or on their ramps.
  ///
  /// Where a ramp ends on the way, the options' limits count up to there and again from there.
  /// Throws nothing: what goes wrong, the user's own exceptions included, is an outcome with a message(). t() and y() are then the last
  /// good state, from which one may go on, perhaps with other inputs. An event that stops leaves the state of its moment.
  Advance advance_to(double t) noexcept {
    if (!(t >= engine_->t && t < std::numeric_limits<double>::infinity())) return refused(t);
    own_message_.clear();
    Advance result;
    try {
      result.outcome = advanced_past_ramps(t);
    } catch (const std::exception& error) {
      result.outcome = Outcome::refused_by_model;
      own_message_ = error.what();
    } catch (...) {
      result.outcome = Outcome::refused_by_model;
      own_message_ = "a functor threw what is no std::exception";
    }
    result.t = engine_->t;
    return result;
  }

  /// Goes on by dt ≥ 0.
  Advance advance(double dt) noexcept { return advance_to(engine_->t + dt); }

  /// Time.
  double t() const noexcept { return engine_->t; }
  /// Number of coordinates.
  Eigen::Index dof() const noexcept { return engine_->dof; }

  /// Coordinates, velocities, and all of y; they show the state as it is, also after the next advance.
  Eigen::Map<const Eigen::VectorXd> q() const noexcept { return {engine_->y.data(), engine_->dof}; }
  /// Velocities.
  Eigen::Map<const Eigen::VectorXd> qdot() const noexcept { return {engine_->y.data() + engine_->dof, engine_->dof}; }
  /// [q; q̇; z], with inputs among z.
  const Eigen::VectorXd& y() const noexcept { return engine_->y; }

  /// A copy of t, q and q̇, for energy(), reactions() and whatever takes a state.
  ///
  /// @throws DimensionError  when there are not n coordinates
  template <int n = Dynamic>
  State<n> state() const {
    if (n != Dynamic && n != engine_->dof) throw DimensionError("state<n>", static_cast<long>(engine_->dof), n, "give the number of coordinates");
    return State<n>{t(), q(), qdot()};
  }

  /// Names of y's components: coordinates, velocities, inputs and other states.
  const std::vector<std::string>& component_names() const noexcept { return engine_->components; }

  /// Names of the inputs, in the order of the scene's effects; their places are the indices below.
  const std::vector<std::string>& input_names() const noexcept { return engine_->input_names; }

  /// The input that all advances from here on hold, until it is set again.
  ///
  /// @throws InvalidValue  no such input, or a value that is no finite number; nothing is changed
  void set_input(std::size_t i, double value) {
    engine_->y[place_of(i, value)] = value;
    if (engine_->input_strides[i] != 0) set_ramp(i, 0.0, value, 0.0);
  }
  void set_input(std::string_view name, double value) { set_input(index_of(name), value); }
  /// The input goes linearly from what it is to `value`, which it has exactly at t_reached and holds from then on.
  ///
  /// Advances need not end there. To set or to ramp it again before that begins at what it is by then. Slope, value and t_reached are states, too:
  /// Options::state_norm_limit has to allow for them.
  ///
  /// @throws InvalidValue  no such input, one that is not interpolated(…), a value that is no finite number, a t_reached that is not after
  ///                       t(), or so soon that the slope is no number; nothing is changed
  void ramp_input(std::size_t i, double value, double t_reached) {
    const double u = engine_->y[place_of(i, value)], slope = (value - u) / (t_reached - t());
    const std::string& name = engine_->input_names[i];
    if (engine_->input_strides[i] == 0)
      throw InvalidValue("only an interpolated input has ramps, but '" + name + "' is held; make it interpolated(input(…)) in the scene");
    if (!(t_reached > t() && std::isfinite(t_reached)))
      throw InvalidValue(detail::sentence({"a ramp must end at a finite time after now, but at t = ", t(), " '", name,
                                           "' was sent to be there at ", t_reached, "; set_input() jumps"}));
    if (!std::isfinite(slope))
      throw InvalidValue(detail::sentence({"a ramp must have a finite slope, but '", name, "' was sent from ", u, " to ", value, " within ",
                                           t_reached - t(), "; give it more time, or set_input()"}));
    set_ramp(i, slope, value, t_reached);
  }
  void ramp_input(std::string_view name, double value, double t_reached) { ramp_input(index_of(name), value, t_reached); }
  /// What input number i is at now.
  double input(std::size_t i) const { return engine_->y[place_of(i, 0.0)]; }
  double input(std::string_view name) const { return input(index_of(name)); }

  /// All inputs at once.
  ///
  /// @throws DimensionError, InvalidValue  nothing is changed
  void set_inputs(std::span<const double> values) {
    if (values.size() != engine_->input_places.size())
      throw DimensionError("the inputs", static_cast<long>(engine_->input_places.size()), static_cast<long>(values.size()),
                           "give one value for each of input_names()");
    for (std::size_t i = 0; i < values.size(); ++i) (void)place_of(i, values[i]);
    for (std::size_t i = 0; i < values.size(); ++i) set_input(i, values[i]);
  }

  /// What happened during the last advance, with its times.
  const std::vector<RecordedEvent>& events() const noexcept { return earlier_events_.empty() ? engine_->events() : earlier_events_; }

  /// How the last advance ended, in words; empty where it came to its end.
  const std::string& message() const noexcept { return own_message_.empty() ? engine_->message() : own_message_; }

  /// Steps and evaluations since construction.
  const Statistics& statistics() const noexcept { return engine_->statistics(); }

  /// A copy of where it is.
  SimulatorState save() const { return {engine_->t, engine_->y, engine_->stopped_by, names_}; }

  /// Goes (back) to a saved state, of this simulator or of another one of the same system.
  ///
  /// A state off its constraints is refused by the advance that begins there.
  ///
  /// @throws InvalidValue  a state of another system, or with entries that are not finite; nothing is changed
  void restore(const SimulatorState& saved) {
    if (saved.simulator != names_ || saved.y.size() != engine_->y.size())
      throw InvalidValue(detail::sentence({"a saved state belongs to the system that it was saved from: this one has ", static_cast<long>(engine_->y.size()),
                                           " components, the state ", static_cast<long>(saved.y.size()), ", or they are called otherwise; save() one here"}));
    if (!std::isfinite(saved.t) || !saved.y.allFinite()) throw InvalidValue("a saved state must be finite, but this one is not; save it anew");
    engine_->y = saved.y;
    engine_->t = saved.t;
    engine_->stopped_by = saved.stopped_by;
  }

  /// Back to the start that the constructor was given, inputs included.
  void reset() { restore(start_); }

 private:
  Advance refused(double t) noexcept {
    own_message_ = detail::sentence({"an advance must go forward to a finite t, but from t = ", engine_->t, " was sent to ", t,
                                     "; go back by restore() of a state that was saved there"});
    return {Outcome::invalid_change, engine_->t};
  }

  void set_ramp(std::size_t i, double slope, double end, double t_end) {
    const Eigen::Index place = engine_->input_places[i], stride = engine_->input_strides[i];
    engine_->y[place + stride] = slope;
    engine_->y[place + 2 * stride] = end;
    engine_->y[place + 3 * stride] = t_end;
  }

  // From the end of one ramp to the next and on to t; what happened meanwhile is that of all pieces.
  Outcome advanced_past_ramps(double t) {
    earlier_events_.clear();
    for (;;) {
      double next = t;
      each_ramp([&](Eigen::Ref<Eigen::VectorXd>, Eigen::Index, Eigen::Index, double t_end) { next = std::min(next, std::max(t_end, engine_->t)); });
      Outcome outcome;
      try {
        outcome = engine_->stretch(next);
      } catch (...) {
        if (!earlier_events_.empty()) add_events();
        throw;
      }
      each_ramp([&](Eigen::Ref<Eigen::VectorXd> y, Eigen::Index place, Eigen::Index stride, double t_end) {
        if (engine_->t < t_end) return;
        y[place] = y[place + 2 * stride];
        y[place + stride] = y[place + 3 * stride] = 0.0;
      });
      const bool ends = outcome != Outcome::completed || next == t;
      if (ends && earlier_events_.empty()) return outcome;
      add_events();
      if (ends) return outcome;
    }
  }
  void add_events() { earlier_events_.insert(earlier_events_.end(), engine_->events().begin(), engine_->events().end()); }

  // visit(y, place of u, stride, t_end) for each input that is on its way.
  template <class Visit>
  void each_ramp(const Visit& visit) {
    for (std::size_t i = 0; i < engine_->input_places.size(); ++i) {
      const Eigen::Index place = engine_->input_places[i], stride = engine_->input_strides[i];
      if (stride == 0) continue;
      const bool moves = engine_->y[place + stride] != 0.0 || engine_->y[place] != engine_->y[place + 2 * stride];
      if (moves) visit(engine_->y, place, stride, engine_->y[place + 3 * stride]);
    }
  }

  std::size_t index_of(std::string_view name) const {
    for (std::size_t i = 0; i < engine_->input_names.size(); ++i)
      if (engine_->input_names[i] == name) return i;
    std::string known;
    for (const std::string& each : engine_->input_names) known += (known.empty() ? "" : ", ") + each;
    throw InvalidValue("an input must be one of the scene's, but '" + std::string(name) + "' is none; " +
                       (known.empty() ? "add an effect input(name, coordinate)" : "it has " + known));
  }
  Eigen::Index place_of(std::size_t i, double value) const {
    if (i >= engine_->input_places.size())
      throw InvalidValue(
          detail::sentence({"there are ", static_cast<long>(engine_->input_places.size()), " inputs, but number ", static_cast<long>(i),
                            " was asked for; they are counted from 0, and input_names() has their names"}));
    if (!std::isfinite(value))
      throw InvalidValue(detail::sentence({"an input must be a finite number, but '", engine_->input_names[i], "' was given ", value,
                                           "; it keeps what it had, look at what computed this one"}));
    return engine_->input_places[i];
  }

  std::unique_ptr<detail::Engine> engine_;
  std::uint64_t names_ = detail::empty_checksum;
  SimulatorState start_;
  std::string own_message_;
  std::vector<RecordedEvent> earlier_events_;  // of an advance in pieces, where there were any before its last
};

}  // namespace qdot
