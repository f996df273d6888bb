#pragma once
// SPDX-License-Identifier: MIT
//
// Projection after a step, by one table of lines.
//
// A step leaves constraints by little, so one or two Newton steps of effects/projection.hpp bring a state back. All need the same numbers at a state:
//
//     φ ,    δq = −M⁻¹Jᵀ (J M⁻¹ Jᵀ)⁻¹ φ ,    u = J q̇ + ∂φ/∂t ,    δq̇ = −M⁻¹Jᵀ (J M⁻¹ Jᵀ)⁻¹ u .
//
// Lines of them, with both eliminations, take as long as an evaluation of q̈. The last evaluation finds a δq of rounding size beside 1 + |q|,
// which is not applied.
//
// Other steps are left to effects/projection.hpp, with the state as it was. They have changes above 1e-3, residuals of rounding that would move a light
// coordinate, small pivots, or numbers that are not finite.
//
// Programs that link qdot::compiled do not read this header: the library has it.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "qdot/effects/rows/kept_projection.hpp"
#include "qdot/mechanics/derive/kept_rates.ipp"
#include "qdot/mechanics/derive/traced_motion.hpp"

namespace qdot::detail {

/// Lines of φ, J q̇ + ∂φ/∂t, J and both changes, for one combination of phases, on one branch.
///
/// No more rows than coordinates, and 2000 numbers; a projection allocates nothing.
class ProjectionLines final : public AnyProjection {
 public:
  [[gnu::cold]] ProjectionLines(TracedEquations<double> equations, const LimitsOfPivots& limits) : lines_(std::move(equations)), limits_(limits) {
    TracedEquations<double>& e = lines_.equations();
    e.free_turns.clear();  // which refer to the recording of q̈
    e.apart.clear();
    if (e.rows() == 0 || e.n() > most_coordinates || e.rows() > e.n() || !is_linear_in_velocities()) return;
    solved_ = lines_.solved_projection(limits, most_numbers);
    if (!solved_.lines) return;
    phi_ = lines_.numbers(e.phi);
    velocity_ = lines_.numbers(e.velocity);
    for (std::size_t i = 0; i < e.rows(); ++i)
      for (const auto& [column, node] : e.J.row(i)) J_.push_back({i, static_cast<std::size_t>(column), lines_.numbers({node})[0]});
    is_known_ = true;
  }

  /// Whether there are lines.
  bool is_known() const { return is_known_; }

  bool project(double t, double* y, std::span<const double> phases, ProjectionReport& report) const override {
    const TracedEquations<double>& e = lines_.equations();
    const std::size_t n = e.n();
    if (!std::ranges::equal(phases, e.motion.phases)) return false;
    double x[most_numbers];
    double* const state = std::copy_n(y, 2 * n, x);
    *state = t;
    std::copy_n(y + 2 * n, e.states(), state + 1);
    ProjectionReport found;
    if (!moved_onto_positions(x, found)) return false;
    double change[most_coordinates] = {}, sum = 0.0;  // results may stand where inputs do: all are read before one is written
    for (std::size_t j = 0; j < n; ++j) change[j] = number(x, solved_.columns[j]);
    found.velocity_residual = residual_of_velocities(x, change);
    for (std::size_t j = 0; j < n; ++j) {
      found.moved_q = std::max(found.moved_q, std::abs(x[j] - y[j]));
      found.moved_qdot = std::max(found.moved_qdot, std::abs(change[j]));
      sum += x[n + j] += change[j];
      sum += x[j];
    }
    if (!is_finite(sum + found.velocity_residual)) return false;
    found.rank = static_cast<std::ptrdiff_t>(e.rows());
    std::copy_n(x, 2 * n, y);
    report = found;
    return true;
  }

 private:
  static constexpr std::size_t most_numbers = 2000, most_coordinates = 16;
  static constexpr double epsilon = std::numeric_limits<double>::epsilon();

  struct Entry {
    std::size_t row, column;
    int number;
  };

  static double number(const double* x, int k) { return k < 0 ? 0.0 : x[static_cast<std::size_t>(k)]; }  // −1 stands for zero

  // Whether J does not depend on velocities, so that one linear step solves for them.
  [[gnu::cold]] bool is_linear_in_velocities() {
    TracedEquations<double>& e = lines_.equations();
    for (const int node : e.J.nodes())
      if (e.graph().dependence(node, e.motion.qdot)[static_cast<std::size_t>(node)]) return false;
    return true;
  }

