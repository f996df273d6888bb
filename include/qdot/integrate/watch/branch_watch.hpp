#pragma once
// SPDX-License-Identifier: MIT
//
// No step passes over a stay on another branch.
//
// A functor that compares a coordinate, q < a ? f : g, has other equations in another place. A step whose stages all miss this place feels nothing of
// it, and no error estimate can tell: a body that coasts through a narrow strip with a force takes it in one step. So behind each step the guards of
// the branch (ad/formula/branches.hpp) are evaluated along its polynomial. One change of sides is a switch, which the stages behind it have felt, if the
// branch of the end begins where that of the start ends. Otherwise, and where sides change twice, the step is taken once more, and ends where
// another branch was seen: then its last stage is on it, and the error estimate does what is right.
//
//     stages      x           x      x            x        guard, at 16 places      + + + − − + + + + + + + + + + +
//     the place          [ ]                               ends where               ↑ the fourth is
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
#include <optional>
#include <utility>

#include "qdot/integrate/moment.hpp"
#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/integrate/steps/polynomial.hpp"
#include "qdot/integrate/steps/recorded_branches.hpp"
#include "qdot/mechanics/derive/kept_lines.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot::detail {

// Whether the equations of a form have been derived without a comparison.
template <class F>
bool has_no_branches([[maybe_unused]] const F& form) {
  if constexpr (requires { form.is_recorded(); }) return form.is_recorded();
  return false;
}
template <class Sys>
bool has_no_branches(const FirstOrderForm<Sys>& form) {
  using E = typename Sys::EnergiesType;
  constexpr int n = Sys::dof_at_compile_time;
  if constexpr (requires { form.is_recorded(); }) return form.is_recorded();
  if constexpr (may_keep_lines<E, n>) {
    const int size = static_cast<int>(form.system().dof());
    const auto& shared = form.system().kept_lines()->shared();
    Derivations::Held held;
    return shared && size <= block_limit<n> && derivations_of(*shared).template everywhere<n>(form.system().energies(), size, held) != nullptr;
  }
  return false;
}

template <class = void>
bool compare_anything(Eigen::Index dof, double t, const Eigen::VectorXd& y, const RunFunctors& run);
// Whether functors compare anything at y.
template <class F>
[[gnu::cold]] bool functors_compare([[maybe_unused]] const F& form, [[maybe_unused]] double t, [[maybe_unused]] const Eigen::VectorXd& y) {
  if constexpr (has_branches_recorded<F>) {
    if (has_no_branches(form)) return false;
    return compare_anything(qdot::detail::dof(form), t, y, [&](RecordedBranch& each) { run_functors(each, form); });
  }
  return false;
}

/// What is found of a step.
struct Passage {
  std::optional<double> retake{};    // what may have elapsed at most at its end when it is taken again
  std::optional<Failure> trouble{};  // the run cannot go on,
  double until = 0.0;                // when so much has elapsed
};

/// Looks at the steps of a run, whatever functors there are.
class AnyBranchSteps {
 public:
  AnyBranchSteps() = default;
  AnyBranchSteps(const AnyBranchSteps&) = delete;
  AnyBranchSteps& operator=(const AnyBranchSteps&) = delete;
  virtual ~AnyBranchSteps() = default;

  virtual void forget() = 0;
  virtual Passage passage(const Clock& clock, const PolynomialView& step, double from, double to) = 0;
  /// What is met where a step begins that lies on one branch.
  virtual Passage beginning(const Clock& clock, const PolynomialView& step, double from, double to) = 0;
};
/// Those of integrate/watch/branch_steps.hpp: `run` runs functors on a recording, and `rates` evaluates ẏ.
template <class = void>
std::unique_ptr<AnyBranchSteps> branch_steps(Eigen::Index size, Eigen::Index dof, double rtol, RunFunctors run, RatesAt rates);

/// Looks at the steps of one run.
template <class F>
class BranchWatch {
 public:
  static constexpr bool watches = has_branches_recorded<F>;

  BranchWatch(const F& system, double rtol) : system_(system), rtol_(rtol) {}

  /// Begins behind a change of the state, where functors that compare may have become others.
  void begin() {
    if (steps_) steps_->forget();
  }
  /// Whether steps from (t, y) may pass over a branch: whether functors compare anything.
  bool may_pass(double t, const Eigen::VectorXd& y) {
    if (!is_known_) done_ = !functors_compare(system_, t, y), is_known_ = true;
    return !done_;
  }

  /// What is found of a step, which may be known to lie on one branch.
  Passage passage(const Clock& clock, const PolynomialView& step, double from, double to, bool on_one_branch) {
    try {
      if (!steps_)
        steps_ = branch_steps(system_.size(), qdot::detail::dof(system_), rtol_, [&form = system_](RecordedBranch& branch) { run_functors(branch, form); },
                       [&form = system_](double t, const Eigen::VectorXd& y, Eigen::VectorXd& out) { form.derivative(t, y, out); });
      return on_one_branch ? steps_->beginning(clock, step, from, to) : steps_->passage(clock, step, from, to);
    } catch (...) {  // the run itself will say what is wrong
      return {};
    }
  }

 private:
  const F& system_;
  double rtol_;
  bool is_known_ = false, done_ = false;
  std::unique_ptr<AnyBranchSteps> steps_;
};

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template bool compare_anything<void>(Eigen::Index, double, const Eigen::VectorXd&, const RunFunctors&);
extern template std::unique_ptr<AnyBranchSteps> branch_steps<void>(Eigen::Index, Eigen::Index, double, RunFunctors, RatesAt);
}  // namespace qdot::detail
#else
#include "qdot/integrate/watch/branch_steps.hpp"
#endif
