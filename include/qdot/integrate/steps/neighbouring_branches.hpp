#pragma once
// SPDX-License-Identifier: MIT
//
// Whether the neighbour of a branch has other equations.
//
// Where a comparison is a tie, a run of the functors with the other answer gives the neighbour's graph (integrate/steps/recorded_branches.hpp).
// Derivatives of what was returned show what differs: the equations, or their slopes only.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "qdot/ad/formula/branches.hpp"
#include "qdot/integrate/steps/recorded_branches.hpp"

namespace qdot::detail {

using RunFunctors = std::function<void(RecordedBranch&)>;

// q, q̇, z, and t last.
inline std::vector<int> RecordedBranch::variables() const {
  std::vector<int> all;
  for (const auto* list : {&motion.q, &motion.qdot, &motion.z}) all.insert(all.end(), list->begin(), list->end());
  all.push_back(motion.t);
  return all;
}
// Of nodes, where the variables have these values.
inline std::vector<double> RecordedBranch::values(const std::vector<int>& nodes, const std::vector<double>& at) const {
  std::vector<double> all, some;
  formula::evaluate_nodes(motion.recording.graph, at, all, motion.recording.graph.nodes().size());
  for (const int x : nodes) some.push_back(all[static_cast<std::size_t>(x)]);
  return some;
}

// [q, q̇, t, z] of y = [q, q̇, z], as the graph numbers its variables.
inline void number_variables(Eigen::Index dof, double t, const Eigen::Ref<const Eigen::VectorXd>& y, std::vector<double>& to) {
  to.assign(y.data(), y.data() + y.size());
  to.insert(to.begin() + 2 * dof, t);
}

// The branch at y; or where answers are given, the one of these answers.
[[gnu::cold]] inline std::unique_ptr<RecordedBranch> recorded_branch(Eigen::Index dof, double t, const Eigen::Ref<const Eigen::VectorXd>& y,
                                                                     const RunFunctors& run, const std::vector<formula::Guard>* answers = nullptr) {
  auto made = std::make_unique<RecordedBranch>();
  number_variables(dof, t, y, made->branches.variables);
  made->branches.answers = answers;
  RecordedMotion& m = made->motion;
  m.q = new_variables(m.recording, 0, dof);
  m.qdot = new_variables(m.recording, dof, dof);
  m.t = formula::variable_in(m.recording, static_cast<int>(2 * dof));
  m.z = new_variables(m.recording, 2 * dof + 1, y.size() - 2 * dof);
  try {
    run(*made);
  } catch (...) {  // as far as it can be recorded; what is wrong with a functor the equations find out
  }
  return made;
}

// Nodes of the derivatives of x up to an order, x itself first.
inline std::vector<int> derivatives_of(formula::Graph& graph, int x, const std::vector<int>& variables, int order) {
  std::vector<int> all{x};
  for (std::size_t from = 0; order > 0; --order) {
    const std::size_t to = all.size();
    for (; from < to; ++from) {
      const std::vector<int> slopes = graph.gradient(all[from], variables);
      all.insert(all.end(), slopes.begin(), slopes.end());
    }
  }
  return all;
}

// Whether two branches have other equations at these values of the variables, or for slopes = 1 other slopes of the equations.
[[gnu::cold]] inline bool differ(RecordedBranch& a, RecordedBranch& b, const std::vector<double>& at, int slopes) {
  constexpr double rounding = 1e-11;
  const std::vector<int> variables = a.variables(), of_state(variables.begin(), variables.end() - 1);
  const std::size_t count = a.motion.returned.size();
  if (b.motion.returned.size() != count) return false;  // beyond the tie there is no model
  for (std::size_t i = 0; i < count; ++i) {
    const int x = a.motion.returned[i], y = b.motion.returned[i];
    // Of T what M and p are made of; of V the force; forces and rates themselves; of a row of a constraint its acceleration.
    const int order = slopes + (i == 1 ? 1 : i > 1 && i < 2 + a.forces ? 0 : 2);
    const std::vector<int>& by = i > 0 && i < 2 + a.forces ? of_state : variables;
    const std::vector<double> here = a.values(derivatives_of(a.motion.recording.graph, x, by, order), at);
    const std::vector<double> there = b.values(derivatives_of(b.motion.recording.graph, y, by, order), at);
    double size = 0.0, apart = 0.0;
    for (std::size_t k = 0; k < here.size(); ++k) {
      if (!std::isfinite(here[k]) && !std::isfinite(there[k])) continue;
      size = std::max({size, std::abs(here[k]), std::abs(there[k])});
      apart = std::max(apart, std::abs(here[k] - there[k]));
    }
    if (!(apart <= rounding * size)) return true;
  }
  return false;
}

// What the neighbour of a branch behind its guard k answers, as far as this guard.
[[gnu::cold]] inline std::vector<formula::Guard> answers_behind(const std::vector<formula::Guard>& met, std::size_t k) {
  std::vector<formula::Guard> answers(met.begin(), met.begin() + static_cast<std::ptrdiff_t>(k) + 1);
  if (!answers[k].of_floor) {
    answers[k].sign = -answers[k].sign;
    answers[k].closed = !answers[k].closed;
  } else if (answers[k].sign > 0.0) {
    answers[k].level -= 1.0;
  } else {
    answers.pop_back();
    answers.back().level += 1.0;
  }
  return answers;
}

// The neighbour of a branch behind its guard k.
[[gnu::cold]] inline std::unique_ptr<RecordedBranch> neighbour(const RecordedBranch& of, std::size_t k, Eigen::Index dof, double t,
                                                               const Eigen::Ref<const Eigen::VectorXd>& y, const RunFunctors& run) {
  const std::vector<formula::Guard> answers = answers_behind(of.branches.met, k);
  return recorded_branch(dof, t, y, run, &answers);
}

}  // namespace qdot::detail
