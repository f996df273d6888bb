#pragma once
// SPDX-License-Identifier: MIT
//
// The watch over a run's events. All functions whose zeros matter, the user's and those of the system's own phases (contact,
// sticking, a taut rope), are in one list, with one search for all.
//
// The driver asks after each step for the moment of the next event. What happens at that moment is one firing:
// everything whose root lies there to rounding. If it only records, the search goes on behind it in the same step. If something
// changes the state, the rest of the step is thrown away and the watch begins afresh.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/integrate/driver/event_clocks.hpp"
#include "qdot/integrate/driver/event_finder.hpp"
#include "qdot/integrate/driver/event_proof.hpp"
#include "qdot/integrate/driver/listed_event.hpp"
#include "qdot/integrate/event.hpp"
#include "qdot/integrate/time_point.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/integrate/statistics.hpp"
#include "qdot/integrate/steps/polynomial.hpp"

namespace qdot::detail {

// Of runs that have neither events nor switches.
struct NothingToWatch {
  NothingToWatch(const auto&, const std::vector<ListedEvent>&) {}
  static double same(double) { return 0.0; }
};

// One for all systems and all lists of events; a template, and so compiled where there is something to watch. Form is DrivenForm.
template <class Form>
class EventWatch {
  static constexpr std::size_t points = samples_in_panel;

 public:
  EventWatch(const Form& system, std::vector<ListedEvent> events) : system_(system), events_(std::move(events)), listed_(events_.size()) {
    const Eigen::Index guards = system.guard_count();
    const std::size_t count = listed_ + static_cast<std::size_t>(guards);
    has_others_ = guards > 0;
    watches_.resize(count);
    fired_ = std::vector<bool>(count);
    fired_guards_ = std::vector<bool>(static_cast<std::size_t>(guards));
    last_time_.assign(count, std::numeric_limits<double>::quiet_NaN());
    standing_.assign(count, 0);
    samples_.assign(count * points, 0.0);
    guards_.resize(guards);
    bands_.resize(guards);
    y_.resize(system.size()), there_.resize(system.size());
    before_.assign(listed_, 0.0);
    for (std::size_t i = 0; i < listed_; ++i) {
      watches_[i].direction = events_[i].is_barrier ? Direction::falling : events_[i].direction;
      watches_[i].barrier = events_[i].is_barrier;
      watches_[i].is_formula = events_[i].decide != nullptr;
      watches_[i].judges = !events_[i].is_barrier && !events_[i].stops && events_[i].change == nullptr;
      watches_[i].is_kept = watches_[i].judges && system.is_constrained();
      if (events_[i].times == nullptr) (watches_[i].is_formula ? has_formulas_ : has_others_) = true;
    }
    for (std::size_t i = listed_; i < count; ++i) {
      watches_[i].direction = Direction::falling;
      watches_[i].barrier = true;
    }
  }

  // Whether there is anything to look for within a step; a system whose type is hidden may have nothing that switches.
  bool looks_at_steps() const { return !watches_.empty(); }

  EventClocks& clocks() { return clocks_; }
  double same(double t) const { return clocks_.same(t); }
  void set_clocks(double t0, double t_end) { detail::set_clocks(clocks_, events_, t0, t_end); }

  Firing firing_of_clocks(double elapsed) { return clocks_.firing(events_, elapsed, fired_); }

  void forget_firing() { fired_.assign(fired_.size(), false); }
  // Begins at a state: the start of the run, or the one after a firing that changed it.
  void begin(double t, const Eigen::VectorXd& y, const Eigen::VectorXd& tolerance, bool at_start, std::size_t first = 0) {
    system_.guard_bands(t, y, tolerance, bands_);
    tolerance_ = tolerance;
    for (std::size_t i = first; i < watches_.size(); ++i) {
      const double g = value(i, t, y);
      const double band = i >= listed_ ? bands_[static_cast<Eigen::Index>(i - listed_)] : rounding_of(i, t, y, g);
      watches_[i].noise = watches_[i].judges ? noise_of(i, t, y) : 0.0;
      watches_[i].begin(g, band, fired_[i], at_start ? g : watches_[i].value, at_start);
      watches_[i].rounding = band;
      if (i < listed_ && !at_start && fired_[i] && watches_[i].side == 0) watches_[i].home = home_side(watches_[i].came_from, trends_[i], trend(i, t, y));
    }
  }

