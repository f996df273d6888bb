#pragma once
// SPDX-License-Identifier: MIT
//
// Accuracy as a request: a bound of the *global* error, not of that of a step.
//
//     const auto result = simulate_to_accuracy(system, start, 10.0, Dop853{}, 1e-9);
//     if (!result.reached()) std::cerr << result.run.message << '\n';
//     result.run.trajectory …, result.error_estimate, result.forecast[0].seconds …
//
// The error at all output times, each component beside its own largest value (integrate/accurate/motion.hpp), is at most the number
// asked for. A few runs are compared and find the tolerance for that (integrate/accurate/search.hpp). The last one is returned:
//
//     error_estimate ≤ accuracy        measured, not assumed, or
//     Outcome::accuracy_not_reached    double has too few digits, or the options' limits forbid it: the most accurate run,
//
// or the run ends as any run may end. The interpolant counts between steps. Without output times the runs are compared at 64 equal
// parts of the time if the trajectory is kept, else at the end. Cost: mostly two to three times that of one run (docs/lab/accuracy.md).

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/integrate/accurate/motion.hpp"
#include "qdot/integrate/accurate/search.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/statistics.hpp"
#include "qdot/integrate/watch/change_watch.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot {

/// A run, and how accurate it is.
template <int n = Dynamic>
struct AccurateRun : AccuracyReport {
  Run<n> run;  ///< the most accurate of all
};

