#pragma once
// SPDX-License-Identifier: MIT
//
// The loop behind simulate(): what happens around the steps of a method.
//
// A run is a chain of legs between landing points: the stop times on the way, and t_end. On each leg
//
//     step → check → keep → show → budget,
//
// that is: one accepted step of the method, on the constraints; is the state finite and within its limit. Then: append the step's polynomial and fill
// the output times that it covers; show it to the observer; are steps, evaluations and seconds left. At a stop time the method begins afresh. Where
// there are events (event.hpp), a step is searched for them before it is kept, and one that stops the run or changes the state cuts it short.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/ad/vector.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/any_stepper.hpp"
#include "qdot/integrate/driver/branch_course.hpp"
#include "qdot/integrate/driver/consistent_start.hpp"
#include "qdot/integrate/driver/ending.hpp"
#include "qdot/integrate/driver/event_watch.hpp"
#include "qdot/integrate/driver/landing_points.hpp"
#include "qdot/integrate/driver/listed_event.hpp"
#include "qdot/integrate/driver/motion_scale.hpp"
#include "qdot/integrate/driver/output_samples.hpp"
#include "qdot/integrate/driver/run_limits.hpp"
#include "qdot/integrate/event.hpp"
#include "qdot/integrate/time_point.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/integrate/steps/one_step.hpp"
#include "qdot/integrate/steps/watch_budget.hpp"
#include "qdot/integrate/watch/any_watch.hpp"
#include "qdot/integrate/watch/diagnosis.hpp"
#include "qdot/integrate/watch/driven_form.hpp"

namespace qdot::detail {
// One loop for all systems, methods, observers and events, and one more for runs without events and without an observer.
template <bool watches, bool is_observed>
class Driver {
  using Watch = std::conditional_t<watches, EventWatch<DrivenForm>, NothingToWatch>;
  static constexpr long most_firings = 50'000;  // in one step

 public:
  /// Writes into `run`, which is empty.
  Driver(Run<>& run, const DrivenForm& system, AnyStepper stepper, const Options& options, const Budget& budget, Onlooker onlooker,
         std::vector<ListedEvent> events)
      : system_(system), stepper_(std::move(stepper)), options_(options), onlooker_(onlooker), watch_(system, std::move(events)),
        watchdog_(system.watch(options_)), scale_(!options.atol.is_default() || stepper_.has_fixed_step()),
        watches_time_(watchdog_->watches_time()), limits_(budget), run_(run) {}

  // Once more, without anything kept but the end: a stretch, for which steps, evaluations and seconds are counted afresh. Events that
  // stopped the one before, stopped_by(), do so again only when they come again. Allocates nothing where it completes.
  void stretch(double t0, const Eigen::VectorXd& y0, double t_end, [[maybe_unused]] std::uint64_t stopped_by) {
    if constexpr (watches) watch_.forget(stopped_by);
    limits_.begin_again(options_, stepper_.statistics());
    run_.outcome = Outcome::completed, run_.events.clear();
    t_end_ = leg_end_ = t_end;
    if (start(t0, y0) && t_end != t0) leg(t_end);
    run_.message = run_.completed() ? std::string() : how_it_ended(run_.outcome, run_.message, run_.t, limits_.steps_of_stretch(stepper_.statistics()), "");
  }

  std::uint64_t stopped_by() const {
    if constexpr (watches) if (run_.outcome == Outcome::stopped_by_event) return watch_.fired();
    return 0;
  }
  const Statistics& statistics() const noexcept { return stepper_.statistics(); }

  void run(double t0, const Eigen::VectorXd& y0, double t_end) {
    const auto landings = landing_points(options_.stop_times, t0, t_end);
    t_end_ = t_end, leg_end_ = landings.empty() ? t_end : landings.front();
    outputs_.prepare(options_.output_times, t0, t_end, system_.size());
    run_.trajectory = Trajectory<>(system_.dof());
    if (start(t0, y0)) {
      for (std::size_t i = 0; i < landings.size(); ++i)
        if ((i > 0 && !restart(landings[i])) || !legs(landings[i], i == 0)) break;
    }
    finish();
  }

