#pragma once
// SPDX-License-Identifier: MIT
//
// What time brings: no step passes over a stretch of time that was not looked at.
//
// A system at rest lets a method choose any step, so a push that begins and ends between two evaluations is never felt, and no error
// estimate can tell. So where a signature says that time enters, V(q, t), T(q, qdot, t) or an effect with t, steps are limited:
//
//     formulas   bounds over a stretch [t, t + L] (ad/formula/time_bounds.hpp) give a length s such that nothing shorter happens there.
//                A step may be as long as s, or L where nothing happens. Where s is too short for a long L, L is halved.
//     branches   of time, t > 1 && t < 1.001 ? F : 0: the guards (ad/formula/time_guards.hpp) tell where it switches. The step ends in
//                front of that, and the method begins afresh behind it. A guard with state, q < a sin t, is forecast.
//     others     that ask for plain numbers are sampled 256 times on the way to the end or the next stop time. What they do within less
//                may be missed: stop times, or a max_step, are the remedy.
//
// Statistics::time_resolution is the length that was not looked at. Methods with a step of fixed length land on switches only. Not
// covered: systems of first order, whose signature says nothing, and what happens in a place that is passed quickly (branch_watch.hpp).

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "qdot/ad/formula/time_bounds.hpp"
#include "qdot/ad/formula/time_guards.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/watch/time_formulas.hpp"
#include "qdot/integrate/watch/watched_form.hpp"

namespace qdot::detail {

/// Says how far the next step may go, of a form that takes time.
class TimeWatch {
 public:
  TimeWatch(const WatchedForm& form, const Options& options) : form_(form), options_(options) {}

  /// Begins at a time: that of the start, or where something else begins, and a functor may have become another.
  [[gnu::cold]] void begin(double t, const Eigen::VectorXd& y) {
    if (!record(t, y)) return;  // behind an impact, mostly
    begin_another(t, y);
  }

  /// Begins another motion with the functors as they were when one was begun.
  void begin_another(double t, const Eigen::VectorXd& y) {
    if (has_guards_) record(t, y);
    bounds_.forget();
    t_seen_ = reach_ = horizon_ = landing_ = t;
    wish_ = std::numeric_limits<double>::infinity();
    stale_ = 0;
  }

  /// Where a step from (t, y) towards `landing` must end at the latest; of switches alone, if asked for.
  double reach(double t, const Eigen::VectorXd& y, double landing, bool switches_only = false) {
    behind_ = t;
    if (!bounded_ && is_complete_ && !has_guards_) return landing;
    if (switches_only && !is_complete_) resolution_ = std::max(resolution_, std::abs(t - t_seen_));
    if (t != t_seen_) wish_ = (t == reach_ ? 4.0 : 2.0) * std::abs(t - t_seen_);
    t_seen_ = t;
    const double end = has_guards_ ? next_switch(t, y, landing) : landing;
    reach_ = has_guards_ && guards_.any_of_state() ? forecast(t, y, end) : end;
    if (switches_only || (!bounded_ && is_complete_)) return reach_;
    const double left = std::abs(end - t);
    if (landing_ != end) set_out(t, y, end);
    double room = left;
    if (bounded_) {
      if (std::abs(horizon_ - t) < std::min(wish_, left) || (--stale_ <= 0 && bounds_.depends_on_state())) look(t, y, end);
      room = std::min(room, std::min(step_, std::abs(horizon_ - t)));
    }
    if (!is_complete_) room = std::min(room, sampled(t, y, end));
    if (room < left) reach_ = nearer(t, reach_, t + std::copysign(std::max(room, 64 * epsilon * std::abs(t)), end - t));
    return reach_;
  }

  /// The first time that functors are to be shown of a step from the time last asked about: beside it where something switches there.
  double first_shown() const noexcept { return behind_; }
  /// Whether something switches by time, as the functors are now.
  bool switches_by_time() const noexcept { return guards_.any(Guards::Kind::of_time) || guards_.any(Guards::Kind::of_both); }