namespace detail {

// One run as the search sees it.
template <class R>
struct Launched {
  R run;  // with its outcome, message and statistics
  Motion motion;
};

// Evaluations that a run was worth.
inline double work(const Statistics& statistics, Eigen::Index size) {
  const double order = statistics.highest_order;
  const double each = statistics.method == "taylor" ? (order + 1) * (order + 1) : 1.0;
  return each * static_cast<double>(statistics.evaluations) + static_cast<double>(statistics.jacobians * size);
}

// How often the motion changes altogether while it lasts: a step of order p that errs by τ takes τ^{1/(p+1)} of such
// a time.
inline double natural_times(const Statistics& statistics, double tolerance) {
  return static_cast<double>(statistics.steps) * std::pow(tolerance, 1.0 / (statistics.highest_order + 1));
}

// Multistep methods are other than those of one step.
inline ToleranceLaw law_of(const Statistics& statistics) {
  ToleranceLaw law;
  const int order = statistics.highest_order;
  if (order <= 5 && statistics.method != "taylor") law.second *= 5;
  if (statistics.method.find("cvode") == std::string::npos) return law;
  law.slowness = 1.0 / (order + 1);
  law.rounding = 10 * std::numeric_limits<double>::epsilon();
  law.drowned = 0.0;
  law.times = 1.0;
  law.nearest = 20.0;
  return law;
}

// What comes later: the largest rates that the start would have at other times of the run. With them, the time in which their
// effect changes them by their own size.
struct Push {
  Eigen::VectorXd rate;
  double time = 0.0;
};
template <FirstOrderSystem F>
Push push(const F& system, Eigen::Index dof, double t, const Eigen::VectorXd& y, double way) {
  constexpr int looks = 16, halvings = 60;
  constexpr double golden = 0.6180339887498949;  // no period of a drive is a multiple of it
  Push result{Eigen::VectorXd::Zero(y.size()), std::abs(way)};
  Eigen::VectorXd f(y.size()), strongest = Eigen::VectorXd::Zero(y.size()), moved(y.size());
  double at = t;
  const auto rates = [&](double time, const Eigen::VectorXd& state) {
    try {
      system.derivative(time, state, f);
    } catch (const Error&) {  // a state that the model refuses says nothing
      return false;
    }
    return f.allFinite();
  };
  for (int k = 0; k < looks; ++k) {
    const double time = t + way * (k * golden - std::floor(k * golden));
    if (!rates(time, y)) continue;
    if (f.norm() > strongest.norm()) strongest = f, at = time;
    result.rate = result.rate.cwiseMax(f.cwiseAbs());
  }
  for (int k = 0; k < halvings; ++k, result.time /= 2) {
    moved = y + result.time * strongest;
    for (Eigen::Index i = 0; i < dof; ++i) moved[i] += result.time * result.time * strongest[dof + i];
    if (rates(at, moved) && (f - strongest).tail(y.size() - dof).norm() <= strongest.tail(y.size() - dof).norm()) break;
  }
  return result;
}

// Sizes that the components may be expected to take, from the start alone. They are |y|, and what its rates add in the shortest
// time in which a coordinate, or a velocity, changes by its own size. Where that leaves a component nothing, or a rounding error,
// what comes later counts too, and the sizes of its kind.
template <FirstOrderSystem F>
ComponentSizes expected_sizes(const F& system, Eigen::Index dof, double t, const Eigen::VectorXd& y, double way) {
  const double duration = std::abs(way);
  Eigen::VectorXd rate = Eigen::VectorXd::Zero(y.size());
  try {
    system.derivative(t, y, rate);
  } catch (const Error&) {  // the run itself will say what is wrong
  }
  if (!rate.allFinite()) rate.setZero();
  double time = duration;
  const auto shorten = [&](double part) {
    if (part > 0) time = std::min(time, part);
  };
  for (Eigen::Index i = 0; i < y.size(); ++i) {
    shorten(std::abs(y[i] / rate[i]));
    if (i < dof) shorten(std::sqrt(std::abs(y[i] / rate[dof + i])));
  }
  Eigen::VectorXd sizes = y.cwiseAbs().cwiseMax(time * rate.cwiseAbs());
  for (Eigen::Index i = 0; i < dof; ++i) sizes[i] = std::max(sizes[i], time * sizes[dof + i]);
  constexpr double least = 1e-10;
  if (sizes.size() > 0 && sizes.minCoeff() <= least * sizes.maxCoeff()) {
    const Push later = push(system, dof, t, y, way);
    const Eigen::VectorXd gained = later.time * later.rate;
    sizes = sizes.cwiseMax(gained);
    for (Eigen::Index i = 0; i < dof; ++i) sizes[i] = std::max(sizes[i], later.time * gained[dof + i]);
    lend_sizes(sizes, dof, least);
  }
  return component_sizes(system, dof, sizes, {t}, y, duration);
}

inline bool is_limit(Outcome outcome) noexcept {
  return outcome == Outcome::step_limit || outcome == Outcome::evaluation_limit || outcome == Outcome::time_limit;
}

// The ends of a run that may be due to a tolerance that double cannot keep.
inline bool is_of_tolerance(Outcome outcome, double tolerance) noexcept {
  const bool of_steps = outcome == Outcome::step_too_small || outcome == Outcome::error_test_failure ||
                        outcome == Outcome::corrector_failure || outcome == Outcome::accuracy_not_reached;
  return is_limit(outcome) || (of_steps && tolerance < 1e-11);
}

// The runs of a search for accuracy, the report of them so far, and what they say of each other.
template <class Accurate, FirstOrderSystem F>
class AccuracyTrials {
  using R = decltype(Accurate::run);

 public:
  AccuracyTrials(const F& system, Eigen::Index dof, double accuracy, ComponentSizes sizes)
      : system_(system), dof_(dof), sizes_(std::move(sizes)), scale_(sizes_.sizes), largest_scale_(most_growth * scale_), search_(accuracy) {
    result_.accuracy = accuracy;
  }

  std::optional<double> next_tolerance() const { return search_.next(); }
  Eigen::VectorXd absolute_tolerances(double tolerance) const { return sizes_.tolerances(tolerance, scale_); }

  // Takes in a run; false where no further one helps.
  bool add(Launched<R> now, double tolerance, const Eigen::VectorXd& atol) {
    result_.evaluations += now.run.statistics.evaluations;
    result_.seconds += now.run.statistics.wall_seconds;
    if (failed(now.run.outcome)) return add_failed(std::move(now), tolerance, atol);
    compare(now, tolerance);
    before_.push_back(now.motion);
    keep(std::move(now), tolerance, atol);
    return true;
  }

