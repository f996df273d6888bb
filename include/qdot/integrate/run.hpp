#pragma once
// SPDX-License-Identifier: MIT
//
// What goes into a run besides the system, and what comes out of it.
//
// In: a start, and perhaps an observer, which is shown every accepted step (StepView) and may stop
// the run. Out: a Run. It is complete whatever happened: the outcome and a sentence about it, the
// last good state, the trajectory up to there, the samples that were reached, and what it cost.

#include <Eigen/Core>
#include <concepts>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/integrate/event.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/statistics.hpp"
#include "qdot/integrate/stepper.hpp"
#include "qdot/integrate/trajectory.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot {

/// Start of a first-order system: a time and the whole vector y.
struct FirstOrderState {
  double t = 0.0;     ///< time
  Eigen::VectorXd y;  ///< all components
};

/// States at the times of Options::output_times, as far as the run came.
struct Samples {
  std::vector<double> t;  ///< in the order of the run
  Eigen::MatrixXd y;      ///< one column for each time
};

/// How a run ended, and where.
struct RunEnd {
  Outcome outcome = Outcome::completed;  ///< how it ended
  std::string message{};                 ///< how it ended, with the numbers and what to do
  double t = 0.0;                        ///< time of the last good state
  Eigen::VectorXd y{};                   ///< the last good state, [q; q̇; …]

  /// Whether t_end was reached.
  bool completed() const noexcept { return outcome == Outcome::completed; }
};

/// The result of a run.
///
/// @tparam n  number of coordinates, or Dynamic
template <int n = Dynamic>
struct Run : RunEnd {
  Trajectory<n> trajectory;           ///< dense output from the start to t; only its start if keep_trajectory is off
  Samples samples;                    ///< at options.output_times
  std::vector<RecordedEvent> events;  ///< in the order of time; trajectory.before(t) and at(t) are the two sides of a jump
  Statistics statistics;              ///< what it cost

  /// The last good state as coordinates and velocities.
  State<n> state() const {
    const Eigen::Index dof = trajectory.dof();
    if (dof < 1) throw InvalidValue("a state needs coordinates, but this first-order system has none; use y");
    using Q = Vector<double, n>;
    return State<n>{t, Eigen::Map<const Q>(y.data(), dof), Eigen::Map<const Q>(y.data() + dof, dof)};
  }
};

/// What an observer answers.
enum class Control {
  proceed,  ///< go on
  stop      ///< end here, as stopped_by_observer
};

/// An accepted step as an observer sees it; valid during the call only.
class StepView {
 public:
  template <Stepper S>
  StepView(S& stepper, Eigen::Index dof) : StepView(stepper, dof, stepper.t(), stepper.y()) {}

  /// The step as far as (t, y), where an event cut it off.
  template <Stepper S>
  StepView(S& stepper, Eigen::Index dof, double t, const Eigen::Ref<const Eigen::VectorXd>& y, std::span<const RecordedEvent> events = {})
      : t_(t),
        t_previous_(stepper.t_previous()),
        y_(y),
        events_(events),
        statistics_(stepper.statistics()),
        dof_(dof),
        stepper_(&stepper),
        interpolate_([](void* s, double at, Eigen::Ref<Eigen::VectorXd> out) { static_cast<S*>(s)->interpolate(at, out); }) {}

  /// End of the step.
  double t() const noexcept { return t_; }
  /// Its beginning.
  double t_previous() const noexcept { return t_previous_; }

  /// State at t(); both sides of a jump are shown, one after the other.
  Eigen::Ref<const Eigen::VectorXd> y() const { return y_; }
  /// Coordinates at its end.
  Eigen::Ref<const Eigen::VectorXd> q() const { return Eigen::Map<const Eigen::VectorXd>(y_.data(), dof_); }
  /// Velocities at its end.
  Eigen::Ref<const Eigen::VectorXd> qdot() const { return Eigen::Map<const Eigen::VectorXd>(y_.data() + dof_, dof_); }

  /// State at a time between t_previous() and t(), from the step's dense output.
  Eigen::VectorXd y_at(double t) const {
    Eigen::VectorXd result(y_.size());
    interpolate_(stepper_, t, result);
    return result;
  }

  /// What has happened since the observer was shown a state before; y_at() has the states of those that only look.
  std::span<const RecordedEvent> events() const noexcept { return events_; }

  /// Counts so far; wall_seconds is filled at the end of the run only.
  const Statistics& statistics() const noexcept { return statistics_; }

