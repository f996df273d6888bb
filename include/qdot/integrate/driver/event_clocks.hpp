#pragma once
// SPDX-License-Identifier: MIT
//
// The clocks of events that happen by time, every(name, period): which of them is next, and whether it is now.
//
// The k-th time is first + k·period, not a sum of periods, k = 0, 1, …, on the way from t₀ and before t_end. The loop of the run lands on each.
// Two clocks that tick within some rounding units of each other tick at one moment, that of the earlier one. A clock and a stop time that are
// so close act at the stop time. An output time within as many of a tick has the state behind it. That is the one rule for equal moments:
// same(), eight rounding units of the larger of |t₀| and |t_end|.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/integrate/driver/listed_event.hpp"

namespace qdot::detail {

class EventClocks {
 public:
  // Sets the clocks of a list for a run.
  //
  // @throws InvalidValue  a run backward, or one in which t cannot tell two of the times
  [[gnu::cold]] void set(const std::vector<ListedEvent>& events, double t0, double t_end) {
    clocks_.assign(events.size(), Timetable{0.0, t0});
    t_end_ = due_ = t_end;
    same_ = 8 * std::numeric_limits<double>::epsilon() * std::max(std::abs(t0), std::abs(t_end));
    any_ = false;
    for (std::size_t i = 0; i < events.size(); ++i) {
      if (events[i].times == nullptr) continue;
      const auto [period, first] = *events[i].times;
      if (t_end < t0)
        throw_invalid_value({"an event of a clock needs a run forward, but '", *events[i].name, "' was given to one from t = ", t0,
                             " back to ", t_end, "; leave it out there"});
      if (!(period > 100 * same_))
        throw_invalid_value({"the period of event '", *events[i].name, "' must be longer than what t can tell on the way to ", t_end, ", but is ", period,
                             "; lengthen it, or begin nearer to t = 0"});
      clocks_[i] = {period, std::isnan(first) ? t0 : first};
      any_ = true;
    }
  }
  bool any() const { return any_; }

  // The next time after t, or at t if `included`, on the way to `landing`; t_end where there is none before it. It is due from then on.
  double next(double t, bool included, double landing) {
    due_ = t_end_;
    for (const Timetable& clock : clocks_) {
      if (clock.period == 0.0) continue;
      double k = std::max(0.0, std::floor((t - clock.first) / clock.period));
      while (clock.first + k * clock.period < t - same_ || (!included && clock.first + k * clock.period <= t + same_)) ++k;
      const double next = clock.first + k * clock.period;
      if (next < due_ && t_end_ - next > close_to_end * clock.period) due_ = next;
    }
    for (const double moment : {t, landing})
      if (due_ != t_end_ && std::abs(due_ - moment) <= same_) due_ = moment;
    return due_;
  }
  double due() const { return due_; }
  // Within which times are one moment, if t is one at which a clock ticks; otherwise 0.
  double same(double t) const { return any_ && t == due_ && t != t_end_ ? same_ : 0.0; }

  // Whether event i happens at the time that is due.
  bool is_due(std::size_t i) const {
    if (due_ == t_end_ || clocks_[i].period == 0.0) return false;
    const double k = std::round((due_ - clocks_[i].first) / clocks_[i].period);
    return k >= 0.0 && std::abs(clocks_[i].first + k * clocks_[i].period - due_) <= same_;
  }

  // All that happens at the time that is due, which is marked.
  Firing firing(const std::vector<ListedEvent>& events, double elapsed, std::vector<bool>& fired) const {
    Firing firing{.elapsed = elapsed, .t = due_};
    for (std::size_t i = 0; i < events.size(); ++i) {
      fired[i] = is_due(i);
      firing.stops = firing.stops || (fired[i] && events[i].stops);
      firing.changes = firing.changes || (fired[i] && events[i].change != nullptr);
    }
    return firing;
  }

 private:
  static constexpr double close_to_end = 1e-6;  // of a period: as good as t_end
  std::vector<Timetable> clocks_;               // period 0: no clock
  double t_end_ = 0.0, due_ = 0.0, same_ = 0.0;
  bool any_ = false;
};

template <class Number = double>
void set_clocks(EventClocks& clocks, const std::vector<ListedEvent>& events, double t0, double t_end) {
  clocks.set(events, t0, t_end);
}

#ifdef QDOT_COMPILED
extern template void set_clocks<double>(EventClocks&, const std::vector<ListedEvent>&, double, double);
#endif

}  // namespace qdot::detail