 private:
  // The first evaluation. Its errors are the caller's, for there is nothing yet to keep.
  [[gnu::cold]] bool start(double t0, const Eigen::VectorXd& y_given) {
    run_.t = t0, run_.y = y_given;
    Eigen::VectorXd& y0 = run_.y;
    if constexpr (watches) watch_.set_clocks(t0, t_end_);
    if constexpr (watches) watch_.settle(t0, y0, tolerance(y0), run_.events);
    if (system_.is_constrained()) require_consistent(system_, t0, y0, projected_);
    run_.trajectory.start(t0, y0);
    take_scale(t0, y0);
    try {
      stepper_.reset(t0, y0);
    } catch (const StopRequest& request) {
      return end(Outcome::stopped_by_model, request.what());
    }
    count_from_here();
    fill_outputs_here();
    watchdog_->begin(t0, y0, stepper_.statistics().steps);
    if (const std::optional<Failure> trouble = watchdog_->look_at_values_and_mass(t0, y0)) return end(*trouble);
    if constexpr (watches) watch_.begin(t0, y0, tolerance(y0), true);
    branches_.begin(*watchdog_, stepper_, t0, y0);
    return true;
  }

  // The tolerances that the motion asks for where the user gave none; as long as nothing moves, each fresh start asks again.
  void take_scale(double t, const Eigen::VectorXd& y) { if (!scale_.is_known() && scale_.take(system_, options_, t, y, leg_end_)) tolerate(); }
  void tolerate() { options_.atol = scale_.tolerances(), stepper_.tolerate(scale_.tolerances()); }

  // From here to `landing`, with a landing at each time of a clock (integrate/driver/event_clocks.hpp).
  bool legs(double landing, [[maybe_unused]] bool at_start) {
    if constexpr (watches) {
      if (at_start && watch_.clocks().next(run_.t, true, landing) == run_.t && !begins_by_clocks()) return false;
      while (watch_.clocks().any() && watch_.clocks().next(run_.t, false, landing) < landing)
        if (!leg(watch_.clocks().due())) return false;
    }
    return leg(landing);
  }

  // What clocks ask for at t₀.
  [[gnu::cold]] bool begins_by_clocks() {
    const Firing firing = watch_.firing_of_clocks(elapsed_);
    bool proceed = true;
    if (!firing.stops && !firing.changes) return watch_.record(firing, run_.events), true;
    return guarded([&] { proceed = cut(firing, true), outputs_.amend_here(elapsed_, clock_.origin(), run_.y); }) && proceed;
  }

  // From here to `landing`; false when the run is over before it.
  bool leg(double landing) {
    clock_.head_for(landing);
    while (elapsed_ != clock_.length()) {
      double t = stepper_.t(), limit = landing;
      while (watches_time_ && clock_.is_at(limit = watchdog_->reach(t, stepper_.y(), landing, stepper_.has_fixed_step()), elapsed_) && limit != t) t = limit;
      if (const double shown = watches_time_ ? watchdog_->first_shown(t) : t; shown != stepper_.t() && !restart(landing, shown, false)) return false;
      const double seen = branches_.seen();
      const bool again = std::abs(seen - t) < std::abs(limit - t) && !clock_.is_at(seen, elapsed_);
      if (!stepper_.step(again ? seen : limit)) {
        if (!leapt()) return run_.completed() && stuck();
      } else if (const Passage passed = branches_.passage(*watchdog_, stepper_, clock_, elapsed_, reached(), run_.t, run_.y); passed.trouble) {
        if (!ended_by(passed)) return false;
      } else if (passed.cut) {
        if (!cut_at_branch(passed, landing)) return false;
      } else if (passed.retake) {
        reset_at(stepper_, clock_.time_point(elapsed_), run_.y);
      } else if (!state_is_sound() || !watched(landing) || !kept() || !within_budget(landing)) return false;
    }
    return true;
  }

