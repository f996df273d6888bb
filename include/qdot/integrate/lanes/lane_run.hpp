#pragma once
// SPDX-License-Identifier: MIT
//
// Motions that go in the lanes of a pack, from their starts to their ends.
//
// LaneRun fills the lanes, lets them step (integrate/lanes/runge_kutta_lanes.hpp), and takes out what has arrived or needs a closer look; that goes on
// alone, by simulate().

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/integrate/driver/motion_scale.hpp"
#include "qdot/integrate/lanes/lane_models.hpp"
#include "qdot/integrate/lanes/runge_kutta_lanes.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/ensemble.hpp"
#include "qdot/integrate/watch/any_watch.hpp"

namespace qdot {

template <int n>
struct MotionEnd;

namespace detail {

// A motion by simulate().
template <class Sys, int n, class Method, class... Events>
MotionEnd<n> motion_alone(const Sys& system, const State<n>& start, double t_end, const Method& method, const Options& options,
                          const EventList<Events...>& events) {
  auto run = simulate(system, start, t_end, method, options, NoObserver{}, events);
  const Eigen::Index dof = start.q.size();
  MotionEnd<n> end{{run.t, run.y.head(dof), run.y.segment(dof, dof)}, run.outcome, {}, {}, run.statistics.steps, run.statistics.evaluations};
  if (!run.completed()) end.message = std::move(run.message);
  if (run.outcome == Outcome::stopped_by_event && !run.events.empty()) end.event = run.events.back().name;
  return end;
}

// Motions first … last − 1 of what goes in lanes.
template <class Systems, class StartOf, class P, class... Events>
class LaneRun {
  using Form = std::remove_cvref_t<decltype(first_order_form(std::declval<const typename Systems::System&>()))>;
  static constexpr int n = Systems::n, lanes = P::size;
  static constexpr bool timed = TimeOf<Form>::enters;
  using Mask = typename P::Mask;
  using Ends = std::vector<Kept<MotionEnd<n>>>;

 public:
  LaneRun(const Systems& systems, const RecordedMotion& recorded, const DerivedLines& lines, const StartOf& start_of, double t_end, const Options& options,
          const EventList<Events...>& events)
      : systems_(systems), recorded_(recorded), start_of_(start_of), t_end_(t_end), options_(options), events_(events),
        numbers_(lane_numbers(lines)), equations_(lines, numbers_.data()), pack_(options) {}

  Ends run(std::size_t first, std::size_t last) {
    first_ = next_ = first;
    last_ = last;
    Ends ends(last - first);
    ends_ = &ends;
    for (int lane = 0; lane < lanes; ++lane) load(lane);
    const auto accelerations = [&](const P* q, const P* qdot, const P& t, P* qddot) { return equations_(q, qdot, t, qddot); };
    while (moving_ > 0) {
      Mask told;
      try {
        told = pack_.step(accelerations, [&] { return passing(); });
      } catch (...) {  // by an event for some lane, which will do so again alone
        told = pack_.abandoned();
      }
      for (int lane = 0; lane < lanes; ++lane) {
        if (told[lane] || (pack_.is_active(lane) && is_over_budget(lane))) finish(lane);
        else if (timed && pack_.took(lane) && !look_ahead(lane)) finish(lane);
        if (pack_.is_active(lane) && lanes_[lane].scale.grows() && lanes_[lane].scale.has_outgrown(state_of(lane)))
          pack_.tolerate(lane, lanes_[lane].scale.tolerances());
      }
    }
    return ends;
  }

 private:
  struct Lane {
    std::size_t motion = 0;
    State<n> start;
    std::optional<Form> form;
    std::unique_ptr<AnyWatch> dog;
    MotionScale scale;
    bool has_begun = false;  // one of this form
  };

  Kept<MotionEnd<n>>& kept(std::size_t motion) { return (*ends_)[motion - first_]; }