  // Forgets all that was, but for the listed events that stopped the run here, whose bits are set: they have to leave zero first.
  void forget(std::uint64_t stopped) {
    for (std::size_t i = 0; i < watches_.size(); ++i) {
      fired_[i] = i < listed_ && i < 64 && (stopped >> i & 1u) != 0;
      watches_[i].level = 0.0;
      last_time_[i] = std::numeric_limits<double>::quiet_NaN();
      standing_[i] = 0;
    }
    for (std::size_t i = 0; i < fired_guards_.size(); ++i) fired_guards_[i] = false;
  }
  std::uint64_t fired() const {
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < listed_ && i < 64; ++i) bits |= std::uint64_t{fired_[i]} << i;
    return bits;
  }

  // Before the call of the observer, which may change what a listed function reads.
  void remember(double t, const Eigen::VectorXd& y) {
    for (std::size_t i = 0; i < listed_; ++i) before_[i] = value(i, t, y);
  }

  // Behind the observer: a function with another value begins from it, on the side where it is now. It has moved, and not crossed zero.
  std::optional<Failure> begin_changed(double t, const Eigen::VectorXd& y) {
    std::optional<Failure> failure;
    for (std::size_t i = 0; i < listed_; ++i) {
      const double g = value(i, t, y);
      if (std::abs(g - before_[i]) <= watches_[i].rounding) continue;
      failure = Failure{Outcome::model_changed,
                        sentence({"between events and stop times functions of events must depend on nothing but their arguments, but that of ",
                                  name_of(i), " at t = ", t, " was ", before_[i], " before the observer saw the step and is ", g, " behind it"})};
      const double rounding = rounding_of(i, t, y, g);
      watches_[i].begin(g, rounding, false, before_[i], false);
      watches_[i].rounding = rounding;
    }
    return failure;
  }

  // Samples a step and notes each function's first root in it; from and to are what has elapsed on the clock, and so are roots.
  void search(const Clock& clock, const PolynomialView& step, double from, double to, const Eigen::VectorXd& tolerance) {
    tolerance_ = tolerance_.cwiseMax(tolerance);  // errors do not fall where a velocity passes zero
    if (clock.origin() != clock_.origin()) last_time_.assign(watches_.size(), std::numeric_limits<double>::quiet_NaN());
    clock_ = clock;
    step_ = step;
    length_ = std::abs(to - from);
    to_ = to;
    backward_ = to < from;
    if (has_formulas_) bounds_.begin(clock_, step_, system_.dof(), from, to);
    for (std::size_t k = 1; has_others_ && k < points; ++k) {
      const double elapsed = k + 1 == points ? to : from + sample_points[k] * (to - from);
      step_.at(elapsed, y_);
      evaluate_all(clock_.seen(elapsed), y_, samples_.data() + k, points, false);
    }
    for (std::size_t i = 0; i < watches_.size(); ++i) {
      watches_[i].panels = 0;
      watches_[i].rough = watches_[i].unproven = false;
      if (i < listed_ && events_[i].times != nullptr) {
        if (clock_.t(to) == clocks_.due() && clocks_.is_due(i)) watches_[i].root = to;
        continue;
      }
      search_one(i, from, watches_[i].is_formula ? nullptr : samples_.data() + i * points);
    }
  }

  // Adds the steps in which a function could not be followed.
  void report(Statistics& statistics) const { statistics.unresolved_events = rough_steps_; statistics.unresolved_event_time = rough_time_; }

