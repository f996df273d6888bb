#pragma once
// SPDX-License-Identifier: MIT
//
// What ends a run that would go on: its budgets of steps, evaluations and seconds, and steps that no longer bring it on.
//
// A method that chatters about a jump of the right-hand side accepts steps of some rounding units of t for ever. Ordinary small steps cover at
// least a small part of the way done or to do, so that ten thousand of them show the difference.

#include <algorithm>
#include <optional>
#include <utility>

#include "qdot/error.hpp"
#include "qdot/integrate/options.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/statistics.hpp"
#include "qdot/integrate/steps/watch_budget.hpp"

namespace qdot::detail {

class RunLimits {
 public:
  explicit RunLimits(const Budget& budget) : budget_(budget) {}

  // A stretch of its own, whose steps and evaluations are counted from here (integrate/simulator.hpp).
  void begin_again(const Options& options, const Statistics& spent) {
    budget_ = Budget(options);
    steps_before_ = spent.steps;
    evaluations_before_ = spent.evaluations;
    stall_mark_ = 0.0;
  }

  // Asked after each step: whether there may be something.
  bool are_near(const Options& options, const Statistics& spent) const {
    return spent.steps - steps_before_ >= options.max_steps || budget_.is_spent(spent.evaluations - evaluations_before_) || spent.steps % stall_window == 0;
  }

  // What is exceeded then; ways() gives how far the run has come, and how far it has to go to t_end.
  template <class Ways>
  [[gnu::cold]] std::optional<Failure> exceeded(const Options& options, const Statistics& spent, long restarts, double t_end, const Ways& ways) {
    if (spent.steps - steps_before_ >= options.max_steps) return Failure{Outcome::step_limit, sentence({"max_steps = ", options.max_steps, " were taken"})};
    const long evaluations = spent.evaluations - evaluations_before_;
    if (budget_.is_spent(evaluations)) return budget_.failure(evaluations);
    if (spent.steps % stall_window != 0) return std::nullopt;
    const auto [done, left] = ways();
    const double advanced = done - std::exchange(stall_mark_, done);
    if (!(advanced > 1e-8 * std::min(done, left)))
      return Failure{Outcome::step_too_small, sentence({"the last ", stall_window, " steps advanced t by no more than ", advanced,
                                                        ", and t_end = ", t_end, " is far"})};
    steps_mark_ = spent.steps;
    restarts_mark_ = restarts;
    return std::nullopt;
  }

  long steps_of_stretch(const Statistics& spent) const { return spent.steps - steps_before_; }
  long steps_since_look(const Statistics& spent) const { return spent.steps - steps_mark_; }
  long restarts_since_look(long restarts) const { return restarts - restarts_mark_; }
  double seconds() const { return budget_.seconds(); }

 private:
  static constexpr long stall_window = 10'000;  // steps
  Budget budget_;
  long steps_before_ = 0, evaluations_before_ = 0;  // those of stretches before
  long steps_mark_ = 0, restarts_mark_ = 0;         // when the stall was last looked for
  double stall_mark_ = 0.0;
};

}  // namespace qdot::detail