  // Lanes that pass an event with the step that was just made.
  Mask passing() const {
    if constexpr (sizeof...(Events) == 0) {
      return false;
    } else {
      const auto step = pack_.places();
      try {
        return lanes_that_pass(step, events_);
      } catch (const LanesPart&) {
        Mask passed = false;
        for (int lane = 0; lane < lanes; ++lane)
          if (pack_.is_active(lane)) set_lane(passed, lane, lanes_that_pass(step.of_lane(lane), events_)[lane]);
        return passed;
      }
    }
  }

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
      if (!Systems::is_common || !l.form) {
        l.dog.reset();
        l.has_begun = false;
        l.form.emplace(systems_.to_begin(motion));
      }
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
      if (!l.dog) l.dog = watch_of(*l.form, options_);
      Eigen::VectorXd y(2 * n), f(2 * n);
      y << l.start.q, l.start.qdot;
      const double t = l.start.t;
      l.form->derivative(t, y, f);
      if (!compares_) compares_ = l.dog->may_pass_branches(t, y);
      if (*compares_) return false;  // one by one its steps are looked at (integrate/watch/branch_watch.hpp)
      l.dog->begin(t, y, 0, std::exchange(l.has_begun, true));
      if (!f.allFinite() || l.dog->look_at_values_and_mass(t, y)) return false;
      if (options_.atol.is_default() && t != t_end_) {
        const bool has_own = l.scale.take(driven_form(*l.form), options_, t, y, t_end_);
        if (!l.scale.is_known()) return false;
        pack_.tolerate(lane, has_own ? l.scale.tolerances() : Eigen::VectorXd::Constant(2 * n, options_.atol[0]));
      }
      const double limit = l.dog->reach(t, y, t_end_, false);
      if (l.dog->switches_by_time()) return false;
      pack_.load(lane, *l.form, t, t_end_ - t, limit, y, f);
      systems_.take(lane, l.motion, equations_);
      return true;
    } catch (...) {
      return false;
    }
  }

  // How far the next step may go; false where the motion has come to a branch by time.
  bool look_ahead(int lane) {
    pack_.head_for(lane, lanes_[lane].dog->reach(pack_.t(lane), state_of(lane), t_end_, false));
    return !lanes_[lane].dog->switches_by_time();
  }

  bool is_ordinary(const State<n>& s) const { return std::isfinite(s.t) && s.q.allFinite() && s.qdot.allFinite() && s.t != t_end_; }

  bool is_over_budget(int lane) const {
    return pack_.steps(lane) >= options_.max_steps || pack_.evaluations(lane) >= options_.max_evaluations;
  }

  Eigen::VectorXd state_of(int lane) const {
    Eigen::VectorXd y(2 * n);
    for (int i = 0; i < 2 * n; ++i) y[i] = pack_.y(i, lane);
    return y;
  }

  // Takes what a lane came to, and gives it the next motion.
  void finish(int lane) {
    Lane& l = lanes_[lane];
    --moving_;
    try {
      const Eigen::VectorXd y = state_of(lane);
      const State<n> state{pack_.has_arrived(lane) ? t_end_ : pack_.t(lane), y.head(n), y.tail(n)};
      const long steps = pack_.steps(lane), evaluations = pack_.evaluations(lane);
      if (pack_.has_arrived(lane)) {
        if (l.dog->look(t_end_, y, steps, true) || l.dog->verdict() || !are_as_recorded()) {
          kept(l.motion).value = alone(l, l.start, options_);
        } else {
          kept(l.motion).value = MotionEnd<n>{state, Outcome::completed, {}, {}, steps, evaluations};
        }
      } else if (sizeof...(Events) > 0 && pack_.was_seen(lane) && are_as_recorded()) {
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

  // Whether functors still are what the lines were derived from.
  bool are_as_recorded() const {
    try {
      return are_alike(recorded_, systems_.recorded());
    } catch (...) {  // what functors throw they throw again alone
      return false;
    }
  }

  MotionEnd<n> alone(const Lane& l, const State<n>& start, const Options& options) const {
    return motion_alone(systems_.of(l.motion), start, t_end_, Dop853{}, options, events_);
  }

  const Systems& systems_;
  const RecordedMotion& recorded_;
  const StartOf& start_of_;
  double t_end_;
  const Options& options_;
  const EventList<Events...>& events_;
  std::vector<formula::LaneNumber> numbers_;
  LaneEquations<n, P> equations_;
  RungeKuttaLanes<Dop853Coefficients, n, P, timed> pack_;
  std::size_t first_ = 0, next_ = 0, last_ = 0;
  int moving_ = 0;
  std::optional<bool> compares_{};
  Ends* ends_ = nullptr;
  Lane lanes_[lanes];
};

}  // namespace detail
}  // namespace qdot
