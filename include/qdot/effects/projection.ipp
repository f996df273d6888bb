#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of projection.hpp. A program that links qdot::compiled has them from there.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>

#include "qdot/effects/equations/constraint_geometry.ipp"
#include "qdot/effects/equations/scene_rows.hpp"
#include "qdot/effects/projection.hpp"
#include "qdot/effects/projection_report.hpp"
#include "qdot/effects/rows/columns.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/error.hpp"

namespace qdot::detail {

// The way from q that takes φ away: the shortest in the metric of M, or that in the metric of sizes (above).
template <class Geometry, class N, class M>
N way_back(Geometry& geometry, const N& q, const M& phi) {
  constexpr double epsilon = std::numeric_limits<double>::epsilon();
  const M wanted = negated(phi);
  const N shortest = geometry.displacement(wanted);
  N size = magnitudes(q);
  double in_roundings = 0.0;  // the largest |φᵢ|/ρᵢ
  for (Eigen::Index i = 0; i < phi.size(); ++i)
    if (phi[i] != 0.0) in_roundings = std::max(in_roundings, std::abs(phi[i]) / (epsilon * geometry.reach(i, size)));
  bool harmless = !(in_roundings <= projection_limits::roundings_of_a_row);
  if (!harmless) {
    harmless = true;
    const double few = projection_limits::roundings_of_a_coordinate * epsilon * in_roundings;
    for (Eigen::Index j = 0; j < q.size(); ++j) harmless = harmless && std::abs(shortest[j]) <= few * size[j];
  }
  if (harmless) return shortest;
  for (Eigen::Index j = 0; j < q.size(); ++j) size[j] = std::max(size[j], 1e-100);
  return geometry.displacement(wanted, size);
}

// One projection of q and q̇, which it changes in place.
//
// N and M are types of a vector for coordinates and of one for rows.
template <class Geometry, class N, class M>
class Projection {
 public:
  Projection(const SceneRows& rows, Geometry& geometry, N& q, N& qdot, double t, const Column& z)
      : rows_(rows), geometry_(geometry), q_(q), qdot_(qdot), t_(t), z_(z), q_start_(q), qdot_start_(qdot) {
    for (M* const of_rows : {&phi_, &terms_}) of_rows->resize(rows.rows());
    std::fill_n(terms_.data(), terms_.size(), 0.0);
    look_at_positions();
    report_.residual_before = report_.residual = largest(phi_);
  }

  ProjectionReport run() {
    project_positions();
    require_positions();
    project_velocities();
    for (Eigen::Index i = 0; i < q_.size(); ++i) {
      report_.moved_q = std::max(report_.moved_q, std::abs(q_[i] - q_start_[i]));
      report_.moved_qdot = std::max(report_.moved_qdot, std::abs(qdot_[i] - qdot_start_[i]));
    }
    return report_;
  }

 private:
  static constexpr double epsilon = std::numeric_limits<double>::epsilon();
  // Factors are taken again beyond `nearby`; velocities are projected with those at hand where what J changes on the way is negligible.
  static constexpr double nearby = 1e-8, negligible = 1e-3 * epsilon;
  static constexpr int most_iterations = 25;

  void look_at_positions() {
    rows_.write_residual(t_, q_.data(), z_.data(), phi_.data());
    rows_.require_finite_column(t_, phi_.data());
  }

  // Newton's method for q, until a step is rounding.
  void project_positions() {
    double last_change = std::numeric_limits<double>::infinity();
    while (report_.residual > 0) {
      if (report_.iterations == most_iterations) fail("Newton's method took 25 steps and did not arrive");
      const bool is_first = report_.iterations == 0;
      if (!(distance_ <= nearby)) factor_for_positions();
      if (is_first) measure_terms();
      const N step = way_back(geometry_, q_, phi_);
      ++report_.iterations;
      const double change = relative_size(step);
      if (!all_finite(step.data(), step.size())) fail("a Newton step is not finite");
      for (Eigen::Index i = 0; i < q_.size(); ++i) q_[i] += step[i];
      distance_ += change;
      look_at_positions();
      report_.residual = largest(phi_);
      const bool at_rounding = change < projection_limits::at_rounding;
      const bool no_better = change < projection_limits::may_stand_still && change > 0.5 * last_change;
      const bool stands_still = report_.iterations > 3 && change < 1e-6 && change > 0.5 * last_change && rounding_explains_residual();
      is_small_ = is_small_ && !stands_still;
      if (at_rounding || no_better || stands_still) break;
      if (report_.iterations > 6 && change > 0.9 * last_change && change > 1e-6) fail("Newton's steps do not shrink");
      last_change = change;
    }
  }

  // Rows that depend on each other share what is asked of them, so a friction beside a wall would hold half of what the wall takes back.
  void factor_for_positions() {
    if (!of_positions_) factor_here();
    if (!rows_.has_rows(false)) return;
    of_positions_ = of_positions_ || geometry_.has_dependent_rows();
    if (!of_positions_) return;
    M kept(phi_);
    for (Eigen::Index i = 0; i < kept.size(); ++i) kept[i] = rows_.is_of_positions(i) ? 1.0 : 0.0;
    geometry_.move_to(q_, qdot_, z_, &kept);
    distance_ = 0.0;
  }
  void factor_here() {
    geometry_.move_to(q_, qdot_, z_);
    distance_ = 0.0;
  }

