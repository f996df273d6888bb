#pragma once
// SPDX-License-Identifier: MIT
//
// The branches of functors that a power series has met: their recordings, guards and series (integrate/steps/taylor_branches.hpp).
//
// A branch is found again by what its comparisons answer, in their order. 64 are kept; then the one that has not been used for longest is replaced.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "qdot/ad/formula/branches.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/steps/neighbouring_branches.hpp"
#include "qdot/integrate/steps/taylor_equations.hpp"

namespace qdot::detail {

/// A branch with its series. Recordings know where `functors` lies.
struct SeriesBranch {
  using Guards = std::vector<formula::Guard>;

  formula::Branches functors{};
  Guards answers{};  // while the functors run again
  std::unique_ptr<LagrangeSeries<>> series{};
  long used = 0;

  const Guards& guards() const { return functors.met; }
  RecordedMotion& motion() const { return series->recorded(); }
  const formula::Graph& graph() const { return motion().recording.graph; }
};

/// Refuses what a branch has no series of: plain numbers, and constraints that branch.
///
/// @throws NotAnalytic
[[gnu::cold]] inline void require_series(const formula::Branches& branch, const RecordedMotion& motion) {
  const std::string& source = motion.recording.source;
  if (branch.read_values)
    throw NotAnalytic(sentence({"a Taylor series needs functors that are formulas between their comparisons, but ", source,
                                " asks for the plain value of a number (isfinite, isnan, isinf); use Dop853, which takes them as they are"}),
                      source);
  if (motion.guards_of_forces < branch.met.size())
    throw NotAnalytic(sentence({"a Taylor series needs constraints that are one formula everywhere, but ", source, " has ",
                                branch.met[motion.guards_of_forces].what, "; use Dop853, which takes them as they are"}),
                      source);
}

/// The branches kept.
template <class = void>  // compiled only where it is made
class KeptBranches {
 public:
  using Branch = SeriesBranch;
  using Guards = SeriesBranch::Guards;
  static constexpr std::size_t most = 64;

  KeptBranches(std::shared_ptr<const MotionSource> source, int highest_order) : source_(std::move(source)), highest_(highest_order) {}

  int highest_order() const noexcept { return highest_; }
  long recordings() const noexcept { return recordings_; }
  Eigen::Index dof() const { return source_->dof(); }
  void clear() { kept_.clear(); }
  /// Whether the functors still are what was recorded, on each branch.
  bool hold() const {
    return std::all_of(kept_.begin(), kept_.end(), [this](const std::unique_ptr<Branch>& each) { return still_holds(*each); });
  }

  /// The branch at a state whose comparisons begin with these answers: one that is kept, or it is recorded. There a guard may be beyond its level by as much
  /// as `noise` of it says.
  template <class Noise>
  Branch* at(const Guards& answers, double t, const double* y, const Noise& noise) {
    for (const std::unique_ptr<Branch>& each : kept_) {
      if (!begins_with(each->guards(), answers)) continue;
      bool fits = true;
      for (std::size_t k = answers.size(); fits && k < each->guards().size(); ++k) {
        const double value = above(*each, k, t, y);
        fits = value > 0.0 || (value == 0.0 && each->guards()[k].closed) || std::abs(value) <= noise(*each, k);
      }
      if (!fits) continue;
      each->used = ++uses_;
      return each.get();
    }
    return recorded(answers, t, y);
  }

  /// Says that a branch is in use, so that it is not the next to be replaced.
  void use(Branch& branch) { branch.used = ++uses_; }