  /// Time that may have been passed over without a look; 0: none.
  double resolution() const noexcept { return resolution_; }

 private:
  static constexpr double epsilon = std::numeric_limits<double>::epsilon();
  static constexpr int samples = 256;       // of the way to the end or the next stop time, where there is no formula
  static constexpr double ahead = 64.0;     // steps that a look should be good for
  static constexpr int steps_of_state = 8;  // the same where the state matters as well
  static constexpr double shortest = 1e-10;  // of the way: what remains of a kink, where rates are infinite
  static constexpr int trials_of_time = 2000, trials_of_state = 300;  // of a search for a switch
  static constexpr int most_unfollowed = 100;  // searches that ended without one and before the end
  static constexpr int most_crowded = 10'000;  // switches that change nothing, or follow each other
  static constexpr double crowd = 1e-7;        // of the way, as closely as this
  static constexpr double careful = 1e-8;      // of the way: what is nearer is landed on at once, what is farther in several steps
  static constexpr int most_held = 64;         // steps in a row that are held up by a forecast

  using Guards = formula::TimeGuards;

  static Guards guards_of(const TimeFormulas& f) { return Guards(f.recording.graph, f.guards, f.places, f.t); }
  static bool same(const TimeFormulas& a, const TimeFormulas& b) {
    const auto& x = a.recording.graph.nodes();
    const auto& y = b.recording.graph.nodes();
    return a.roots == b.roots && a.complete == b.complete && a.places == b.places &&
           std::equal(x.begin(), x.end(), y.begin(), y.end(), [](const formula::Node& m, const formula::Node& n) {
             return m.kind == n.kind && m.function == n.function && m.a == n.a && m.b == n.b && m.ca == n.ca && m.cb == n.cb && m.c == n.c;
           });
  }

  // The functors as they are near (t, y).
  TimeFormulas recorded(double t, const Eigen::VectorXd& y) const {
    TimeFormulas found;
    const Eigen::Index velocities = 2 * form_.dof();
    found.state = new_variables(found.recording, 0, velocities);
    found.t = found.recording.graph.variable(static_cast<int>(velocities));
    for (const int z : new_variables(found.recording, velocities + 1, form_.size() - velocities)) found.state.push_back(z);
    formula::Branches branches;
    branches.variables.assign(y.data(), y.data() + form_.size());
    branches.variables.insert(branches.variables.begin() + velocities, t);
    found.recording.branches = &branches;
    form_.record_time(found);
    found.recording.branches = nullptr;
    found.guards = std::move(branches.met);
    for (const formula::Guard& g : found.guards)
      found.places.push_back(g.level == 0.0 ? g.node : found.recording.graph.difference(g.node, found.recording.graph.constant(g.level)));
    return found;
  }

  // Makes these the formulas; false if they have been so before.
  [[gnu::cold]] bool record(double t, const Eigen::VectorXd& y) {
    TimeFormulas found = recorded(t, y);
    scanned_ = t_seen_ = t;
    switch_.reset();
    stale_ = 0;
    if (std::exchange(begun_, true) && !has_guards_ && same(found, formulas_)) return false;
    bounds_ = formula::TimeBounds(found.recording.graph, found.t, found.state, found.roots);
    guards_ = guards_of(found);
    bounded_ = bounds_.is_needed();
    has_guards_ = guards_.any(Guards::Kind::of_time) || guards_.any_of_state();
    is_complete_ = found.complete && unfollowed_ < most_unfollowed;
    formulas_ = std::move(found);
    horizon_ = landing_ = t;
    return true;
  }

  static double nearer(double t, double a, double b) { return std::abs(b - t) < std::abs(a - t) ? b : a; }
  static std::span<const double> as_span(const Eigen::VectorXd& y) { return {y.data(), static_cast<std::size_t>(y.size())}; }