  // The report with the last run.
  Accurate report() {
    result_.run = std::move(last_->run);
    result_.trials = search_.trials();
    if (failed(result_.run.outcome)) return std::move(result_);

    result_.error_estimate = search_.estimate();
    result_.worst = apart_.component < 0 ? "" : system_.component_name(apart_.component);
    result_.worst_time = apart_.t;
    result_.event_time_error = apart_.event_time;
    result_.forecast = search_.forecast();
    if (!result_.reached()) explain_miss();
    return std::move(result_);
  }

 private:
  // Absolute tolerances hardly grow beside the relative one, whatever is seen. A component may be small most of the time and
  // large for an instant, as the rate of an angle about a pole. With larger absolute tolerances it errs by another law, which the
  // first run would not show.
  static constexpr double most_growth = 4.0;

  // Takes in a run that failed; false where no further one helps.
  bool add_failed(Launched<R> now, double tolerance, const Eigen::VectorXd& atol) {
    const Outcome outcome = now.run.outcome;
    if (last_ && is_of_tolerance(outcome, tolerance)) {
      given_up_ = "a run with rtol = " + text_of(tolerance) + " ended with " + now.run.message;
      if (is_limit(outcome)) return false;
      search_.too_tight(tolerance);
      return true;
    }
    const bool certain = last_ || failed_before_ || is_limit(outcome);
    keep(std::move(now), tolerance, atol);
    if (certain) return false;
    failed_before_ = true;
    search_.skipped(tolerance);
    last_.reset();
    return true;
  }

  // Tells the search how far this run is from those before it.
  void compare(const Launched<R>& now, double tolerance) {
    const Statistics& statistics = now.run.statistics;
    sizes_ = component_sizes(system_, dof_, now.motion.sizes, now.motion.t, now.motion.y, now.motion.duration());
    scale_ = sizes_.sizes.cwiseMin(largest_scale_);
    std::vector<double> differences;
    for (const Motion& each : before_) {
      apart_ = difference(each, now.motion, sizes_);
      differences.push_back(apart_.relative);
    }
    search_.ran({tolerance, apart_.relative, work(statistics, system_.size()), statistics.wall_seconds, statistics.method}, differences,
                natural_times(statistics, tolerance), law_of(statistics));
  }

  void keep(Launched<R> now, double tolerance, const Eigen::VectorXd& atol) {
    last_ = std::move(now);
    result_.rtol = tolerance;
    result_.atol = atol;
  }

  // Outcome and message of a run that is not as accurate as it must be.
  void explain_miss() {
    constexpr Outcome missed = Outcome::accuracy_not_reached;
    result_.run.outcome = missed;
    result_.run.message = sentence({name(missed), ": the error of the whole motion must be at most ", result_.accuracy, ", but is estimated at ",
                                    {result_.error_estimate, 2},
                                    result_.worst.empty() ? "" : sentence({", most of all in ", result_.worst, " at t = ", result_.worst_time}),
                                    ", with rtol = ", result_.rtol,
                                    "; ", given_up_.empty() ? "a tighter one does not help" : given_up_, ": ", advice(missed)});
  }

  const F& system_;
  Eigen::Index dof_;
  ComponentSizes sizes_;
  Eigen::VectorXd scale_, largest_scale_;  // for absolute tolerances
  ToleranceSearch search_;
  Accurate result_;
  std::optional<Launched<R>> last_;
  std::vector<Motion> before_;
  MotionDifference apart_;  // the last two
  std::string given_up_;    // why a tighter run counts for nothing
  bool failed_before_ = false;
};

// Runs until it is accurate enough, or cannot be: a report with the last run beside it.
//
// @param launch  (rtol, atol) ↦ Launched<R>
template <class Accurate, FirstOrderSystem F, class Launch>
Accurate accurate(const F& system, Eigen::Index dof, double accuracy, ComponentSizes sizes, Launch&& launch) {
  require_option(accuracy > 0 && accuracy < 1, "the accuracy", "must lie between 0 and 1", accuracy,
                 "ask for the relative error of the whole motion, say 1e-6");
  AccuracyTrials<Accurate, F> trials(system, dof, accuracy, std::move(sizes));
  while (const std::optional<double> tolerance = trials.next_tolerance()) {
    const Eigen::VectorXd atol = trials.absolute_tolerances(*tolerance);
    if (!trials.add(launch(*tolerance, atol), *tolerance, atol)) break;
  }
  return trials.report();
}

}  // namespace detail

