#pragma once
// SPDX-License-Identifier: MIT
//
// On which side of its guards a state is, for one branch of the functors.
//
// Of the recorded graph only what guards are made of is evaluated, with numbers, or with intervals where a whole step is asked about.

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "qdot/ad/formula/interval.hpp"
#include "qdot/integrate/steps/neighbouring_branches.hpp"

namespace qdot::detail {

// What the guards of a branch are made of, node by node.
[[gnu::cold]] inline std::vector<int> nodes_of_guards(const formula::Graph& graph, const std::vector<formula::Guard>& guards) {
  std::vector<int> roots, nodes;
  for (const formula::Guard& guard : guards) roots.push_back(guard.node);
  const std::vector<char> needed = graph.needed_for(roots);
  for (std::size_t i = 0; i < needed.size(); ++i)
    if (needed[i] != 0) nodes.push_back(static_cast<int>(i));
  return nodes;
}

// The sides of all guards of a recorded branch; a template, and so compiled where it is asked for.
template <class = void>
class SidesOfBranch {
 public:
  explicit SidesOfBranch(std::unique_ptr<RecordedBranch> branch)
      : branch_(std::move(branch)), needed_(nodes_of_guards(branch_->motion.recording.graph, branch_->branches.met)) {
    if (!needed_.empty()) values_.resize(static_cast<std::size_t>(needed_.back()) + 1);
  }
  bool has_guards() const { return !branch_->branches.met.empty(); }
  RecordedBranch& branch() { return *branch_; }

  /// Moves to (t, y); the first guard that does not hold there, or NaN; −1 where all hold.
  int move_to(Eigen::Index dof, double t, const Eigen::Ref<const Eigen::VectorXd>& y) {
    number_variables(dof, t, y, at_);
    const auto& nodes = branch_->motion.recording.graph.nodes();
    for (const int x : needed_) values_[static_cast<std::size_t>(x)] = formula::value_of_node(nodes[static_cast<std::size_t>(x)], at_, values_);
    const auto& met = branch_->branches.met;
    const auto left = std::find_if(met.begin(), met.end(), [this](const formula::Guard& guard) { return !guard.has(value(guard)); });
    return left == met.end() ? -1 : static_cast<int>(left - met.begin());
  }
  /// Whether all guards hold wherever the variables, as they are numbered, are within bounds; false where that is not certain.
  bool hold_within(const std::vector<Interval>& variables) {
    const auto& nodes = branch_->motion.recording.graph.nodes();
    bounds_.resize(values_.size());
    for (const int x : needed_) {
      const auto i = static_cast<std::size_t>(x);
      if (nodes[i].domain != formula::Domain::everything || has_edges(nodes[i].function)) return false;
      bounds_[i] = formula::value_of_node(nodes[i], variables, bounds_);
    }
    const auto& met = branch_->branches.met;
    return std::all_of(met.begin(), met.end(), [this](const formula::Guard& guard) {
      const Interval& bounds = bounds_[static_cast<std::size_t>(guard.node)];
      return guard.sign > 0.0 ? bounds.lower() > guard.level : bounds.upper() < guard.level;
    });
  }
  // What has been moved to.
  const std::vector<double>& at() const { return at_; }
  double value(const formula::Guard& guard) const { return values_[static_cast<std::size_t>(guard.node)]; }
  /// How far inside its side a guard is.
  double inside(std::size_t k) const {
    const formula::Guard& guard = branch_->branches.met[k];
    return guard.sign * (value(guard) - guard.level);
  }

 private:
  // Whether a function has values in a part of the numbers only, to which intervals are cut.
  static bool has_edges(formula::Function f) {
    using enum formula::Function;
    return f == asin || f == acos || f == acosh || f == atanh || f == log || f == log1p;
  }

  std::unique_ptr<RecordedBranch> branch_;
  std::vector<int> needed_;
  std::vector<double> at_{}, values_{};
  std::vector<Interval> bounds_{};
};

}  // namespace qdot::detail