  // Where the next switch by time alone is, on the way to `landing`.
  double next_switch(double t, const Eigen::VectorXd& y, double landing) {
    if (guards_.any_of_state() && guards_.changed(behind_, as_span(y))) record(behind_, y);
    const double direction = landing < t ? -1.0 : 1.0;
    const auto is_ahead = [&](double time, double of) { return (time - of) * direction > 0.0; };
    while (has_guards_) {
      if (switch_ && is_ahead(switch_->last, behind_)) return nearer(t, landing, switch_->last);
      if (switch_ && is_ahead(switch_->first, behind_)) {
        if (!is_ahead(landing, switch_->first)) return landing;
        behind_ = switch_->first;
        record(behind_, y);
        continue;
      }
      switch_.reset();
      if (!is_ahead(landing, scanned_) || unfollowed_ >= most_unfollowed) return landing;
      const double from = is_ahead(scanned_, behind_) ? scanned_ : behind_;
      rates_.setZero(y.size());
      switch_ = guards_.first(Guards::Kind::of_time, from, landing, as_span(y), as_span(rates_), trials_of_time, scanned_);
      if (switch_ && crowded_ < most_crowded) {
        if (std::abs(switch_->last - from) < crowd * std::abs(landing - t)) ++crowded_;
        pass_if_harmless(y);
        continue;
      }
      if (scanned_ == landing) return landing;
      if (switch_ || guards_.gave_up()) unfollowed_ = most_unfollowed;
      if (++unfollowed_ < most_unfollowed && is_ahead(scanned_, behind_)) return scanned_;
      unfollowed_ = most_unfollowed;
      switch_.reset();
      is_complete_ = false;  // samples have to do
      landing_ = t;
    }
    return landing;
  }

  // A switch of nothing that matters, one stair of many, needs no landing.
  void pass_if_harmless(const Eigen::VectorXd& y) {
    if (guards_.any(Guards::Kind::of_both)) return;
    TimeFormulas beyond = recorded(switch_->first, y);
    const auto& now = formulas_;
    if (beyond.complete != now.complete || !formula::same_outputs(beyond.recording.graph, beyond.roots, now.recording.graph, now.roots)) return;
    guards_ = guards_of(beyond);
    formulas_ = std::move(beyond);
    scanned_ = std::exchange(switch_, std::nullopt)->first;
    ++crowded_;
  }

  // Where guards that depend on state may switch before `end`, as the state is going now.
  double forecast(double t, const Eigen::VectorXd& y, double end) {
    const double way = std::min(std::abs(end - t), 2.0 * wish_), direction = end < t ? -1.0 : 1.0;
    rates_.resize(y.size());
    state_ = y;
    try {
      form_.derivative(behind_, state_, rates_);
    } catch (const Error&) {
      return end;
    }
    double nearest = end, clear = t;
    const double from = behind_, to = nearer(t, end, from + direction * way);
    const auto found = guards_.any(Guards::Kind::of_both)
                           ? guards_.first(Guards::Kind::of_both, from, to, as_span(state_), as_span(rates_), trials_of_state, clear)
                           : std::nullopt;
    if (!found || ++held_ > most_held) {
      held_ = 0;
    } else if (found->last == from && (end - found->first) * direction > 0.0) {  // it is here
      behind_ = found->first;
      record(behind_, y);
      return forecast(t, y, next_switch(t, y, end));
    } else {
      const double gap = std::abs(found->last - t);
      nearest = t + direction * (gap > careful * std::abs(end - t) ? 0.75 * gap : gap);
    }
    const Eigen::Index dof = form_.dof();
    for (Eigen::Index i = 0; i < state_.size(); ++i)
      state_[i] += direction * way * rates_[i] + (i < dof ? 0.5 * way * way * rates_[dof + i] : 0.0);
    if (!state_.allFinite() || !guards_.changed(t, as_span(state_))) return nearest;
    const TimeFormulas other = recorded(t, state_);
    Guards guards = guards_of(other);
    rates_.setZero();
    clear = t;
    for (int times = 0; times < 2; ++times) {
      const auto there = guards.first(Guards::Kind::of_time, clear, end, as_span(state_), as_span(rates_), trials_of_state, clear);
      if (there && there->last != t) return nearer(t, nearest, there->last);
      if (!there) break;
      clear = there->first;
    }
    return nearest;
  }