  /// Values of the first `count` nodes of a branch at a state, valid till others are asked for.
  const std::vector<double>& values(const Branch& branch, std::size_t count, double t, const double* y) {
    number_variables(source_->dof(), t, Eigen::Map<const Eigen::VectorXd>(y, source_->size()), at_);
    return values(branch, count);
  }
  /// How far guard k is above its level, on the side of its branch.
  double above(const Branch& branch, std::size_t k, double t, const double* y) {
    const formula::Guard& guard = branch.guards()[k];
    return guard.sign * (values(branch, static_cast<std::size_t>(guard.node) + 1, t, y).back() - guard.level);
  }
  /// How much it changes with changes of all components by their weights, and of t by its own.
  double change(const Branch& branch, std::size_t k, double t, const double* y, const double* weights, double of_t);

 private:
  static bool same(const formula::Guard& a, const formula::Guard& b) {
    return a.node == b.node && a.sign == b.sign && a.level == b.level && a.closed == b.closed;
  }
  static bool begins_with(const Guards& all, const Guards& first) {
    return all.size() >= first.size() && std::equal(first.begin(), first.end(), all.begin(), same);
  }
  bool still_holds(Branch& branch) const {
    branch.answers = std::exchange(branch.functors.met, {});
    branch.functors.answers = &branch.answers;
    bool same_formulas = false;
    try {
      same_formulas = source_->still_holds(branch.motion());
    } catch (...) {
      branch.functors.answers = nullptr, branch.functors.met = std::move(branch.answers);
      throw;
    }
    branch.functors.answers = nullptr;
    const bool holds = same_formulas && branch.guards().size() == branch.answers.size() && begins_with(branch.guards(), branch.answers);
    if (!holds) branch.functors.met = std::move(branch.answers);  // those of the series, which may go on
    return holds;
  }
  const std::vector<double>& values(const Branch& branch, std::size_t count) {
    values_.clear();
    formula::evaluate_nodes(branch.graph(), at_, values_, count);
    return values_;
  }
  Branch* recorded(const Guards& answers, double t, const double* y);

  std::shared_ptr<const MotionSource> source_;
  int highest_;
  std::vector<std::unique_ptr<Branch>> kept_{};
  long uses_ = 0, recordings_ = 0;
  std::vector<double> at_{}, values_{};
};

template <class X>
double KeptBranches<X>::change(const Branch& branch, std::size_t k, double t, const double* y, const double* weights, double of_t) {
  constexpr double shift = 0x1p-26;
  const auto time = static_cast<std::size_t>(2 * source_->dof());
  const auto count = static_cast<std::size_t>(branch.guards()[k].node) + 1;
  const double here = values(branch, count, t, y).back();
  double sum = 0.0;
  for (std::size_t i = 0; i < at_.size(); ++i) {
    const double weight = i == time ? of_t : weights[i < time ? i : i - 1], by = shift * std::max(std::abs(at_[i]), weight);
    if (by == 0.0) continue;
    const double before = std::exchange(at_[i], at_[i] + by);
    sum += std::abs(values(branch, count).back() - here) / by * weight;
    at_[i] = before;
  }
  return sum;
}

template <class X>
[[gnu::cold]] SeriesBranch* KeptBranches<X>::recorded(const Guards& answers, double t, const double* y) {
  auto made = std::make_unique<Branch>();
  made->functors.answers = &answers;
  number_variables(source_->dof(), t, Eigen::Map<const Eigen::VectorXd>(y, source_->size()), made->functors.variables);
  RecordedMotion motion = source_->recorded(&made->functors);
  made->functors.answers = nullptr;
  require_series(made->functors, motion);
  std::vector<int> nodes;
  for (const formula::Guard& guard : made->guards()) nodes.push_back(guard.node);
  made->series = std::make_unique<LagrangeSeries<>>(source_, std::move(motion), highest_, nodes);
  made->used = ++uses_;
  ++recordings_;
  if (kept_.size() == most)
    kept_.erase(std::min_element(kept_.begin(), kept_.end(), [](const auto& a, const auto& b) { return a->used < b->used; }));
  kept_.push_back(std::move(made));
  return kept_.back().get();
}

#ifdef QDOT_COMPILED
extern template class KeptBranches<>;
#endif

}  // namespace qdot::detail