/// Simulates so accurately that the relative global error at the output times is at most `accuracy`.
///
/// Takes the arguments of simulate(), without an observer. options.rtol and atol are not looked at; the limits hold for
/// all runs together. Makes two runs, or three where the motion amplifies errors more than most.
///
/// @param accuracy  between 0 and 1; below 1e-13 or so is seldom reached
/// @return          the last run, whose outcome may be accuracy_not_reached, the estimate of its error, and a forecast
/// @throws          as simulate()
template <class System, class Start, class Method, class... Events>
auto simulate_to_accuracy(const System& system, const Start& start, double t_end, const Method& method, double accuracy,
                          Options options = {}, const EventList<Events...>& events = {}) {
  static_assert(!requires { method.step; },
                "a method of fixed step has no tolerance to choose: take Dop853{}, Taylor{} or CvodeBdf{}");
  const auto form = first_order_form(system);
  using Form = std::remove_cvref_t<decltype(form)>;
  constexpr int n = detail::dof_at_compile_time<Form>();
  const Eigen::Index dof = detail::dof(form);
  const Eigen::VectorXd y0 = detail::packed(form, start);
  const double duration = t_end - start.t;
  const bool keep = options.keep_trajectory;
  const bool own_times = options.output_times.empty() && keep;
  constexpr int parts = 64;
  if (own_times)
    for (int k = 1; k < parts; ++k) options.output_times.push_back(start.t + duration * k / parts);

  long evaluations_left = options.max_evaluations;
  double seconds_left = options.max_wall_seconds;
  bool scouting = true;
  const detail::WatchedFormOf watched(form);
  detail::ChangeWatch model(watched, options);  // an event may have changed it in the run before
  model.begin(start.t, y0);
  const auto launch = [&](double rtol, const Eigen::VectorXd& atol) {
    if (const std::optional<Failure> change = model.look(t_end))
      throw InvalidValue("simulate_to_accuracy() runs the motion several times, and each run must find the model as the first one did, but " +
                         change->message.substr(change->message.find(", but ") + 6) +
                         "; keep what an event changes in the state (a controller's z), or take simulate() with two tolerances");
    options.rtol = rtol;
    options.atol = atol;
    options.max_evaluations = std::max(evaluations_left, 1L);
    options.max_wall_seconds = std::max(seconds_left, std::numeric_limits<double>::min());
    options.keep_trajectory = keep && !std::exchange(scouting, false);
    detail::Launched<Run<n>> launched;
    Eigen::VectorXd sizes = y0.cwiseAbs();
    launched.run = simulate(system, start, t_end, method, options,
                            [&](const StepView& step) { sizes = sizes.cwiseMax(step.y().cwiseAbs()); }, events);
    Run<n>& run = launched.run;
    evaluations_left -= run.statistics.evaluations;
    seconds_left -= run.statistics.wall_seconds;
    const Eigen::Index count = run.samples.y.cols();
    launched.motion = {start.t, run.samples.t, Eigen::MatrixXd(y0.size(), count + 1), std::move(sizes), run.events};
    launched.motion.t.push_back(run.t);
    launched.motion.y.leftCols(count) = run.samples.y;
    launched.motion.y.col(count) = run.y;
    if (own_times) run.samples = {};
    return launched;
  };
  return detail::accurate<AccurateRun<n>>(form, dof, accuracy, detail::expected_sizes(form, dof, start.t, y0, duration), launch);
}

// Old names, accepted until 0.4.

/// simulate_to_accuracy() by its old name.
template <class System, class Start, class Method, class... Events>
[[deprecated("qdot: say simulate_to_accuracy()")]]
auto accurate_simulation(const System& system, const Start& start, double t_end, const Method& method, double accuracy,
                         Options options = {}, const EventList<Events...>& events = {}) {
  return simulate_to_accuracy(system, start, t_end, method, accuracy, std::move(options), events);
}

}  // namespace qdot