  // Ends the run, unless an event before it, or there, stops it or changes the state.
  bool ended_by(const Passage& passed) {
    if constexpr (watches) if (watch_.looks_at_steps()) return passed_events(passed.until, passed.trouble);
    return guarded([&] { kept_part(passed.until, clock_.t(passed.until)); }) && end(*passed.trouble);
  }
  // Ends the step where it leaves its branch, unless an event stops it before or changes the state, and goes on from there on the next branch.
  bool cut_at_branch(const Passage& passed, double landing) {
    const auto [restarts, last] = std::pair(restarts_, *passed.cut);
    bool proceed = true;
    if (last != elapsed_) {
      if constexpr (watches) proceed = passed_events(last, {}, true);
      else proceed = guarded([&] { kept_part(last, clock_.t(last)); }) && observed(false);
    }
    if (!proceed || restarts_ != restarts) return proceed;  // an event has begun afresh
    if (const auto crowding = branches_.crowding(stepper_, run_.t, elapsed_, reached())) return end(*crowding);
    if (watchdog_->is_due(std::abs(reached() - elapsed_)) && !looked_at(run_.t, run_.y)) return false;
    return elapsed_ == clock_.length() || (guarded([&] { branches_.go_on(stepper_, clock_, passed, elapsed_, run_.y); }) && within_budget(landing));
  }

  // Whether no step was taken for the equations jump here, and the system knows the other side.
  [[gnu::cold]] bool leapt() {
    bool found = false;
    if constexpr (watches) guarded([&] { found = system_.leap(run_.t, run_.y); }), watch_.forget_firing();
    if (found && options_.keep_trajectory) run_.trajectory.jump(run_.y);
    if (found) begin_afresh(false);
    return found;
  }
  void begin_afresh(bool at_start) {
    ++restarts_, take_scale(run_.t, run_.y), reset_at(stepper_, clock_.time_point(elapsed_), run_.y);
    if constexpr (watches) watch_.begin(run_.t, run_.y, tolerance(run_.y), at_start);
    watchdog_->begin(run_.t, run_.y, stepper_.statistics().steps);
  }

  // No step was taken; if the model has changed, that is the reason.
  [[gnu::cold]] bool stuck() {
    if (const std::optional<Failure> change = watchdog_->change(run_.t)) return end(*change);
    return end_explained(stepper_.failure());
  }

  // Looks at the state now and then, and always where something may change (integrate/watch/any_watch.ipp). Before the call of the observer, which
  // may change the state.
  bool watched(double landing) {
    if (!watchdog_->is_due(std::abs(reached() - elapsed_)) && stepper_.t() != landing) return true;
    projected_ = stepper_.y();
    if (!looked_at(stepper_.t(), projected_)) {
      if constexpr (!watches) keep();  // an event in this last step might have cut it off
      return false;
    }
    if (stepper_.t() != landing) watchdog_->remember(stepper_.t(), projected_);
    return true;
  }
  bool looked_at(double t, const Eigen::VectorXd& y) {
    std::optional<Failure> trouble = watchdog_->look(t, y, stepper_.statistics().steps, stepper_.statistics().limiting_component() >= 0);
    if (!trouble && !stepper_.is_current()) trouble = other_formula();
    return !trouble || end(*trouble);
  }

  // Appends the step to the run, as far as events let it.
  bool kept() {
    if constexpr (watches) if (watch_.looks_at_steps()) return passed_events(reached(), {});
    return kept_whole();
  }
  bool kept_whole() { return keep(), observed(elapsed_ == clock_.length()); }

  // Takes the events of the step up to `last`, in their order; keeps the step, or what is left of it, or ends the run for trouble.
  bool passed_events(double last, const std::optional<Failure>& trouble, bool cuts = false) {
    bool proceed = true;
    const bool evaluated = guarded([&] {
      watch_.search(clock_, stepper_.polynomial(), elapsed_, last, tolerance(stepper_.y()));
      for (long firings = 0; const std::optional<Firing> firing = watch_.next(); ++firings) {
        if (firing->stops || firing->changes) {
          proceed = cut(*firing);
          return;
        }
        watch_.record(*firing, run_.events);
        watch_.pass(*firing, firings >= most_firings);
      }
      if (trouble || cuts) kept_part(last, clock_.t(last));
      proceed = trouble ? end(*trouble) : cuts ? observed(false) : kept_whole();
    });
    return evaluated && proceed;
  }