  // On a new way.
  void set_out(double t, const Eigen::VectorXd& y, double landing) {
    landing_ = landing;
    state_ = y;
    if (bounded_) bounds_.measure(t, landing, {state_.data(), static_cast<std::size_t>(state_.size())});
    if (!is_complete_) resolution_ = std::max(resolution_, spacing_ = std::abs(landing - t) / samples);
  }

  // Bounds the time before us: as far as possible, as long as steps remain as long as is wished.
  void look(double t, const Eigen::VectorXd& y, double landing) {
    const double left = landing - t, least = shortest * std::abs(left);
    rates_.resize(y.size());
    std::fill_n(rates_.data(), rates_.size(), 0.0);
    state_ = y;
    std::copy_n(state_.data() + form_.dof(), form_.dof(), rates_.data());
    double L = std::min(std::abs(left), (bounds_.depends_on_state() ? 2.0 * steps_of_state : ahead) * wish_);
    for (;; L *= 0.5) {
      const bool finite = bounds_.over(t, t + std::copysign(L, left), {state_.data(), static_cast<std::size_t>(state_.size())},
                                       {rates_.data(), static_cast<std::size_t>(rates_.size())});
      step_ = finite ? bounds_.longest_step(options_.rtol) : 0.0;
      if (step_ >= std::min(wish_, L)) break;
      if (L <= least) {
        step_ = L;
        break;
      }
    }
    horizon_ = t + std::copysign(L, left);
    stale_ = steps_of_state;
  }

  // The way along which samples of f at the present state show nothing that its end does not show.
  double sampled(double t, const Eigen::VectorXd& y, double landing) {
    if (std::isinf(wish_) || wish_ <= spacing_) return spacing_;
    state_ = y;
    rates_.resize(y.size());
    changed_.resize(y.size());
    const double direction = landing > t ? 1.0 : -1.0, way = std::min(wish_, std::abs(landing - t));
    int best = 1;
    double largest = 0.0;
    try {
      form_.derivative(t, state_, rates_);
      for (int j = 1; j <= samples && (j - 1) * spacing_ < way; ++j) {
        const double at = std::min(j * spacing_, way);
        form_.derivative(t + direction * at, state_, changed_);
        double most = 0.0;
        for (Eigen::Index i = 0; i < state_.size(); ++i)
          most = std::max(most, std::abs(changed_[i] - rates_[i]) * way / (options_.rtol * std::abs(state_[i]) + options_.atol[i]));
        largest = std::max(largest, most);
        if (largest <= 1.0 + 4.0 * most) best = j;
      }
    } catch (const Error&) {  // the method will find out by itself
    }
    return best * spacing_;
  }

  const WatchedForm& form_;
  const Options& options_;
  bool begun_ = false;
  TimeFormulas formulas_;
  formula::TimeBounds bounds_;
  bool bounded_ = false, is_complete_ = true;  // there are formulas; there is nothing else
  double spacing_ = 0.0, resolution_ = 0.0;    // of samples, and the largest so far
  double t_seen_ = 0.0, reach_ = 0.0, landing_ = 0.0;  // of the last question
  double wish_ = 0.0;                          // the length of step that should be possible
  double step_ = 0.0, horizon_ = 0.0;          // that is possible, as far as this time
  int stale_ = 0;                              // steps until the state is another
  Guards guards_;
  bool has_guards_ = false;
  std::optional<formula::Switch> switch_;      // the next one by time alone
  double scanned_ = 0.0, behind_ = 0.0;        // as far as there is no other; what first_shown() says
  int unfollowed_ = 0, held_ = 0, crowded_ = 0;
  Eigen::VectorXd state_, rates_, changed_;
};

}  // namespace qdot::detail
