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

// The way from q that takes φ away: the shortest in the metric of M, or that in the metric of sizes (above).
template <class Sc, int n, int m>
Vector<double, n> way_back(ConstraintGeometry<Sc>& geometry, const Vector<double, n>& q, const Vector<double, m>& phi) {
  constexpr double epsilon = std::numeric_limits<double>::epsilon();
  Vector<double, m> wanted(phi.size());
  for (Eigen::Index i = 0; i < phi.size(); ++i) wanted[i] = -phi[i];
  const Vector<double, n> shortest = geometry.displacement(wanted);
  Vector<double, n> size(q.size());
  for (Eigen::Index j = 0; j < q.size(); ++j) size[j] = std::abs(q[j]);
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

// As project() below; `traced` are equations that a run has traced, or nothing.
template <class Sys, class... Effects, int n, class Phases>
ProjectionReport projected(const Scene<Sys, Effects...>& scene, Vector<double, n>& q, Vector<double, n>& qdot, double t, double cutoff, const Phases& z,
                           TracedConstraints<>* traced) {
  using Sc = Scene<Sys, Effects...>;
  static_assert(Sc::has_constraints, "qdot: only a scene with constraints can be projected onto them");
  constexpr int m = Sc::constraints_at_compile_time;
  constexpr int most_iterations = 25;
  ProjectionReport report;
  const Vector<double, n> q_start = q;
  const Vector<double, n> qdot_start = qdot;

  Vector<double, m> phi = constraint_residual(scene, q, t, z);
  require_finite_rows(scene, t, phi);
  report.residual_before = report.residual = largest(phi);
  double last_change = std::numeric_limits<double>::infinity();
  const auto fail = [&](const char* what) {
    const Eigen::Index worst = place_of_largest(phi.data(), phi.size());
    const double most = std::abs(phi[worst]);
    const std::string row = constraint_names(scene)[static_cast<std::size_t>(worst)];
    throw ConstraintError(row, t, most,
                          sentence({"a state must be near enough to the constraints to be projected onto them, but at t = ", {t, 6}, " ", what,
                                            "; '", row, "' is off by ", {most, 6},
                                            "; start nearer, or check that the constraints can be met together"}));
  };
  ConstraintGeometry<Sc> geometry(scene, t, cutoff, traced);
  constexpr double nearby = 1e-8, negligible = 1e-3 * std::numeric_limits<double>::epsilon();
  double distance = std::numeric_limits<double>::infinity();  // of q from where geometry is, relative as `change`
  const auto factor_here = [&] {
    geometry.move_to(q, qdot, z);
    distance = 0.0;
  };
  // Changes count beside the coordinates, or beside 1 where these are zero; in a row whose coordinates are all small, beside its own terms.
  Vector<double, m> terms = Vector<double, m>::Zero(phi.size());
  bool is_small = false;
  const auto measure = [&] {
    Vector<double, n> sizes(q.size());
    for (Eigen::Index j = 0; j < q.size(); ++j) sizes[j] = std::abs(q[j]);
    for (Eigen::Index i = 0; i < phi.size(); ++i) {
      terms[i] = geometry.reach(i, sizes);
      if (terms[i] > 0.0) terms[i] = std::max(terms[i], projection_limits::rounding_of_zero * geometry.length(i));  // below are roundings of what is zero
      is_small = is_small || (terms[i] > 0.0 && terms[i] < projection_limits::small_part * geometry.length(i));
    }
    is_small = is_small && !geometry.has_dependent_rows();  // dependent rows keep residuals of rounding size
  };
  // Rows that depend on each other share what is asked of them, so a friction beside a wall would hold half of what the wall takes back.
  bool of_positions = false;
  const auto factor_for_positions = [&] {
    if (!of_positions) factor_here();
    if constexpr (has_velocity_rows<Sc>) {
      of_positions = of_positions || geometry.has_dependent_rows();
      if (!of_positions) return;
      const Vector<double, m> kept = position_rows(scene, q, t, z);
      geometry.move_to(q, qdot, z, &kept), distance = 0.0;
    }
  };
  while (report.residual > 0) {
    if (report.iterations == most_iterations) fail("Newton's method took 25 steps and did not arrive");
    const bool is_first = report.iterations == 0;
    if (!(distance <= nearby)) factor_for_positions();
    if (is_first) measure();
    const Vector<double, n> step = way_back(geometry, q, phi);
    ++report.iterations;
    double change = 0.0;  // relative to the size of each coordinate
    for (Eigen::Index i = 0; i < q.size(); ++i) change = std::max(change, std::abs(step[i]) / (1.0 + std::abs(q[i])));
    if (is_small) {
      Vector<double, n> sizes(q.size());
      for (Eigen::Index j = 0; j < q.size(); ++j) sizes[j] = std::abs(step[j]);
      for (Eigen::Index i = 0; i < phi.size(); ++i)
        if (terms[i] > 0.0) change = std::max(change, geometry.reach(i, sizes) / terms[i]);
    }
    if (!all_finite(step)) fail("a Newton step is not finite");
    for (Eigen::Index i = 0; i < q.size(); ++i) q[i] += step[i];
    distance += change;
    phi = constraint_residual(scene, q, t, z);
    require_finite_rows(scene, t, phi);
    const double residual = largest(phi);
    const bool at_rounding = change < projection_limits::at_rounding;
    const bool no_better = change < projection_limits::may_stand_still && change > 0.5 * last_change;
    // Small coordinates may belong to a row with terms of ordinary size, (x − 1)² at x = 0: its rounding asks for steps that do not shrink.
    const bool stands_still = report.iterations > 3 && change < 1e-6 && change > 0.5 * last_change && [&] {
      const double size = 4 * std::numeric_limits<double>::epsilon() * (1.0 + q.cwiseAbs().maxCoeff());
      for (Eigen::Index i = 0; i < phi.size(); ++i)
        if (!(std::abs(phi[i]) <= size * geometry.length(i))) return false;
      return true;
    }();
    is_small = is_small && !stands_still;
    if (at_rounding || no_better || stands_still) {
      report.residual = residual;
      break;
    }
    if (report.iterations > 6 && change > 0.9 * last_change && change > 1e-6) fail("Newton's steps do not shrink");
    last_change = change;
    report.residual = residual;
  }

  if (of_positions || !(distance <= nearby)) factor_here();
  geometry.require_finite();
  Vector<double, m> length(phi.size());
  for (Eigen::Index i = 0; i < phi.size(); ++i) length[i] = geometry.length(i);
  // A Newton iteration that stands still on contradicting rows has not arrived.
  constexpr double arrived = 1e-8;
  is_small = is_small && !geometry.has_dependent_rows();
  const auto is_off = [&](Eigen::Index i, double size, double own) {
    if (is_small && own > 0.0) return std::abs(phi[i]) > arrived * own;
    return std::abs(phi[i]) > arrived * (length[i] * (1.0 + size) + (length[i] < 1e-12 ? 1.0 : 0.0));
  };
  const double size_of_q = largest(q), size_of_qdot = largest(qdot_start);
  for (Eigen::Index i = 0; i < phi.size(); ++i)
    if (is_off(i, size_of_q, terms[i]))
      fail("no state satisfies all of them");
  report.rank = geometry.rank();
  phi = constraint_velocity(scene, q, qdot, t, z);
  Vector<double, n> speed(q.size());
  for (Eigen::Index i = 0; i < q.size(); ++i) speed[i] = std::abs(qdot[i]);
  double reach = 0.0;
  for (Eigen::Index i = 0; i < phi.size(); ++i) reach = std::max(reach, geometry.reach(i, speed));
  if (distance * largest(phi) > negligible * reach) factor_here();
  for (Eigen::Index i = 0; i < phi.size(); ++i) phi[i] = -phi[i];
  const Vector<double, m> before = phi;
  const Vector<double, n> change_of_qdot = geometry.displacement(phi);
  for (Eigen::Index i = 0; i < q.size(); ++i) qdot[i] += change_of_qdot[i];
  phi = constraint_velocity(scene, q, qdot, t, z);
  require_finite_rows(scene, t, phi);
  report.velocity_residual = largest(phi);
  Vector<double, m> own(phi.size());  // sizes of the terms of each row
  for (Eigen::Index i = 0; i < phi.size(); ++i) own[i] = geometry.reach(i, speed) + std::abs(before[i]);
  const double rounding_of_others = 1e-6 * largest(own);
  for (Eigen::Index i = 0; i < phi.size(); ++i)
    if (is_off(i, size_of_qdot, std::max(own[i], rounding_of_others))) fail("no velocity satisfies all of them");
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    report.moved_q = std::max(report.moved_q, std::abs(q[i] - q_start[i]));
    report.moved_qdot = std::max(report.moved_qdot, std::abs(qdot[i] - qdot_start[i]));
  }
  return report;
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