 private:
  double t_, t_previous_;
  Eigen::Ref<const Eigen::VectorXd> y_;
  std::span<const RecordedEvent> events_;
  const Statistics& statistics_;
  Eigen::Index dof_;
  void* stepper_;
  void (*interpolate_)(void*, double, Eigen::Ref<Eigen::VectorXd>);
};

/// Called after every accepted step. Returns nothing, or false or Control::stop to end the run.
template <class O>
concept Observer =
    std::invocable<O&, const StepView&> && (std::is_void_v<std::invoke_result_t<O&, const StepView&>> ||
                                            std::same_as<std::invoke_result_t<O&, const StepView&>, bool> ||
                                            std::same_as<std::invoke_result_t<O&, const StepView&>, Control>);

/// The observer that watches nothing and costs nothing.
struct NoObserver {
  /// Does nothing.
  void operator()(const StepView&) const noexcept {}
};

namespace detail {

// An observer of any type; show() is false where it asks to stop.
struct Onlooker {
  void* observer = nullptr;
  bool (*show)(void* observer, const StepView& step) = nullptr;
};

// A run whose number of coordinates is known.
template <int n>
Run<n> run_of(Run<>&& run) {
  if constexpr (n == Dynamic) {
    return std::move(run);
  } else {
    return {{static_cast<RunEnd&&>(run)}, Trajectory<n>(std::move(run.trajectory)), std::move(run.samples), std::move(run.events), std::move(run.statistics)};
  }
}

#ifdef QDOT_COMPILED
extern template Run<1> run_of<1>(Run<>&&);
extern template Run<2> run_of<2>(Run<>&&);
extern template Run<3> run_of<3>(Run<>&&);
extern template Run<4> run_of<4>(Run<>&&);
extern template Run<5> run_of<5>(Run<>&&);
extern template Run<6> run_of<6>(Run<>&&);
extern template Run<7> run_of<7>(Run<>&&);
extern template Run<8> run_of<8>(Run<>&&);
#endif

// Coordinates in y = [q; q̇; …]: what the system says, otherwise half of an even size.
template <FirstOrderSystem F>
constexpr int dof_at_compile_time() {
  if constexpr (requires { F::dof_at_compile_time; }) {
    return F::dof_at_compile_time;
  } else if constexpr (F::size_at_compile_time > 0 && F::size_at_compile_time % 2 == 0) {
    return F::size_at_compile_time / 2;
  } else {
    return Dynamic;
  }
}

template <FirstOrderSystem F>
Eigen::Index dof(const F& system) {
  if constexpr (requires { system.dof(); }) {
    return system.dof();
  } else {
    return system.size() % 2 == 0 ? system.size() / 2 : 0;
  }
}

template <FirstOrderSystem F, class Start>
void require_dof(const F& system, const Start& start) {
  for (const auto& [what, size] : {std::pair("q", start.q.size()), {"qdot", start.qdot.size()}})
    if (size != dof(system))
      throw DimensionError(what, static_cast<long>(dof(system)), static_cast<long>(size), "pass one entry for each coordinate of the system");
}

// A start's y has one entry for each component.
template <class = void>
void require_components(Eigen::Index given, Eigen::Index needed) {
  if (given != needed)
    throw DimensionError("y", static_cast<long>(needed), static_cast<long>(given), "pass one entry for each component of the system");
}

// y of a start, which is a State (packed by the system's form, if it knows how) or has a y of its own.
template <FirstOrderSystem F, class Start>
Eigen::VectorXd packed(const F& system, const Start& start) {
  if constexpr (requires { start.q; }) {
    constexpr int given = decltype(start.q)::SizeAtCompileTime, needed = dof_at_compile_time<F>();
    static_assert(given == Dynamic || needed == Dynamic || given == needed,
                  "qdot: the start is a State of another number of coordinates than the system has: take State<n> with the n of mechanical_system<n>");
  }
  if constexpr (requires { start.y; }) {
    require_components(start.y.size(), system.size());
    return start.y;
  } else if constexpr (requires { system.packed(start); }) {
    const auto given = system.packed(start);
    Eigen::VectorXd y(given.size());
    std::copy_n(given.data(), given.size(), y.data());
    return y;
  } else {
    require_dof(system, start);
    Eigen::VectorXd y(system.size());
    y << start.q, start.qdot;
    return y;
  }
}

}  // namespace detail
}  // namespace qdot