  // What happens next in the step, if anything; its functions are marked as fired.
  std::optional<Firing> next() {
    std::optional<Firing> firing;
    for (std::size_t i = 0; i < watches_.size(); ++i)
      if (watches_[i].root && (!firing || std::abs(to_ - *watches_[i].root) > std::abs(to_ - firing->elapsed)))
        firing = Firing{.elapsed = *watches_[i].root, .t = clock_.t(*watches_[i].root), .first = i};
    if (!firing) return firing;
    const double same = 4 * std::numeric_limits<double>::epsilon() * (std::abs(firing->elapsed) + length_);
    for (std::size_t i = 0; i < watches_.size(); ++i)
      fired_[i] = watches_[i].root && std::abs(*watches_[i].root - firing->elapsed) <= same;
    for (std::size_t i = listed_; i < watches_.size(); ++i) {
      fired_guards_[i - listed_] = fired_[i];
      firing->changes = firing->changes || fired_[i];
      firing->stops = firing->stops || (fired_[i] && !ending(i).empty());
    }
    for (std::size_t i = 0; i < listed_; ++i) {
      if (!fired_[i]) continue;
      firing->stops = firing->stops || events_[i].stops;
      firing->changes = firing->changes || events_[i].change != nullptr;
    }
    return firing;
  }

  // Records the listed events of a firing, and guards at which the run ends.
  void record(const Firing& firing, std::vector<RecordedEvent>& events) const {
    for (std::size_t i = 0; i < listed_; ++i)
      if (fired_[i] && !watches_[i].lost) events.push_back({firing.t, *events_[i].name});
    for (std::size_t i = listed_; i < watches_.size(); ++i)
      if (fired_[i] && !ending(i).empty()) events.push_back({firing.t, ending(i)});
  }

  // Goes on behind a firing that changed nothing; at the end of the step, where there have been too many in it.
  void pass(const Firing& firing, bool too_many) {
    for (std::size_t i = 0; i < watches_.size(); ++i) {
      if (!fired_[i]) continue;
      const double root = too_many ? to_ : *watches_[i].root;
      step_.at(root, y_);
      watches_[i].pass(value(i, clock_.seen(root), y_));
      if (too_many && ++rough_steps_ == 1) rough_time_ = firing.t;
      if (root != to_ && firing.elapsed != to_) search_one(i, root, nullptr);
    }
  }

  // Changes y as the fired events ask, and lets the system choose its phases; what an action did wrong, if one did.
  std::optional<Failure> change(const Firing& firing, Eigen::VectorXd& y, const Eigen::VectorXd& tolerance, std::vector<RecordedEvent>& events) {
    values_.resize(watches_.size());
    evaluate_all(firing.t, y, values_.data(), 1, true);
    for (std::size_t i = 0; i < watches_.size(); ++i) watches_[i].value = values_[i];
    for (std::size_t i = listed_; backward_ && i < watches_.size(); ++i)
      if (fired_[i]) require_same_motion(system_, firing.t, y, fired_guards_, tolerance);
    for (std::size_t i = 0; i < listed_; ++i)
      if (fired_[i] && watches_[i].lost)
        return Failure{Outcome::zeno, sentence({"the time between two events of ", name_of(i), " is shorter than t can tell"})};
    const Eigen::VectorXd y_before = y;
    std::optional<Failure> failure;
    bool acted = false;
    trends_.assign(watches_.size(), std::nullopt);
    for (std::size_t i = 0; i < listed_; ++i) {
      if (!fired_[i] || events_[i].change == nullptr) continue;
      acted = true;
      y_before_action_ = y;
      failure = events_[i].change(events_[i].event, firing.t, y, system_.dof());
      if (!failure) failure = what_is_not_finite(system_, *events_[i].name, firing.t, y);
      if (failure) return failure;
      if (!same_bits(y, y_before_action_)) trends_[i] = trend(i, firing.t, y_before);
    }
    // Constraints answer a blow with one of their own: what they forbid of the change is taken back. Where some switch, settle() asks the lasting ones.
    if (acted && fired_guards_.empty()) system_.project(firing.t, y);
    settle(firing.t, y, tolerance, events);
    return std::nullopt;
  }

