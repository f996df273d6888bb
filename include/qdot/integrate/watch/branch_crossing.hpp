#pragma once
// SPDX-License-Identifier: MIT
//
// What a motion meets where it goes from one branch of its functors to another.
//
// A force may jump there, and V and T may have a kink: velocities are continuous, and a step that the other branch shortens follows them. That is not so
// where
//
//     L jumps with a coordinate      a step of V, a mass that depends on the side: a blow, of which the branches, each by itself, know nothing
//     p = ∂L/∂q̇ jumps               a mass that changes with time: p would be continuous, and not the velocity
//     φ, or φ̇ at the same q̇, jumps   the constraint leaves the place, or the direction, of the motion
//     both sides push back           the motion slides along the boundary, and each step crosses it once more
//
// The first three are decided by values of both recordings at one state; a blow is large where it is more than the tolerances and rounding allow. The
// last is decided by the rate of the guard, ġ = ∂g/∂(q, q̇, t, z) · (q̇, q̈, 1, ż), with the rates of either side. Each ends the run by a name.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "qdot/integrate/outcome.hpp"
#include "qdot/integrate/steps/neighbouring_branches.hpp"

namespace qdot::detail {

/// Beside what a jump is one: the largest coordinate, velocity and |T| + |V| of the motion so far.
struct SizesOfMotion {
  double q = 0.0, qdot = 0.0, energy = 0.0;
};

/// Two branches, and a state at their boundary.
template <class Number = double>
class BranchCrossing {
 public:
  /// @param guard  the first of `before` that does not hold behind
  /// @param at     q, q̇, t and z there
  BranchCrossing(RecordedBranch& before, RecordedBranch& behind, std::size_t guard, const std::vector<Number>& at, const SizesOfMotion& sizes, double rtol)
      : before_(before), behind_(behind), guard_(before.branches.met[guard]), at_(at), beside_(at), sizes_(sizes), allowed_(std::max(1e-9, 10.0 * rtol)),
        dof_(before.motion.q.size()) {
    for (Number& x : beside_) x -= 8.0 * std::numeric_limits<Number>::epsilon() * x;
  }

  /// The trouble, if there is some: a jump of what must be continuous.
  [[gnu::cold]] std::optional<Failure> jump();
  /// Likewise, where both sides push back, or, at a start, away: rates on this side and on the other, in the direction of the run.
  [[gnu::cold]] std::optional<Failure> sliding(const Eigen::VectorXd& rates_before, const Eigen::VectorXd& rates_behind, double direction,
                                               bool is_start = false);

 private:
  double t() const { return at_[2 * dof_]; }
  [[gnu::cold]] bool is_of_time_alone() {
    std::vector<int> state = before_.variables();
    state.pop_back();
    formula::Graph& graph = before_.motion.recording.graph;
    const std::vector<int> slopes = graph.gradient(guard_.node, state);
    return std::all_of(slopes.begin(), slopes.end(), [&](int slope) { return graph.is_constant(slope, 0.0); });
  }
  // Values at the boundary, and by how much rounding of the state and of t may change them.
  struct Values {
    std::vector<double> at, rounding;
  };
  [[gnu::cold]] Values values(RecordedBranch& of, const std::vector<int>& nodes) const {
    Values some{of.values(nodes, at_), of.values(nodes, beside_)};
    for (std::size_t i = 0; i < nodes.size(); ++i) some.rounding[i] = 4.0 * std::abs(some.rounding[i] - some.at[i]);
    return some;
  }
  Values momenta(RecordedBranch& of) { return values(of, of.motion.recording.graph.gradient(of.motion.returned[0], of.motion.qdot)); }
  bool is_jump(double a, double b, double size, double rounding) const {
    return std::abs(a - b) > allowed_ * size + rounding + std::numeric_limits<double>::min();
  }
  [[gnu::cold]] std::optional<Failure> jump_of_rows();
  [[gnu::cold]] Failure named(Outcome outcome, const std::string& what) const {
    return {outcome, sentence({"where ", guard_.what, " takes another branch, at t = ", {t(), 10}, ", ", what})};
  }