  // Changes count beside the coordinates, or beside 1 where these are zero; in a row whose coordinates are all small, beside its own terms.
  void measure_terms() {
    const N sizes = magnitudes(q_);
    for (Eigen::Index i = 0; i < phi_.size(); ++i) {
      terms_[i] = geometry_.reach(i, sizes);
      if (terms_[i] > 0.0) terms_[i] = std::max(terms_[i], projection_limits::rounding_of_zero * geometry_.length(i));  // below are roundings of what is zero
      is_small_ = is_small_ || (terms_[i] > 0.0 && terms_[i] < projection_limits::small_part * geometry_.length(i));
    }
    is_small_ = is_small_ && !geometry_.has_dependent_rows();  // dependent rows keep residuals of rounding size
  }
  double relative_size(const N& step) const {
    double change = 0.0;  // relative to the size of each coordinate
    for (Eigen::Index i = 0; i < q_.size(); ++i) change = std::max(change, std::abs(step[i]) / (1.0 + std::abs(q_[i])));
    if (is_small_) {
      const N sizes = magnitudes(step);
      for (Eigen::Index i = 0; i < phi_.size(); ++i)
        if (terms_[i] > 0.0) change = std::max(change, geometry_.reach(i, sizes) / terms_[i]);
    }
    return change;
  }

  // Small coordinates may belong to a row with terms of ordinary size, (x − 1)² at x = 0: its rounding asks for steps that do not shrink.
  bool rounding_explains_residual() const {
    const double size = 4 * epsilon * (1.0 + largest(q_));
    for (Eigen::Index i = 0; i < phi_.size(); ++i)
      if (!(std::abs(phi_[i]) <= size * geometry_.length(i))) return false;
    return true;
  }

  // A Newton iteration that stands still on contradicting rows has not arrived.
  void require_positions() {
    if (of_positions_ || !(distance_ <= nearby)) factor_here();
    geometry_.require_finite();
    length_.resize(phi_.size());
    for (Eigen::Index i = 0; i < phi_.size(); ++i) length_[i] = geometry_.length(i);
    is_small_ = is_small_ && !geometry_.has_dependent_rows();
    const double size_of_q = largest(q_);
    for (Eigen::Index i = 0; i < phi_.size(); ++i)
      if (is_off(i, size_of_q, terms_[i])) fail("no state satisfies all of them");
    report_.rank = geometry_.rank();
  }
  bool is_off(Eigen::Index i, double size, double own) const {
    constexpr double arrived = 1e-8;
    if (is_small_ && own > 0.0) return std::abs(phi_[i]) > arrived * own;
    return std::abs(phi_[i]) > arrived * (length_[i] * (1.0 + size) + (length_[i] < 1e-12 ? 1.0 : 0.0));
  }

  // One linear step of q̇, with the factors at hand where these are near enough.
  void project_velocities() {
    rows_.write_velocity(t_, q_.data(), qdot_.data(), z_.data(), phi_.data());
    const N speed = magnitudes(qdot_);
    double reach = 0.0;
    for (Eigen::Index i = 0; i < phi_.size(); ++i) reach = std::max(reach, geometry_.reach(i, speed));
    if (distance_ * largest(phi_) > negligible * reach) factor_here();
    phi_ = negated(phi_);
    const M before = phi_;
    const N change_of_qdot = geometry_.displacement(phi_);
    for (Eigen::Index i = 0; i < q_.size(); ++i) qdot_[i] += change_of_qdot[i];
    rows_.write_velocity(t_, q_.data(), qdot_.data(), z_.data(), phi_.data());
    rows_.require_finite_column(t_, phi_.data());
    report_.velocity_residual = largest(phi_);
    M own(phi_);  // sizes of the terms of each row
    for (Eigen::Index i = 0; i < phi_.size(); ++i) own[i] = geometry_.reach(i, speed) + std::abs(before[i]);
    const double rounding_of_others = 1e-6 * largest(own), size_of_qdot = largest(qdot_start_);
    for (Eigen::Index i = 0; i < phi_.size(); ++i)
      if (is_off(i, size_of_qdot, std::max(own[i], rounding_of_others))) fail("no velocity satisfies all of them");
  }

  [[noreturn, gnu::cold]] void fail(const char* what) const {
    const Eigen::Index worst = place_of_largest(phi_.data(), phi_.size());
    const double most = std::abs(phi_[worst]);
    const std::string row = rows_.row_names()[static_cast<std::size_t>(worst)];
    throw ConstraintError(row, t_, most,
                          sentence({"a state must be near enough to the constraints to be projected onto them, but at t = ", {t_, 6}, " ", what,
                                    "; '", row, "' is off by ", {most, 6},
                                    "; start nearer, or check that the constraints can be met together"}));
  }

  const SceneRows& rows_;
  Geometry& geometry_;
  N &q_, &qdot_;
  double t_;
  const Column& z_;
  N q_start_, qdot_start_;
  M phi_;  // φ, then J q̇ + ∂φ/∂t
  double distance_ = std::numeric_limits<double>::infinity();  // of q from where geometry is, relative as changes are
  bool of_positions_ = false;  // geometry has the rows of positions only
  M terms_;    // of each row, their size at the start
  M length_;   // of the rows of J
  bool is_small_ = false;      // some row has small coordinates only
  ProjectionReport report_;
};

template <class>
ProjectionReport projected(const SceneRows& rows, ConstraintGeometry& geometry, Column& q, Column& qdot, double t, const Column& z) {
  return Projection<ConstraintGeometry, Column, Column>(rows, geometry, q, qdot, t, z).run();
}

template <int n, int m>
ProjectionReport projected_by_size(const SceneRows& rows, Vector<double, n>& q, Vector<double, n>& qdot, double t, double cutoff, const Column& z) {
  using Sizes = KnownSizes<n, m>;
  DenseGeometry<Sizes> geometry(rows, t, cutoff);
  return Projection<DenseGeometry<Sizes>, Vector<double, n>, Vector<double, m>>(rows, geometry, q, qdot, t, z).run();
}

}  // namespace qdot::detail