  // Lets the system choose its phases for y as they follow from the guards that fired; none at the start, and behind a stop time.
  void settle(double t, Eigen::VectorXd& y, const Eigen::VectorXd& tolerance, std::vector<RecordedEvent>& events) {
    if (!fired_guards_.empty())
      for (std::string& what : system_.switched(t, y, fired_guards_, tolerance)) events.push_back({t, std::move(what)});
  }
  bool settle_behind_jump(double t, bool backward, Eigen::VectorXd& y, const Eigen::VectorXd& tolerance, std::vector<RecordedEvent>& events) {
    const std::size_t before = events.size();
    fired_guards_.assign(fired_guards_.size(), false);
    settle(t, y_ = y, tolerance, events);
    const bool is_named = events.size() > before;
    if (!is_named && !is_same_motion(y, y_, 2 * system_.dof(), tolerance)) return false;
    if (is_named && backward) events.resize(before), refuse_backward(t);
    fired_.assign(fired_.size(), false);
    return begin(t, y = y_, tolerance, true, listed_), true;
  }

  // The function whose changes of the state stop the progress of t, if there is one. Each change follows the one before it as
  // closely as the clock can tell, or g cannot be told from zero between them.
  std::optional<std::string> accumulating(double elapsed) {
    const double indistinct = 1e3 * std::numeric_limits<double>::epsilon() * std::abs(elapsed);
    for (std::size_t i = 0; i < watches_.size(); ++i) {
      if (!fired_[i]) continue;
      const double since = std::abs(elapsed - std::exchange(last_time_[i], elapsed));
      standing_[i] = since <= indistinct || watches_[i].stuck ? standing_[i] + 1 : 0;
      if (standing_[i] >= (i < listed_ ? 4 : 20)) return name_of(i);  // a system may pass through several phases at once
    }
    return std::nullopt;
  }

 private:
  std::string ending(std::size_t i) const {
    return system_.ending(static_cast<Eigen::Index>(i - listed_));
  }

  std::string name_of(std::size_t i) const { return i < listed_ ? sentence({"'", *events_[i].name, "'"}) : sentence({"a contact or friction"}); }

  void require_finite(std::size_t i, double t, double g) const {
    if (std::isfinite(g)) return;
    throw NonFinite(name_of(i), t, sentence({"the function of event ", name_of(i), " must be finite, but is ", g, " at t = ", t}));
  }

  // The value of function i goes to values[i stride]; those that intervals follow only if asked for.
  void evaluate_all(double t, const Eigen::VectorXd& y, double* values, std::size_t stride, bool with_formulas) {
    for (std::size_t i = 0; i < listed_; ++i)
      if (with_formulas || !watches_[i].is_formula) values[i * stride] = value(i, t, y);
    if (listed_ == watches_.size()) return;
    system_.guards(t, y, guards_);
    for (std::size_t i = listed_; i < watches_.size(); ++i) {
      const double g = guards_[static_cast<Eigen::Index>(i - listed_)];
      require_finite(i, t, g);
      values[i * stride] = g;
    }
  }

  double value(std::size_t i, double t, const Eigen::VectorXd& y) {
    double g = 0.0;
    if (i < listed_) {
      g = events_[i].value(events_[i].event, t, y, system_.dof());
    } else {
      system_.guards(t, y, guards_);
      g = guards_[static_cast<Eigen::Index>(i - listed_)];
    }
    require_finite(i, t, g);
    return g;
  }

  // The sign of dg/dt along the equations of motion, 0 where rounding hides it; nothing where the model refuses.
  std::optional<int> trend(std::size_t i, double t, const Eigen::VectorXd& y) {
    try {
      Eigen::VectorXd ydot(y.size());
      system_.derivative(t, y, ydot);
      const double speed = ydot.lpNorm<Eigen::Infinity>(), size = y.lpNorm<Eigen::Infinity>();
      // As far as t can tell, and then some: what hides in the rounding of a large t is not what stands still.
      const double distant = std::max(1e-5 * (speed > 0.0 && size > 0.0 ? size / speed : 1.0), 16 * std::numeric_limits<double>::epsilon() * std::abs(t));
      const double d = backward_ ? -distant : distant;
      Eigen::VectorXd ahead(y.size()), behind(y.size());
      for (Eigen::Index k = 0; k < y.size(); ++k) {
        ahead[k] = y[k] + d * ydot[k];
        behind[k] = y[k] - d * ydot[k];
      }
      const double change = value(i, t + d, ahead) - value(i, t - d, behind), noise = 4 * rounding_of(i, t, y, value(i, t, y));
      return std::abs(change) <= noise ? 0 : change > 0.0 ? 1 : -1;
    } catch (...) {
      return std::nullopt;
    }
  }