  // Ends the step at a firing, and goes on from the state that it leaves behind.
  bool cut(const Firing& firing, bool at_start = false) {
    Eigen::VectorXd y = kept_part(firing.elapsed, firing.t);
    if (!looked_at(firing.t, y)) return false;
    watch_.record(firing, run_.events);
    if (!observed(true)) return false;
    if (firing.stops) return fill_outputs_here(), end(Outcome::stopped_by_event, sentence({"'", run_.events.back().name, "' asked to stop"}));
    if (const std::optional<Failure> wrong = watch_.change(firing, y, tolerance(y), run_.events)) return end(*wrong);
    run_.y = y;
    if (options_.keep_trajectory) run_.trajectory.jump(y);
    if (const auto name = watch_.accumulating(firing.elapsed))
      return end(Outcome::zeno, sentence({"events of ", *name, " follow each other without letting t go on"}));
    begin_afresh(at_start);
    fill_outputs_here();
    return observed(false);
  }

  // What the method cannot tell from zero in each component of y.
  template <class Y>
  const Eigen::VectorXd& tolerance(const Y& y) const {
    tolerance_.resize(y.size());
    for (Eigen::Index i = 0; i < y.size(); ++i) tolerance_[i] = options_.rtol * std::abs(y[i]) + options_.atol[i];
    return tolerance_;
  }

  // A fresh start of the method from where it is, a little behind a stop time or switch. The trajectory so far must survive what the model throws.
  bool restart(double landing) { return leg_end_ = landing, restart(landing, std::nextafter(run_.t, landing), true); }
  [[gnu::cold]] bool restart(double landing, double behind, bool begins_leg) {
    ++restarts_;
    return guarded([&] {
      if constexpr (watches)
        if (watch_.settle_behind_jump(behind, landing < run_.t, run_.y, tolerance(run_.y), run_.events) && options_.keep_trajectory)
          run_.trajectory.jump(run_.y);
      take_scale(behind, run_.y);
      reset_at(stepper_, TimePoint(run_.t, 0.0, behind == landing ? run_.t : behind), run_.y), count_from_here(), clock_.head_for(landing);
      if (begins_leg) watchdog_->begin(run_.t, run_.y, stepper_.statistics().steps);
    });
  }

  // This leg counts as the stepper does, from its last fresh start.
  void count_from_here() { clock_.start(time_point_of(stepper_)), elapsed_ = reached(); }
  double reached() const { return time_point_of(stepper_).elapsed; }

  // Runs what may find the model refusing; false, with the outcome noted, if it did.
  template <class Evaluation>
  bool guarded(Evaluation&& evaluation) {
    Failure failure;
    return attempted(failure, evaluation) || end(failure);
  }
  bool state_is_sound() {
    const std::optional<Failure> trouble = unsound_state(system_, stepper_.y(), stepper_.t(), options_.state_norm_limit);
    if (!trouble) return scale_.grows() && scale_.has_outgrown(stepper_.y()) ? tolerate(), true : true;
    if (trouble->outcome == Outcome::non_finite) return end_explained(*trouble);
    keep();
    return end(*trouble);
  }

  void keep() { keep_until(reached(), stepper_.t(), stepper_.y()), fill_outputs_here(); }
  // Appends the step as far as t, where the state is returned.
  Eigen::VectorXd kept_part(double elapsed, double t) {
    Eigen::VectorXd y(system_.size());
    if (elapsed == reached()) y = stepper_.y();
    else if (elapsed == elapsed_) y = run_.y;
    else stepper_.polynomial().at(elapsed, y), system_.project(t, y);
    return keep_until(elapsed, t, y), y;
  }

  // Appends the step as far as (t, y).
  void keep_until(double elapsed, double t, const Eigen::Ref<const Eigen::VectorXd>& y) {
    if (options_.keep_trajectory && elapsed != elapsed_) run_.trajectory.append(t, elapsed, stepper_.polynomial());
    const double sign = reached() >= elapsed_ ? 1.0 : -1.0;
    elapsed_ = elapsed, run_.t = t, run_.y = y;
    outputs_.fill_before(elapsed, sign, clock_.origin(), watch_.same(run_.t), [&](double at, Eigen::VectorXd& out) {
      stepper_.interpolate(at, out);
      if (system_.is_constrained()) guarded([&] { system_.project(at, out); });  // between steps the polynomial leaves the constraints
    });
  }

  void fill_outputs_here() { outputs_.fill_here(elapsed_, clock_.origin(), watch_.same(run_.t), run_.y); }

