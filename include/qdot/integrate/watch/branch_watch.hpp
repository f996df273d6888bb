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
// The branch is recorded behind the first step, and anew where its guards have changed. Functors that compare nothing are known to do so from then on,
// mostly because their equations have been derived. Stairs that switch in nearly every step, and what asks for plain values, are left alone. Methods
// with a step of fixed length are not watched; in lanes such functors run one by one. A visit to a branch and back within a sixteenth of a step is
// not seen.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "qdot/integrate/moment.hpp"
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

// Whether functors compare anything at y.
template <class F>
[[gnu::cold]] bool functors_compare([[maybe_unused]] const F& form, [[maybe_unused]] double t, [[maybe_unused]] const Eigen::VectorXd& y) {
  if constexpr (has_branches_recorded<F>) {
    if (has_no_branches(form)) return false;
    const auto branch = recorded_branch(qdot::detail::dof(form), t, y, [&](RecordedBranch& each) { run_functors(each, form); });
    return !branch->branches.met.empty();
  }
  return false;
}

// The sides of all guards of a recorded branch; a template, and so compiled where it is asked for.
template <class = void>
class SidesOfBranch {
 public:
  explicit SidesOfBranch(std::unique_ptr<RecordedBranch> branch) : branch_(std::move(branch)) {}
  bool has_guards() const { return !branch_->branches.met.empty(); }

  /// Whether (t, y) is on another side of some guard than the branch.
  bool left_at(Eigen::Index dof, double t, const Eigen::Ref<const Eigen::VectorXd>& y) {
    number_variables(dof, t, y, at_);
    values_.clear();
    const auto& met = branch_->branches.met;
    int last = -1;
    for (const formula::Guard& guard : met) last = std::max(last, guard.node);
    formula::evaluate_nodes(branch_->motion.recording.graph, at_, values_, static_cast<std::size_t>(last) + 1);
    return std::any_of(met.begin(), met.end(), [this](const formula::Guard& guard) {
      const double value = values_[static_cast<std::size_t>(guard.node)];
      return !guard.has(value) && !std::isnan(value);
    });
  }

 private:
  std::unique_ptr<RecordedBranch> branch_;
  std::vector<double> at_{}, values_{};
};

/// Looks at steps, whatever functors there are: `run` runs them on a recording.
template <class Number = double>
class BranchSteps {
 public:
  BranchSteps(Eigen::Index size, Eigen::Index dof, RunFunctors run) : size_(size), dof_(dof), run_(std::move(run)) {}

  void forget() { here_.reset(); }
  /// What may have elapsed at most at the end of a step that is to be taken again; nothing where all was seen.
  std::optional<double> unseen(const Clock& clock, const PolynomialView& step, double from, double to);

 private:
  static constexpr int places = 16, halvings = 30, most_retaken = 1000;

  // What the state is at a fraction of the step.
  void move_to(double fraction) {
    const double elapsed = fraction == 1.0 ? to_ : from_ + fraction * (to_ - from_);
    y_all_.resize(step_.size);
    step_.at(elapsed, y_all_);
    y_ = y_all_.head(size_);
    t_ = clock_.shown(elapsed);
  }
  bool left_at(SidesOfBranch<>& sides, double fraction) { return move_to(fraction), sides.left_at(dof_, t_, y_); }
  std::unique_ptr<SidesOfBranch<>> sides_at(double fraction) {
    return move_to(fraction), std::make_unique<SidesOfBranch<>>(recorded_branch(dof_, t_, y_, run_));
  }
  // How far sides hold, between where they do and where they do not.
  double edge(SidesOfBranch<>& sides, double holds, double is_left) {
    for (int k = 0; k < halvings; ++k) {
      const double middle = 0.5 * (holds + is_left);
      (left_at(sides, middle) ? is_left : holds) = middle;
    }
    return holds;
  }

  Eigen::Index size_, dof_;
  RunFunctors run_;
  long retaken_ = 0;
  std::unique_ptr<SidesOfBranch<>> here_{};
  Clock clock_{};
  PolynomialView step_{};
  double from_ = 0.0, to_ = 0.0, t_ = 0.0;  // of the step, and of the place last looked at
  Eigen::VectorXd y_{}, y_all_{};
};

template <class Number>
[[gnu::cold, gnu::noinline]] std::optional<double> BranchSteps<Number>::unseen(const Clock& clock, const PolynomialView& step, double from, double to) {
  if (retaken_ > most_retaken) return std::nullopt;
  clock_ = clock, step_ = step, from_ = from, to_ = to;
  if (!here_ || left_at(*here_, 0.0)) here_ = sides_at(0.0);
  if (!here_->has_guards()) return std::nullopt;
  int changes = 0, first = 0;
  for (int k = 1, was = 0; k <= places; ++k)
    if (const int is = left_at(*here_, static_cast<double>(k) / places) ? 1 : 0; is != std::exchange(was, is) && ++changes == 1) first = k;
  if (changes == 0) return std::nullopt;
  double seen = static_cast<double>(first) / places;
  if (changes == 1) {  // a third branch may lie between the two
    auto behind = sides_at(1.0);
    const double last = edge(*here_, seen - 1.0 / places, seen), next = edge(*behind, 1.0, last);
    if (next - last < 4.0 * std::ldexp(1.0, -halvings)) return here_ = std::move(behind), std::nullopt;
    seen = 0.5 * (last + next);
  }
  ++retaken_;
  return from + seen * (to - from);
}

#ifdef QDOT_COMPILED
extern template class BranchSteps<double>;
#endif

/// Looks at the steps of one run.
template <class F>
class BranchWatch {
 public:
  static constexpr bool watches = has_branches_recorded<F>;

  explicit BranchWatch(const F& system) : system_(system) {}

  /// Begins behind a change of the state, where functors that compare may have become others.
  void begin() {
    if (steps_) steps_->forget();
  }
  /// Whether steps from (t, y) may pass over a branch: whether functors compare anything.
  bool may_pass(double t, const Eigen::VectorXd& y) {
    if (!is_known_) done_ = !functors_compare(system_, t, y), is_known_ = true;
    return !done_;
  }

  /// As BranchSteps has it.
  std::optional<double> unseen(const Clock& clock, const PolynomialView& step, double from, double to) {
    try {
      if (!steps_) steps_.emplace(system_.size(), qdot::detail::dof(system_), [&form = system_](RecordedBranch& branch) { run_functors(branch, form); });
      return steps_->unseen(clock, step, from, to);
    } catch (...) {  // the run itself will say what is wrong
      return std::nullopt;
    }
  }

 private:
  const F& system_;
  bool is_known_ = false, done_ = false;
  std::optional<BranchSteps<>> steps_{};
};

// Of forms whose functors cannot be recorded.
struct NoBranchWatch {
  explicit NoBranchWatch(const auto&) {}
};

}  // namespace qdot::detail