  // Σ |δg| where component k of y goes to moved(k).
  template <class Moved>
  double change_of(std::size_t i, double t, const Eigen::VectorXd& y, double g, const Moved& moved) {
    double sum = 0.0;
    moved_ = y;
    for (Eigen::Index k = 0; k < y.size(); ++k) {
      moved_[k] = moved(k);
      sum += std::abs(value(i, t, moved_) - g);
      moved_[k] = y[k];
    }
    return sum;
  }

  // What rounding of t and y does to g.
  double rounding_of(std::size_t i, double t, const Eigen::VectorXd& y, double g) {
    constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();
    return std::abs(value(i, t * (1.0 + 0.25 * rounding), y) - g) + change_of(i, t, y, g, [&](Eigen::Index k) { return y[k] * (1.0 + rounding); });
  }

  // What the method's tolerance leaves open of g, of which constraints hold some between steps only. Nothing where g has no value so near.
  double noise_of(std::size_t i, double t, const Eigen::VectorXd& y) {
    try {
      return change_of(i, t, y, value(i, t, y), [&](Eigen::Index k) { return y[k] + (system_.is_constrained() ? 100.0 : 1.0) * tolerance_[k]; });
    } catch (const Error&) {
      return 0.0;
    }
  }

  void search_one(std::size_t i, double from, const double* known) {
    const auto at = [this, i](double elapsed) {
      step_.at(elapsed, y_);
      return value(i, clock_.seen(elapsed), y_);
    };
    const auto proves = [this, i](double a, double b) { return decided(i, a, b); };
    const auto noise = [this, i](double elapsed) {
      step_.at(elapsed, there_);
      return noise_of(i, clock_.seen(elapsed), there_);
    };
    RootSearch search(watches_[i], at, proves, noise, std::numeric_limits<double>::epsilon() * std::abs(clock_.t(from)));
    const bool was_rough = watches_[i].rough || watches_[i].unproven;
    search_root<double>(search, from, to_, known);
    if ((watches_[i].rough || watches_[i].unproven) && !was_rough && ++rough_steps_ == 1) rough_time_ = clock_.t(from);
  }

  // Whether intervals prove that the ends of a panel tell all about a formula's zeros in it.
  bool decided(std::size_t i, double a, double b) {
    try {
      return events_[i].decide(events_[i].event, bounds_, watches_[i].level, a, b);
    } catch (const Undecided&) {  // in a shorter panel the comparison may have an answer
    } catch (...) {               // no formula here: if g has no value, samples show it
      watches_[i].unproven = true;
    }
    return false;
  }

  const Form& system_;
  std::vector<ListedEvent> events_;
  std::size_t listed_;  // so many
  bool has_formulas_ = false, has_others_ = false, backward_ = false;
  std::vector<Watch> watches_;  // the listed events, then the system's guards
  std::vector<bool> fired_, fired_guards_;
  std::vector<double> before_, last_time_;  // values before the observer; elapsed, when a function last changed the state
  std::vector<std::optional<int>> trends_;  // of fired functions, before their actions
  std::vector<int> standing_;             // how often a function has changed the state without letting t go on
  std::vector<double> samples_, values_;  // of the present step, and of one moment
  Eigen::VectorXd guards_, bands_, tolerance_, moved_, there_, y_, y_before_action_;
  Clock clock_;
  PolynomialView step_;
  StepBounds bounds_;
  double to_ = 0.0, length_ = 0.0, rough_time_ = 0.0;
  EventClocks clocks_;
  long rough_steps_ = 0;
};

}  // namespace qdot::detail