  // Shows the state to the observer, which may change what functors read only where the method begins afresh behind it.
  bool observed(bool begins_afresh) {
    if constexpr (!is_observed) {
      return (void)begins_afresh, true;
    } else {
      const StepView view(stepper_, run_.trajectory.dof(), run_.t, run_.y,
                          {run_.events.data() + shown_, run_.events.size() - std::exchange(shown_, run_.events.size())});
      if constexpr (watches) watch_.remember(run_.t, run_.y);
      const bool proceed = onlooker_.show(onlooker_.observer, view);
      if constexpr (watches) {
        const std::optional<Failure> changed = watch_.begin_changed(run_.t, run_.y);
        if (changed && !begins_afresh) return end(*changed);
      }
      return proceed || end(Outcome::stopped_by_observer, "the observer asked to stop");
    }
  }

  // Adds the diagnosis of an end that the user did not ask for (integrate/watch/diagnosis.hpp).
  [[gnu::cold, gnu::noinline]] std::string why(Outcome outcome) const {
    const Statistics& s = stepper_.statistics();
    const auto [done, left] = ways();
    return explanation(Probe{system_}, outcome,
                       {run_.t, run_.y, tolerance(run_.y), t_end_ < run_.t ? -1.0 : 1.0, s.last_step, done, left,
                        limits_.steps_since_look(s), limits_.restarts_since_look(restarts_), watchdog_->mass_rcond()});
  }

  // From the start to here, and from here to the end.
  std::pair<double, double> ways() const {
    return {std::abs((clock_.origin() - run_.trajectory.front_time()) + elapsed_), std::abs((t_end_ - clock_.origin()) - elapsed_)};
  }

  // Asked between steps, and not when there is nothing left to do on this leg.
  bool within_budget(double landing) {
    if (stepper_.t() == landing || !limits_.are_near(options_, stepper_.statistics())) return true;
    const std::optional<Failure> spent = limits_.exceeded(options_, stepper_.statistics(), restarts_, t_end_, [this] { return ways(); });
    if (!spent) return true;
    const bool asks_why = spent->outcome == Outcome::step_limit || spent->outcome == Outcome::step_too_small;
    return asks_why ? end_explained(*spent) : end(*spent);
  }

  // Notes how the run ended; false.
  [[gnu::cold, gnu::noinline]] bool end(const Failure& failure) { return end(failure.outcome, failure.message); }
  [[gnu::cold, gnu::noinline]] bool end_explained(const Failure& failure) { return end(failure.outcome, sentence({failure.message, why(failure.outcome)})); }
  [[gnu::cold, gnu::noinline]] bool end(Outcome outcome, const std::string& message) { return run_.outcome = outcome, run_.message = message, false; }
  [[gnu::cold]] void finish() {
    run_.statistics = stepper_.statistics();
    if (run_.statistics.evaluated_by.empty()) run_.statistics.evaluated_by = system_.way_taken();
    run_.statistics.restarts = restarts_;
    watchdog_->report(run_.statistics);
    if (const auto verdict = run_.completed() ? watchdog_->verdict() : std::nullopt) end(*verdict);
    if constexpr (watches) watch_.report(run_.statistics);
    run_.statistics.wall_seconds = limits_.seconds();
    run_.samples = outputs_.taken();
    run_.message = how_it_ended(run_.outcome, run_.message, run_.t, run_.statistics.steps, scale_.remark());
    if (run_.completed() && run_.statistics.unresolved_events > 0) run_.message = sentence({run_.message, "; an event's function could not be followed"});
  }

  const DrivenForm& system_;
  AnyStepper stepper_;
  Options options_;
  Onlooker onlooker_;
  Watch watch_;
  std::unique_ptr<AnyWatch> watchdog_;
  MotionScale scale_;
  bool watches_time_;
  RunLimits limits_;
  Run<>& run_;
  OutputSamples outputs_;
  std::size_t shown_ = 0;  // events that the observer has seen
  Eigen::VectorXd projected_;
  mutable Eigen::VectorXd tolerance_;  // as last asked for
  long restarts_ = 0;
  Clock clock_;           // of this leg
  double elapsed_ = 0.0, t_end_ = 0.0, leg_end_ = 0.0;  // elapsed on it, at run_.t
  BranchCourse branches_;
};

}  // namespace qdot::detail