  RecordedBranch &before_, &behind_;
  formula::Guard guard_;
  const std::vector<Number>& at_;
  std::vector<Number> beside_;
  SizesOfMotion sizes_;
  double allowed_;
  std::size_t dof_;
};

template <class Number>
std::optional<Failure> BranchCrossing<Number>::jump() {
  const std::vector<int>&here = before_.motion.returned, &there = behind_.motion.returned;
  if (here.size() < 2 || here.size() != there.size()) return std::nullopt;  // a functor could not be recorded to its end
  const Values own = momenta(before_), others = momenta(behind_);
  const std::vector<double>&p = own.at, &p_behind = others.at;
  double size = sizes_.qdot > 0.0 ? 2.0 * sizes_.energy / sizes_.qdot : 0.0;
  for (const double x : p) size += std::abs(x);
  for (const double x : p_behind) size += std::abs(x);
  for (std::size_t i = 0; i < p.size(); ++i)
    if (is_jump(p[i], p_behind[i], size, own.rounding[i] + others.rounding[i]))
      return named(Outcome::refused_by_model,
                   sentence({"a momentum, the derivative of T with respect to a velocity, jumps from ", p[i], " to ", p_behind[i],
                             ": a mass that jumps takes a blow; end the run there and begin another with the velocity behind it"}));
  const Values energies = values(before_, {here[0], here[1]}), behind = values(behind_, {there[0], there[1]});
  const double L = energies.at[0] - energies.at[1], L_behind = behind.at[0] - behind.at[1];
  const double sum = std::abs(energies.at[0]) + std::abs(energies.at[1]) + std::abs(behind.at[0]) + std::abs(behind.at[1]);
  const double rounding = energies.rounding[0] + energies.rounding[1] + behind.rounding[0] + behind.rounding[1];
  if (is_jump(L, L_behind, sizes_.energy + sum, rounding) && !is_of_time_alone())
    return named(Outcome::refused_by_model,
                 sentence({"T - V jumps from ", L, " to ", L_behind,
                           ": its force there is a blow, which no branch has; make V a steep ramp, or let an event change the velocity"}));
  return jump_of_rows();
}

template <class Number>
std::optional<Failure> BranchCrossing<Number>::jump_of_rows() {
  const std::size_t first = 2 + before_.forces, n = dof_;
  for (std::size_t k = 0; first + k < before_.motion.returned.size() && k < before_.holonomic.size(); ++k) {
    const auto row = [&](RecordedBranch& of) {  // its value, slopes, and rate
      formula::Graph& graph = of.motion.recording.graph;
      const int x = of.motion.returned[first + k];
      std::vector<int> nodes{x};
      const std::vector<int> slopes = graph.gradient(x, of.holonomic[k] ? of.motion.q : of.motion.qdot);
      nodes.insert(nodes.end(), slopes.begin(), slopes.end());
      int rate = graph.gradient(x, std::vector<int>{of.motion.t})[0];
      for (std::size_t i = 0; i < n && of.holonomic[k] != 0; ++i) rate = graph.sum(rate, graph.product(slopes[i], of.motion.qdot[i]));
      nodes.push_back(rate);
      return values(of, nodes);
    };
    const Values own = row(before_), others = row(behind_);
    const std::vector<double>&a = own.at, &b = others.at;
    double slopes = 0.0;
    for (std::size_t i = 0; i < n; ++i) slopes += std::abs(a[1 + i]) + std::abs(b[1 + i]);
    const double rate_before = a[n + 1], rate_behind = b[n + 1], speed = slopes * sizes_.qdot;
    const bool of_velocities = before_.holonomic[k] == 0;
    if (is_jump(a[0], b[0], of_velocities ? speed : slopes * sizes_.q, own.rounding[0] + others.rounding[0]))
      return named(Outcome::constraint_failure, sentence({"a constraint jumps from ", a[0], " to ", b[0], ", away from the motion; make it continuous"}));
    if (!of_velocities && is_jump(rate_before, rate_behind, speed, own.rounding[n + 1] + others.rounding[n + 1]))
      return named(Outcome::constraint_failure, sentence({"a constraint has a kink: its rate jumps from ", rate_before, " to ", rate_behind,
                                                          ", so the motion would take a blow; round the kink off, or let an event change the velocity"}));
  }
  return std::nullopt;
}

template <class Number>
std::optional<Failure> BranchCrossing<Number>::sliding(const Eigen::VectorXd& rates_before, const Eigen::VectorXd& rates_behind, double direction,
                                                       bool is_start) {
  constexpr double clearly = 1e-6;
  const std::vector<int> variables = before_.variables();
  const std::vector<double> slopes = before_.values(before_.motion.recording.graph.gradient(guard_.node, variables), at_);
  double here = slopes.back(), there = slopes.back(), size = std::abs(slopes.back());
  for (Eigen::Index i = 0; i < rates_before.size(); ++i) {
    const double slope = slopes[static_cast<std::size_t>(i)];
    here += slope * rates_before[i], there += slope * rates_behind[i];
    size = std::max({size, std::abs(slope * rates_before[i]), std::abs(slope * rates_behind[i])});
  }
  if (is_start && size == 0.0) {  // at rest on a guard of place: its second derivative decides, in both directions of time
    for (std::size_t i = 0; i < dof_; ++i) {
      const auto a = static_cast<Eigen::Index>(dof_ + i);
      here += slopes[i] * rates_before[a], there += slopes[i] * rates_behind[a];
      size = std::max({size, std::abs(slopes[i] * rates_before[a]), std::abs(slopes[i] * rates_behind[a])});
    }
    direction = 1.0;
  }
  here *= direction * guard_.sign, there *= direction * guard_.sign;  // how fast the run goes back to this side
  if (here > clearly * size && there < -clearly * size && is_start)
    return named(Outcome::refused_by_model,
                 "the start lies on the boundary and the equations on either side lead away from it, so that the motion is not unique; begin on one side");
  if (!(here < -clearly * size && there > clearly * size)) return std::nullopt;
  return named(Outcome::zeno, "the equations on either side push the motion back to the other, so that it switches without end: it slides "
                                            "along the boundary; say friction by dry_friction() and walls by contact(), which hold it there");
}

#ifdef QDOT_COMPILED
extern template class BranchCrossing<double>;
#endif

}  // namespace qdot::detail