  // Newton's method on the coordinates in x. At its end x has all results at the last state; false where another way must project.
  bool moved_onto_positions(double* x, ProjectionReport& report) const {
    constexpr double an_ordinary_step = 1e-3, a_rounding = epsilon;
    constexpr int most_iterations = 4;
    double last_change = std::numeric_limits<double>::infinity(), terms[most_coordinates];  // of each row at the first state
    bool is_small = false;
    for (;; ++report.iterations) {
      if (!solved_.evaluate(x, limits_)) return false;
      double sum = report.residual = 0.0;
      for (const int k : phi_) {
        report.residual = std::max(report.residual, std::abs(number(x, k)));
        sum += number(x, k);
      }
      if (!is_finite(sum)) return false;
      if (report.iterations == 0) {
        report.residual_before = report.residual;
        is_small = has_small_rows(x, terms);
      }
      double change = 0.0;  // relative to the size of each coordinate; of small rows, beside their terms
      for (std::size_t j = 0; j < solved_.x.size(); ++j) change = std::max(change, std::abs(number(x, solved_.x[j])) / (1.0 + std::abs(x[j])));
      if (!(change <= an_ordinary_step)) return false;
      if (is_small) {
        double moved[most_coordinates] = {};
        for (const Entry& e : J_) moved[e.row] += std::abs(number(x, e.number) * number(x, solved_.x[e.column]));
        for (std::size_t i = 0; i < phi_.size(); ++i)
          if (terms[i] > 0.0) change = std::max(change, moved[i] / terms[i]);
      }
      const bool is_last = report.iterations == most_iterations;
      const bool no_better = change < projection_limits::may_stand_still && change > 0.5 * last_change;
      const bool has_arrived = change < (is_last ? projection_limits::at_rounding : a_rounding) || no_better;
      if ((report.iterations == 0 || !has_arrived) && moves_by_rounding(x)) return false;
      if (has_arrived) return true;
      if (is_last) return false;
      last_change = change;
      double step[most_coordinates];
      for (std::size_t j = 0; j < solved_.x.size(); ++j) step[j] = number(x, solved_.x[j]);
      for (std::size_t j = 0; j < solved_.x.size(); ++j) x[j] += step[j];
    }
  }

  // Whether all coordinates of a row are small, as in effects/projection.hpp; terms ← Σ |J_ij q_j| of each row.
  bool has_small_rows(const double* x, double* terms) const {
    double squares[most_coordinates] = {};
    std::fill_n(terms, phi_.size(), 0.0);
    for (const Entry& e : J_) {
      const double entry = number(x, e.number);
      terms[e.row] += std::abs(entry * x[e.column]);
      squares[e.row] += entry * entry;
    }
    bool has_small = false;
    for (std::size_t i = 0; i < phi_.size(); ++i) {
      if (!(terms[i] > 0.0)) continue;
      const double length = std::sqrt(squares[i]);
      terms[i] = std::max(terms[i], projection_limits::rounding_of_zero * length);
      has_small = has_small || terms[i] < projection_limits::small_part * length;
    }
    return has_small;
  }

  // Whether a residual that rounding explains would move a coordinate by many of its own roundings.
  bool moves_by_rounding(const double* x) const {
    double terms[most_coordinates] = {}, in_roundings = 0.0;
    for (const Entry& e : J_) terms[e.row] += std::abs(number(x, e.number) * x[e.column]);
    for (std::size_t i = 0; i < phi_.size(); ++i) {
      const double phi = std::abs(number(x, phi_[i]));
      if (phi != 0.0) in_roundings = std::max(in_roundings, phi / (epsilon * terms[i]));
    }
    if (!(in_roundings <= projection_limits::roundings_of_a_row)) return false;
    for (std::size_t j = 0; j < solved_.x.size(); ++j)
      if (!(std::abs(number(x, solved_.x[j])) <= projection_limits::roundings_of_a_coordinate * epsilon * in_roundings * std::abs(x[j]))) return true;
    return false;
  }

  // The largest |J q̇ + ∂φ/∂t| or |a| after a change of velocities. It is summed from whole velocities, so that it has their rounding.
  double residual_of_velocities(const double* x, const double* change) const {
    const double* const before = x + lines_.equations().n();
    double rest[most_coordinates];
    for (std::size_t i = 0; i < velocity_.size(); ++i) rest[i] = number(x, velocity_[i]);
    for (const Entry& e : J_) rest[e.row] -= number(x, e.number) * before[e.column];
    for (const Entry& e : J_) rest[e.row] += number(x, e.number) * (before[e.column] + change[e.column]);
    double most = 0.0;
    for (std::size_t i = 0; i < velocity_.size(); ++i) most = std::max(most, std::abs(rest[i]));
    return most;
  }

  TracedLines<> lines_;
  TracedLines<>::Solved solved_;  // δq, and δq̇ as columns
  std::vector<int> phi_, velocity_;
  std::vector<Entry> J_;
  LimitsOfPivots limits_;
  bool is_known_ = false;
};

/// Where there are no lines.
struct NoProjection final : AnyProjection {
  bool project(double, double*, std::span<const double>, ProjectionReport&) const override { return false; }
};

template <class>
[[gnu::cold]] std::unique_ptr<const AnyProjection> projection_by_lines(const AnyRates& rates) {
  const auto& solved = static_cast<const SolvedRates&>(rates);
  auto lines = std::make_unique<const ProjectionLines>(solved.equations(), solved.limits());
  if (lines->is_known()) return lines;
  return std::make_unique<const NoProjection>();
}

}  // namespace qdot::detail
