#pragma once
// SPDX-License-Identifier: MIT
//
// How a run goes over the branches of functors.
//
// A stepper that can hold the branch on which a step begins (integrate/watch/branch_watch.hpp) is asked to, where functors compare something. Then steps
// are cut where they leave their branch. Some branches have no lines to hold, and some methods hold none. There a step that
// has passed over a stay on another branch is taken again, and ends there.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "qdot/integrate/any_stepper.hpp"
#include "qdot/integrate/time_point.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/steps/one_step.hpp"
#include "qdot/integrate/watch/any_watch.hpp"

namespace qdot::detail {

/// The steps of a run over branches.
class BranchCourse {
 public:
  /// Begins at (t, y), where the stepper is.
  void begin(AnyWatch& watchdog, AnyStepper& stepper, double t, const Eigen::VectorXd& y) {
    cuts_ = 0;
    if (watchdog.sees_branches && !stepper.has_fixed_step() && watchdog.may_pass_branches(t, y) && !stepper.holds_branch()) stepper.hold_branches(tries_ > 0);
  }
  /// What the last step has passed, from (t, y), where so much had elapsed.
  Passage passage(AnyWatch& watchdog, AnyStepper& stepper, const Clock& clock, double elapsed, double reached, double t, const Eigen::VectorXd& y) {
    seen_ = std::numeric_limits<double>::quiet_NaN();
    if (!watchdog.sees_branches || stepper.has_fixed_step() || !watchdog.may_pass_branches(t, y)) return {};
    const Course course = stepper.ends_at_branches() ? Course::ends_at_branches : stepper.holds_branch() ? Course::held : Course::free;
    Passage passed = watchdog.passage(clock, stepper.polynomial(), elapsed, reached, course);
    if (course == Course::held) {
      if (!passed.cut) cuts_ = 0, often_ = std::max(often_ - 1, 0);
      if (passed.retake) tries_ = 0, stepper.hold_branches(false);  // the watch cannot see the guards
      return passed;
    }
    if (course == Course::free && tries_ > 0) --tries_, stepper.hold_branches(true);
    if (passed.retake && clock.is_at(seen_ = clock.t(*passed.retake), elapsed)) passed.retake.reset();
    return passed;
  }
  /// Where a step is to end when it is taken again; NaN where it is not.
  double seen() const noexcept { return seen_; }
  /// Notes a cut at t, when so much has elapsed of a step to `tried`. The trouble, if cuts follow each other without letting t go on. Stairs that switch
  /// every few steps are not held any more.
  std::optional<Failure> crowding(AnyStepper& stepper, double t, double elapsed, double tried) {
    constexpr int crowd = 128, steps_of_a_cut = 4, too_often = 4096;
    if ((often_ += steps_of_a_cut) > too_often) tries_ = 0, stepper.hold_branches(false);
    constexpr double crowded = 1e-9, of_t = 1e4 * std::numeric_limits<double>::epsilon();
    if (cuts_++ == 0) since_ = elapsed, tried_ = 0.0;
    tried_ += std::abs(tried - elapsed);
    if (cuts_ < crowd) return std::nullopt;
    if (std::abs(elapsed - since_) >= crowded * tried_ + of_t * std::abs(t)) return cuts_ = 0, std::nullopt;
    return Failure{Outcome::zeno, sentence({"branches of T, V or an effect follow each other at t = ", t, " without letting t go on"})};
  }
  /// Goes on from y behind a cut, on the branch that functors have there or right ahead.
  static void go_on(AnyStepper& stepper, const Clock& clock, const Passage& passed, double elapsed, const Eigen::VectorXd& y) {
    if (passed.ahead) {
      Eigen::VectorXd there(y.size());
      stepper.polynomial().at(*passed.ahead, there);
      stepper.hold_next_of(clock.shown(*passed.ahead), there);
    }
    reset_at(stepper, clock.time_point(elapsed), y);
  }

 private:
  double seen_ = std::numeric_limits<double>::quiet_NaN(), since_ = 0.0, tried_ = 0.0;
  int tries_ = 8, cuts_ = 0, often_ = 0;  // to hold a branch; in a row; beside whole steps
};

}  // namespace qdot::detail
