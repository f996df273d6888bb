#pragma once
// SPDX-License-Identifier: MIT
//
// A point of time in two numbers, for one does not do.
//
// A double near t = 1.7e9 (a Unix time) has a resolution of 2.4e-7, one near 1e12 of 1.2e-4. A motion may need steps of 1e-9 there,
// and each would lose these digits. So a run counts from where it started, or from its last stop time,
//
//     t = origin + elapsed ,
//
// and steps, floors, polynomials, roots of events and the way to the next landing are all in `elapsed`. With origin = 0 nothing differs
// from counting in t. A functor gets a double: origin + elapsed, rounded. A model with an explicit t, such as sin(ω t), knows its time
// to that resolution, whatever the method; a model that counts from its own beginning keeps its digits.
//
// The ends of the interval may be stop times, at which a model may switch, and f must be evaluated on the side of the motion. So after
// a stop time the first time that functors get is `first`, a rounding unit behind the origin, and the last is a rounding unit in front
// of the limit. The motion loses nothing by this.

#include <algorithm>
#include <cmath>
#include <limits>

namespace qdot {

/// A time as `elapsed` since `origin`; a plain t is its own origin.
struct TimePoint {
  double origin = 0.0;   ///< a time
  double elapsed = 0.0;  ///< since then
  double first = 0.0;    ///< what functors are shown for `origin`: itself, or its neighbour behind a switch

  TimePoint(double t = 0.0) : origin(t), first(t) {}
  TimePoint(double from, double since, double shown_first) : origin(from), elapsed(since), first(shown_first) {}

  /// The double nearest to it.
  double t() const noexcept { return origin + elapsed; }
};

using Moment [[deprecated("qdot: say TimePoint")]] = TimePoint;  ///< the old name, accepted until 0.4

namespace detail {

/// Times on the way from an origin to a limit, by what has elapsed.
class Clock {
 public:
  void start(const TimePoint& from) noexcept {
    origin_ = from.origin;
    first_ = from.first;
    limit_ = last_ = length_ = std::numeric_limits<double>::quiet_NaN();  // not known before head_for()
  }

  void head_for(double t_limit) noexcept {
    if (t_limit == limit_) return;
    limit_ = t_limit;
    length_ = t_limit - origin_;
    last_ = std::nextafter(t_limit, origin_);
  }

  double origin() const noexcept { return origin_; }
  double length() const noexcept { return length_; }  ///< what has elapsed at the limit
  TimePoint time_point(double elapsed) const noexcept { return {origin_, elapsed, first_}; }

  /// t for the reader: the limit only where it has been reached.
  double t(double elapsed) const noexcept {
    const double t = origin_ + elapsed;
    return elapsed == length_ ? limit_ : t == limit_ ? last_ : t;
  }

  /// t for functions of events: not in front of what functors are shown first.
  double seen(double elapsed) const noexcept { return elapsed < 0 ? std::min(t(elapsed), first_) : std::max(t(elapsed), first_); }

  /// t for functors: on this side of a switch at either end, as far as rounding reaches. A method that looks farther, as compositions with
  /// substeps backward do, sees what is there.
  double shown(double elapsed) const noexcept {
    const double t = origin_ + elapsed, sign = length_ < 0 ? -1.0 : 1.0;
    const double unit = std::numeric_limits<double>::epsilon() * std::max(std::abs(origin_), std::abs(t));
    if (t == origin_ || ((t - first_) * sign < 0.0 && (t - origin_) * sign >= -unit)) return first_;
    if ((t - last_) * sign > 0.0 && (t - limit_) * sign <= unit) return last_;
    return t;
  }

  /// Whether what has elapsed cannot be told from a time.
  bool is_at(double t, double elapsed) const noexcept { return t - origin_ == elapsed; }

  /// What rounding has carried over the limit is taken back to it.
  double within(double elapsed) const noexcept { return length_ > 0 ? std::min(elapsed, length_) : std::max(elapsed, length_); }

  /// The smallest |h| worth a try: 16 rounding units of what has elapsed, or of t where the way left is longer than t itself. A model
  /// without a solution is left there, be it at the very start.
  double least_step(double elapsed) const noexcept {
    return 16 * std::numeric_limits<double>::epsilon() *
           std::max(std::abs(elapsed), std::min(std::abs(origin_ + elapsed), std::abs(length_ - elapsed)));
  }

  /// A step that ends about here ends on a double t, if that makes no difference to it.
  double rounded(double elapsed, double h) const noexcept {
    const double on_the_clock = (origin_ + elapsed) - origin_;
    return std::abs(on_the_clock - elapsed) <= 1e-3 * std::abs(h) ? on_the_clock : elapsed;
  }

 private:
  double origin_ = 0.0, first_ = 0.0, limit_ = 0.0, last_ = 0.0, length_ = 0.0;
};

template <class S>
concept HasTimePoint = requires(const S& stepper) { stepper.time_point(); };
// A stepper of a user that has time_point() by its old name.
template <class S>
concept HasMoment = !HasTimePoint<S> && requires(const S& stepper) { stepper.moment(); };

// Where a stepper is; one that counts in t alone has the origin 0.
template <class S>
TimePoint time_point_of(const S& stepper) {
  if constexpr (HasTimePoint<S>) {
    return stepper.time_point();
  } else if constexpr (HasMoment<S>) {
    return stepper.moment();
  } else {
    return {0.0, stepper.t(), 0.0};
  }
}

// Starts a stepper afresh, as exactly as it can count.
template <class S, class Y>
void reset_at(S& stepper, const TimePoint& at, const Y& y) {
  if constexpr (HasTimePoint<S> || HasMoment<S>) {
    stepper.reset(at, y);
  } else {
    stepper.reset(at.elapsed == 0.0 ? at.first : at.t(), y);
  }
}

}  // namespace detail
}  // namespace qdot
