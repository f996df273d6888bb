#pragma once
// SPDX-License-Identifier: MIT
//
// No step passes over a stay on another branch.
//
// A functor that compares a coordinate, q < a ? f : g, has other equations in another place. A step whose stages all miss this place
// does not feel it, and no error estimate can tell. So behind each step the guards of the branch (ad/formula/branches.hpp) are evaluated
// along its polynomial. Where they show a branch that the stages missed, the step is taken once more and ends there:
//
//     stages      x           x      x            x        guard, at 16 places      + + + − − + + + + + + + + + + +
//     the place          [ ]                               ends where               ↑ the fourth is
//
// Then its last stage is on that branch, and the error estimate reacts. A method that can hold the branch of a step's begin, by formulas
// that go on beyond the guards, cuts the step where its polynomial leaves the branch. No order is lost at a kink or jump then.
//
// Methods with a step of fixed length, stairs that switch in nearly every step, and functors that ask for plain values are not watched.
// A visit to a branch and back within a sixteenth of a step is not seen where its guard turns twice there.

#include <Eigen/Core>
#include <memory>

#include "qdot/integrate/time_point.hpp"
#include "qdot/integrate/steps/neighbouring_branches.hpp"
#include "qdot/integrate/steps/polynomial.hpp"
#include "qdot/integrate/watch/branch_steps.hpp"
#include "qdot/integrate/watch/watched_form.hpp"

namespace qdot::detail {

/// Looks at the steps of one run, of a form whose functors can be recorded.
class BranchWatch {
 public:
  BranchWatch(const WatchedForm& form, double rtol) : form_(form), rtol_(rtol) {}

  /// Begins behind a change of the state, where functors that compare may have become others.
  void begin() {
    if (steps_) steps_->forget();
  }
  /// Whether steps from (t, y) may pass over a branch: whether functors compare anything.
  bool may_pass(double t, const Eigen::VectorXd& y) {
    if (!is_known_) compares_ = !form_.is_known_to_compare_nothing() && has_guards(t, y), is_known_ = true;
    return compares_;
  }

  /// What is found of a step. Of one that was held on its first branch nothing else would tell: then what goes wrong here ends the run.
  Passage passage(const Clock& clock, const PolynomialView& step, double from, double to, Course course) {
    try {
      if (!steps_) steps_ = std::make_unique<BranchSteps<>>(form_, rtol_);
      if (course == Course::ends_at_branches) return steps_->beginning(clock, step, from, to);
      return course == Course::held ? steps_->held(clock, step, from, to) : steps_->passage(clock, step, from, to);
    } catch (...) {  // the run itself will say what is wrong
      Passage none;
      if (course == Course::held) none.retake = from;
      return none;
    }
  }

 private:
  [[gnu::cold]] bool has_guards(double t, const Eigen::VectorXd& y) const {
    return !recorded_branch(form_.dof(), t, y, [&](RecordedBranch& branch) { form_.record_branch(branch); })->branches.met.empty();
  }

  const WatchedForm& form_;
  double rtol_;
  bool is_known_ = false, compares_ = false;
  std::unique_ptr<BranchSteps<>> steps_;
};

}  // namespace qdot::detail
