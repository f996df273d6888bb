#pragma once
// SPDX-License-Identifier: MIT
//
// No step passes over a stay on another branch.
//
// A functor that compares a coordinate, q < a ? f : g, has other equations in another place. A step whose stages all miss this place does not feel it,
// and no error estimate can tell. A body that coasts through a narrow strip with a force, for example, takes it in one step. So behind each step the
// guards of the branch (ad/formula/branches.hpp) are evaluated along its polynomial. One change of sides is a switch, which the stages behind it have
// felt, if the branch of the end begins where that of the start ends. Otherwise, and where sides change twice, the step is taken once more, and ends
// where another branch was seen. Then its last stage is on that branch, and the error estimate reacts.
//
//     stages      x           x      x            x        guard, at 16 places      + + + − − + + + + + + + + + + +
//     the place          [ ]                               ends where               ↑ the fourth is
//
// Where a method can hold the branch on which a step begins, by its recorded formulas that go on beyond the guards, no stage feels the other side. Then the
// step is cut where its polynomial leaves the branch, as by an event, and the method begins afresh behind it. No order is lost at a kink or jump.
//
// Where bounds of the polynomial show that no guard is reached, the places are not looked at. A guard that comes near to its level between two places
// and turns is followed to where it turns. What the motion meets at a boundary, a blow or a place that it cannot leave, ends the run by a name
// (integrate/watch/branch_crossing.hpp).
//
// The branch is recorded behind the first step, and anew where its guards have changed. Functors that compare nothing are known to do so from then on,
// mostly because their equations have been derived. Stairs that switch in nearly every step, and what asks for plain values, are left alone. Methods
// with a step of fixed length are not watched; in lanes such functors run one by one. A visit to a branch and back within a sixteenth of a step is
// not seen where its guard turns twice there.

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
