#pragma once
// SPDX-License-Identifier: MIT
//
// Back onto the constraints.
//
// Equations solved for J q̈ = γ keep φ̈ = 0, so φ and φ̇ drift as the steps' errors add up. Projection puts a state
// back by the shortest way, measured with the mass matrix: first the positions, by Newton's method on
//
//     minimize ‖q − q*‖_M   subject to   φ(q, t) = 0 ,
//
// then the velocities, in one linear step to J q̇ + ∂φ/∂t = 0 (and a = 0). In the metric of M a projection feeds
// the system an impulse of the constraints' own kind, Jᵀμ, and no other.
//
// Rounding is not drift. Each coordinate is rounded by ε|qⱼ|, so φᵢ of a state that is right to its last digit is still of the
// size
//
//     ρᵢ = ε Σⱼ |Jᵢⱼ| |qⱼ| .
//
// Projecting that away puts noise into each step, most of it where there is least inertia. No harm is done where a coordinate
// moves by about its own rounding. But an elastic deflection of 1e-6 m beside a slider at 0.5 m moves by 10⁴ of its roundings,
// and rings: on the flexible slider crank (docs/hard-cases.md) that cost two to three digits. So where rounding explains the
// residual, |φᵢ| ≤ 64 ρᵢ, and a residual of ρ would move some coordinate by more than 1000 ε|qⱼ|, it is undone where it came
// from, by the shortest way in the metric Σ (δqⱼ/qⱼ)².
//
// M and J are factored where Newton's method begins, and again where it has come further than 1e-8 of the coordinates from there: behind a step of an
// integrator one factorization does for all. Velocities are projected with those factors where what J changes on the way is far below their rounding.
//
// The same two steps turn a rough initial state into a consistent one, and say what they moved.

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "qdot/effects/projection_report.hpp"
#include "qdot/effects/rows/constraint_geometry.hpp"
#include "qdot/effects/scene_motion.hpp"

