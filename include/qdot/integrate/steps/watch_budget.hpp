#pragma once
// SPDX-License-Identifier: MIT
//
// The budget of a run: no run goes on for ever.
//
//     max_steps             10⁷ unless another number is given: the guard that holds by default
//     stall                 10⁴ steps that advance t by less than 1e-8 of the way done or to do end the run (integrate/driver/run_limits.hpp)
//     max_evaluations       asked for after each attempt at a step
//     max_wall_seconds      the same
//
// Between two of these questions lies a bounded number of evaluations. A step of an explicit method makes no more than 200
// attempts and asks after each; CVODE asks at every right-hand side. Gauss' stages, projections onto constraints and searches for
// events have iteration limits of their own (100, 25, and 200 for each root). No function may fire more than 10⁴ times in one
// step. What no library can end is a model's function that does not return.
//
// A budget that is spent inside a step leaves the state of the last good one. The clock is read only where a time was given.

#include <cmath>

#include "qdot/integrate/options.hpp"
#include "qdot/integrate/outcome.hpp"

namespace qdot::detail {

/// Seconds of a clock that is never set.
template <class = void>
double seconds_of_steady_clock();

/// Evaluations and seconds that a run may take, from the moment this is made.
class Budget {
 public:
  explicit Budget(const Options& options)
      : evaluations_(options.max_evaluations), seconds_(options.max_wall_seconds), timed_(std::isfinite(options.max_wall_seconds)) {}

  double seconds() const { return seconds_of_steady_clock() - began_; }

  /// True when nothing may be evaluated any more.
  bool is_spent(long evaluations) const { return evaluations >= evaluations_ || (timed_ && seconds() >= seconds_); }

  /// What is spent, in words; only where is_spent().
  Failure failure(long evaluations) const {
    if (evaluations >= evaluations_)
      return {Outcome::evaluation_limit, sentence({"max_evaluations = ", evaluations_, " were spent"})};
    return {Outcome::time_limit, sentence({"max_wall_seconds = ", seconds_, " were spent"})};
  }

 private:
  long evaluations_;
  double seconds_;
  bool timed_;
  double began_ = seconds_of_steady_clock();
};

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template double seconds_of_steady_clock<void>();
}  // namespace qdot::detail
#else
#include "qdot/integrate/steps/watch_budget.ipp"
#endif