namespace qdot {

namespace detail {

template <int n>
Vector<double, n> magnitudes(const Vector<double, n>& x) {
  Vector<double, n> sizes(x.size());
  for (Eigen::Index j = 0; j < x.size(); ++j) sizes[j] = std::abs(x[j]);
  return sizes;
}

// The way from q that takes φ away: the shortest in the metric of M, or that in the metric of sizes (above).
template <class Sc, int n, int m>
Vector<double, n> way_back(ConstraintGeometry<Sc>& geometry, const Vector<double, n>& q, const Vector<double, m>& phi) {
  constexpr double epsilon = std::numeric_limits<double>::epsilon();
  Vector<double, m> wanted(phi.size());
  for (Eigen::Index i = 0; i < phi.size(); ++i) wanted[i] = -phi[i];
  const Vector<double, n> shortest = geometry.displacement(wanted);
  Vector<double, n> size = magnitudes(q);
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
template <class Sc, int n, class Phases>
class Projection {
  static constexpr int m = Sc::constraints_at_compile_time;

 public:
  Projection(const Sc& scene, Vector<double, n>& q, Vector<double, n>& qdot, double t, double cutoff, const Phases& z, TracedConstraints<>* traced)
      : scene_(scene), q_(q), qdot_(qdot), t_(t), z_(z), q_start_(q), qdot_start_(qdot), phi_(constraint_residual(scene, q, t, z)),
        geometry_(scene, t, cutoff, traced), terms_(Vector<double, m>::Zero(phi_.size())) {
    require_finite_rows(scene, t, phi_);
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
  static constexpr double nearby = 1e-8, negligible = 1e-3 * epsilon;
  static constexpr int most_iterations = 25;

  // Newton's method for q, until a step is rounding.
  void project_positions() {
    double last_change = std::numeric_limits<double>::infinity();
    while (report_.residual > 0) {
      if (report_.iterations == most_iterations) fail("Newton's method took 25 steps and did not arrive");
      const bool is_first = report_.iterations == 0;
      if (!(distance_ <= nearby)) factor_for_positions();
      if (is_first) measure_terms();
      const Vector<double, n> step = way_back(geometry_, q_, phi_);
      ++report_.iterations;
      const double change = relative_size(step);
      if (!all_finite(step)) fail("a Newton step is not finite");
      for (Eigen::Index i = 0; i < q_.size(); ++i) q_[i] += step[i];
      distance_ += change;
      phi_ = constraint_residual(scene_, q_, t_, z_);
      require_finite_rows(scene_, t_, phi_);
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
    if constexpr (has_velocity_rows<Sc>) {
      of_positions_ = of_positions_ || geometry_.has_dependent_rows();
      if (!of_positions_) return;
      const Vector<double, m> kept = position_rows(scene_, q_, t_, z_);
      geometry_.move_to(q_, qdot_, z_, &kept), distance_ = 0.0;
    }
  }
  void factor_here() {
    geometry_.move_to(q_, qdot_, z_);
    distance_ = 0.0;
  }

  // Changes count beside the coordinates, or beside 1 where these are zero; in a row whose coordinates are all small, beside its own terms.
  void measure_terms() {
    const Vector<double, n> sizes = magnitudes(q_);
    for (Eigen::Index i = 0; i < phi_.size(); ++i) {
      terms_[i] = geometry_.reach(i, sizes);
      if (terms_[i] > 0.0) terms_[i] = std::max(terms_[i], projection_limits::rounding_of_zero * geometry_.length(i));  // below are roundings of what is zero
      is_small_ = is_small_ || (terms_[i] > 0.0 && terms_[i] < projection_limits::small_part * geometry_.length(i));
    }
    is_small_ = is_small_ && !geometry_.has_dependent_rows();  // dependent rows keep residuals of rounding size
  }
  double relative_size(const Vector<double, n>& step) const {
    double change = 0.0;  // relative to the size of each coordinate
    for (Eigen::Index i = 0; i < q_.size(); ++i) change = std::max(change, std::abs(step[i]) / (1.0 + std::abs(q_[i])));
    if (is_small_) {
      const Vector<double, n> sizes = magnitudes(step);
      for (Eigen::Index i = 0; i < phi_.size(); ++i)
        if (terms_[i] > 0.0) change = std::max(change, geometry_.reach(i, sizes) / terms_[i]);
    }
    return change;
  }

  // Small coordinates may belong to a row with terms of ordinary size, (x − 1)² at x = 0: its rounding asks for steps that do not shrink.
  bool rounding_explains_residual() const {
    const double size = 4 * epsilon * (1.0 + q_.cwiseAbs().maxCoeff());
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
    phi_ = constraint_velocity(scene_, q_, qdot_, t_, z_);
    const Vector<double, n> speed = magnitudes(qdot_);
    double reach = 0.0;
    for (Eigen::Index i = 0; i < phi_.size(); ++i) reach = std::max(reach, geometry_.reach(i, speed));
    if (distance_ * largest(phi_) > negligible * reach) factor_here();
    for (Eigen::Index i = 0; i < phi_.size(); ++i) phi_[i] = -phi_[i];
    const Vector<double, m> before = phi_;
    const Vector<double, n> change_of_qdot = geometry_.displacement(phi_);
    for (Eigen::Index i = 0; i < q_.size(); ++i) qdot_[i] += change_of_qdot[i];
    phi_ = constraint_velocity(scene_, q_, qdot_, t_, z_);
    require_finite_rows(scene_, t_, phi_);
    report_.velocity_residual = largest(phi_);
    Vector<double, m> own(phi_.size());  // sizes of the terms of each row
    for (Eigen::Index i = 0; i < phi_.size(); ++i) own[i] = geometry_.reach(i, speed) + std::abs(before[i]);
    const double rounding_of_others = 1e-6 * largest(own), size_of_qdot = largest(qdot_start_);
    for (Eigen::Index i = 0; i < phi_.size(); ++i)
      if (is_off(i, size_of_qdot, std::max(own[i], rounding_of_others))) fail("no velocity satisfies all of them");
  }

  [[noreturn, gnu::cold]] void fail(const char* what) const {
    const Eigen::Index worst = place_of_largest(phi_.data(), phi_.size());
    const double most = std::abs(phi_[worst]);
    const std::string row = constraint_names(scene_)[static_cast<std::size_t>(worst)];
    throw ConstraintError(row, t_, most,
                          sentence({"a state must be near enough to the constraints to be projected onto them, but at t = ", {t_, 6}, " ", what,
                                    "; '", row, "' is off by ", {most, 6},
                                    "; start nearer, or check that the constraints can be met together"}));
  }

  const Sc& scene_;
  Vector<double, n>&q_, &qdot_;
  double t_;
  const Phases& z_;
  Vector<double, n> q_start_, qdot_start_;
  Vector<double, m> phi_;  // φ, then J q̇ + ∂φ/∂t
  ConstraintGeometry<Sc> geometry_;
  double distance_ = std::numeric_limits<double>::infinity();  // of q from where geometry is, relative as changes are
  bool of_positions_ = false;  // geometry has the rows of positions only
  Vector<double, m> terms_;    // of each row, their size at the start
  Vector<double, m> length_;   // of the rows of J
  bool is_small_ = false;      // some row has small coordinates only
  ProjectionReport report_;
};

// As project() below; `traced` are equations that a run has traced, or nothing.
template <class Sys, class... Effects, int n, class Phases>
ProjectionReport projected(const Scene<Sys, Effects...>& scene, Vector<double, n>& q, Vector<double, n>& qdot, double t, double cutoff, const Phases& z,
                           TracedConstraints<>* traced) {
  using Sc = Scene<Sys, Effects...>;
  static_assert(Sc::has_constraints, "qdot: only a scene with constraints can be projected onto them");
  return Projection<Sc, n, Phases>(scene, q, qdot, t, cutoff, z, traced).run();
}

}  // namespace detail

/// The nearest state on the constraints: positions first, then velocities.
///
/// @param q, qdot  changed in place
/// @param z        the effects' own states, where constraints hold in some phases only
/// @param cutoff   relative size below which a row of J counts as dependent
/// @throws ConstraintError  when Newton's method finds no state nearby, with the row that is worst off
/// @throws NonFinite        when a constraint is not finite on the way
template <class Sys, class... Effects, int n, class Phases = detail::NoPhases>
ProjectionReport project(const Scene<Sys, Effects...>& scene, Vector<double, n>& q, Vector<double, n>& qdot, double t,
                         double cutoff = default_rank_cutoff, const Phases& z = {}) {
  return detail::projected(scene, q, qdot, t, cutoff, z, nullptr);
}

/// A state on the constraints and what it took to get there.
template <int n>
struct ConsistentState {
  State<n> state;           ///< nearest one that satisfies the constraints
  ProjectionReport report;  ///< how far that is from what was given
};

/// The consistent state nearest to a rough one, as by project().
///
/// @throws ConstraintError  when there is none nearby
/// @throws InvalidValue     when the rough state is not finite
template <class Sys, class... Effects, int n>
ConsistentState<n> consistent_state(const Scene<Sys, Effects...>& scene, const State<n>& rough,
                                    double cutoff = default_rank_cutoff) {
  detail::require_sizes(scene, rough.q, rough.qdot);
  if (!detail::all_finite(rough.q) || !detail::all_finite(rough.qdot) || !std::isfinite(rough.t))
    throw InvalidValue("an initial state must be finite, but this one has NaN or infinity in it; give every entry a number");
  ConsistentState<n> result{rough, {}};
  result.report = project(scene, result.state.q, result.state.qdot, rough.t, cutoff);
  return result;
}

}  // namespace qdot
