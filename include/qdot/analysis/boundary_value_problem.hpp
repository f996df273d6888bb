#pragma once
// SPDX-License-Identifier: MIT
//
// The motion from one place to another in a given time
// ====================================================
//
//     q(t_a) = q_a ,   q(t_b) = q_b ,      δ ∫ L dt = 0        which q̇_a arrives?
//
//     const auto throw_ = boundary_value_problem(ball, Vector<double, 2>(0, 0), 0.0, Vector<double, 2>(10, 2), 1.5);
//     throw_.start.qdot, throw_.S, throw_.conjugate_points
//
// There may be several such motions, or none. Newton's method with multiple shooting (analysis/paths/search.hpp) finds
// one near a guess, a path t ↦ q; the straight line, if none is given. S is least of all paths near by only up to the
// first point conjugate to t_a (Jacobi). Each one after that adds its multiplicity to Morse's index, the number of
// independent changes of the path that lower S (analysis/paths/conjugate_points.hpp). Conjugate ends make Newton's
// equations singular. The outcome then is conjugate_ends. Constraints and forces that are not in L are refused.

#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "qdot/analysis/action.hpp"
#include "qdot/analysis/paths/conjugate_points.hpp"
#include "qdot/analysis/paths/quadrature.hpp"
#include "qdot/analysis/paths/search.hpp"
#include "qdot/analysis/sensitivity.hpp"
#include "qdot/effects/scene.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/mechanics/energy.hpp"

namespace qdot {

/// How a motion between two places is sought.
struct BoundaryValueOptions {
  int legs = 8;               ///< of multiple shooting; more where neighbours part quickly
  double tolerance = 1e-9;    ///< of the gaps between legs, as part of the extent of the path
  int most_iterations = 60;   ///< steps of Newton's method
  Options integration = {.rtol = 1e-11};  ///< of every run
};

/// A time at which neighbours of a motion meet it again that left its start with other velocities.
struct ConjugatePoint {
  double t = 0.0;        ///< when
  int multiplicity = 1;  ///< dimension of the kernel of ∂q(t)/∂q̇_a
};

/// A motion between two places, or how far the search came.
///
/// @tparam n  number of coordinates, or Dynamic
template <int n = Dynamic>
struct BoundaryValueSolution {
  BoundaryValueOutcome outcome = BoundaryValueOutcome::not_found;   ///< how the search ended
  std::string message;                                  ///< what was found or missed, with the numbers
  Outcome run_outcome = Outcome::completed;             ///< of the run that failed, if one did
  State<n> start;                                       ///< q_a and q̇_a
  Vector<double, n> residual;                           ///< q(t_b) − q_b of the run from there; empty where it did not arrive
  double S = std::numeric_limits<double>::quiet_NaN();  ///< ∫ L dt of that run; NaN where it did not arrive
  double S_error = 0.0;                                 ///< of the quadrature
  std::vector<ConjugatePoint> conjugate_points;         ///< between the ends, in the order of time
  int index = 0;                                        ///< Morse's index, the sum of their multiplicities
  Eigen::MatrixXd end_slope;                            ///< ∂q(t_b)/∂q̇_a, n×n
  int iterations = 0;                                   ///< steps of Newton's method
  Sensitivities<n> motion;                              ///< the run and its derivatives, dense in t

  /// Whether the motion arrives.
  bool found() const noexcept { return outcome == BoundaryValueOutcome::found; }

  /// The state at a time between the ends.
  ///
  /// @throws InvalidValue  when t is not, or where there is no run
  State<n> at(double t) const { return motion.at(t); }
};

namespace detail {

// ∂p/∂(q, q̇), n×2n.
template <class E, int n, Inertia inertia>
Eigen::MatrixXd momentum_slopes(const System<E, n, inertia>& system, const State<n>& at) {
  const Eigen::Index k = system.dof();
  Vector<double, n == Dynamic ? Dynamic : 2 * n> x(2 * k);
  x << at.q, at.qdot;
  return jacobian(marked<SlopeAlongPath>([&](const auto& y) {
    using D = typename std::remove_cvref_t<decltype(y)>::Scalar;
    const Vector<D, n> q = y.head(k), qdot = y.tail(k);
    return Vector<D, n>(conjugate_momenta(system, q, qdot, D(at.t)));
  }), x);
}

// Conjugate points of a run with its derivatives.
template <class Sys, int n>
std::vector<MeetingPoint> meeting_points(const Sys& system, const Sensitivities<n>& motion, double t_a, double t_b) {
  const Eigen::Index k = system.dof();
  const Eigen::MatrixXd first = momentum_slopes(system, motion.at(t_a));
  const Eigen::VectorXd unit = first.rightCols(k).diagonal().cwiseSqrt();
  const double duration = (t_b - t_a) / 3.0;
  const auto neighbours = [&](double t) {
    const Eigen::MatrixXd columns = motion.Phi_at(t).rightCols(k), momenta = momentum_slopes(system, motion.at(t)) * columns;
    return DeviationFrame{(unit / duration).asDiagonal() * columns.topRows(k), unit.cwiseInverse().asDiagonal() * momenta};
  };
  return MeetingPoints(neighbours, t_a, t_b).between(motion.run.trajectory.times());
}

[[gnu::cold, gnu::noinline]] inline std::string boundary_value_message(const BoundaryValueEnd& end, double t_b) {
  const std::string off = sentence({"it is off by ", {end.worst_gap, 3}, " in ", end.worst, " at t = ", {end.worst_t, 8}});
  switch (end.outcome) {
    case BoundaryValueOutcome::found: return sentence({"found: ", off});
    case BoundaryValueOutcome::conjugate_ends:
      return sentence({"boundary_value_problem: the ends must not be conjugate, but neighbours that leave the start with different velocities meet at t = ",
                       {t_b, 8},
                       ", so there is no motion to other places, or one of many; where the search ended, ", off, "; move an end, or t_b"});
    case BoundaryValueOutcome::not_found:
      return sentence({"boundary_value_problem: the legs must meet, but where the search ended, ", off,
                       "; give a path that is nearer to a motion, or ask whether there is one in this time"});
    default:
      return sentence({"boundary_value_problem: each leg must be a run to its end, but one failed: ", end.failed.message,
                       "; give a path that keeps away from there"});
  }
}

template <class = void>  // compiled only where it is called
void require_boundary_values(const BoundaryValueOptions& options, double t_a, double t_b) {
  require_duration("boundary_value_problem", t_a, t_b);
  if (options.legs < 1 || options.most_iterations < 1 || !(options.tolerance > 0.0))
    throw_invalid_value({"boundary_value_problem: legs and most_iterations must be at least 1, and the tolerance positive, but they are ", options.legs, ", ",
                         options.most_iterations, " and ", options.tolerance, "; leave them out for 8, 60 and 1e-9"});
}

// The path that is the straight line, for every scalar.
template <int n>
struct StraightPath {
  Vector<double, n> from, slope;
  double t_a;
  template <class S>
  Vector<S, n> operator()(const S& t) const {
    Vector<S, n> q(from.size());
    for (Eigen::Index i = 0; i < from.size(); ++i) q[i] = from[i] + slope[i] * (t - t_a);
    return q;
  }
};

}  // namespace detail

/// The motion of a system from q_a at t_a to q_b at t_b near a path.
///
/// For each step of Newton's method a run of size 2n (2n + 1) over the whole time, and one more that is kept.
///
/// @param q_a, q_b  the ends, n
/// @param guess     t ↦ q, generic; where it does not begin and end at q_a and q_b, these count
/// @return          the motion, its action and its conjugate points, or how far the search came, with a named outcome
/// @throws          InvalidValue when t_b is not later than t_a or an end is not finite; DimensionError
template <class E, int n, class A, class B, class Path>
BoundaryValueSolution<n> boundary_value_problem(const System<E, n, Inertia::positive_definite>& system, const Eigen::MatrixBase<A>& q_a, double t_a,
                                                const Eigen::MatrixBase<B>& q_b, double t_b, const Path& guess, const BoundaryValueOptions& options = {}) {
  detail::require_boundary_values(options, t_a, t_b);
  detail::require_sizes(system, q_a, q_b);
  const Eigen::Index k = system.dof();
  for (Eigen::Index i = 0; i < k; ++i)
    if (!std::isfinite(q_a[i]) || !std::isfinite(q_b[i]))
      detail::throw_invalid_value({"boundary_value_problem: both ends must be finite, but ", system.coordinate_name(i), " goes from ", q_a[i], " to ", q_b[i],
                                   "; give every entry a number"});
  detail::BoundaryValueSearch search{detail::flow_in_pieces(system, Dop853{}, options.integration), {}};
  for (Eigen::Index i = 0; i < 2 * k; ++i) search.names.push_back(first_order_form(system).component_name(i));
  search.most_iterations = options.most_iterations;
  search.tolerance = options.tolerance;
  for (int i = 0; i <= options.legs; ++i) {
    search.t.push_back(i == options.legs ? t_b : t_a + (t_b - t_a) * i / options.legs);
    State<n> state = detail::state_on_path<n>(guess, search.t.back(), k);
    if (i == 0) state.q = q_a;
    if (i == options.legs) state.q = q_b;
    Eigen::VectorXd x(2 * k);
    x << state.q, state.qdot;
    search.x.push_back(std::move(x));
  }
  detail::BoundaryValueEnd end = detail::boundary_value_end(std::move(search));

  BoundaryValueSolution<n> result;
  result.outcome = end.outcome;
  result.iterations = end.iterations;
  result.message = detail::boundary_value_message(end, t_b);
  result.run_outcome = end.failed.outcome;
  result.start = State<n>{t_a, end.point.x[0].head(k), end.point.x[0].tail(k)};
  if (end.outcome == BoundaryValueOutcome::run_failed) return result;
  Options kept = options.integration;
  kept.keep_trajectory = true;
  result.motion = sensitivities(system, FirstOrderState{t_a, end.point.x[0]}, t_b, Dop853{}, kept);
  if (!result.motion.completed()) {
    result.outcome = BoundaryValueOutcome::run_failed;
    result.run_outcome = result.motion.outcome;
    result.message = "boundary_value_problem: the run from the start that was found must arrive, but ended early, " + result.motion.message;
    return result;
  }
  result.residual = result.motion.y.head(k) - q_b;
  result.end_slope = result.motion.Phi.topRightCorner(k, k);
  const std::vector<double> times = result.motion.run.trajectory.times();
  result.S = 0.0;
  for (std::size_t i = 0; i + 1 < times.size(); ++i) {  // a step is a polynomial
    const detail::Integral part = detail::integral_of([&](double t) {
      const State<n> at = result.motion.at(t);
      return static_cast<double>(lagrangian(system, at.q, at.qdot, t));
    }, times[i], times[i + 1], 1e-12, 100);
    result.S += part.value;
    result.S_error += part.error;
  }
  for (const detail::MeetingPoint& each : detail::meeting_points(system, result.motion, t_a, t_b)) {
    result.conjugate_points.push_back({each.t, each.multiplicity});
    result.index += each.multiplicity;
  }
  return result;
}

/// The motion between two places, searched for from the straight line.
template <class E, int n, class A, class B>
BoundaryValueSolution<n> boundary_value_problem(const System<E, n, Inertia::positive_definite>& system, const Eigen::MatrixBase<A>& q_a, double t_a,
                                                const Eigen::MatrixBase<B>& q_b, double t_b, const BoundaryValueOptions& options = {}) {
  detail::require_boundary_values(options, t_a, t_b);
  detail::require_sizes(system, q_a, q_b);
  return boundary_value_problem(system, q_a, t_a, q_b, t_b, detail::StraightPath<n>{q_a, (q_b - q_a) / (t_b - t_a), t_a}, options);
}

/// The motion between two places of a scene whose effects are terms in T and V.
template <class Sys, class... Effects, class A, class B, class... More>
BoundaryValueSolution<Sys::dof_at_compile_time> boundary_value_problem(const Scene<Sys, Effects...>& scene, const Eigen::MatrixBase<A>& q_a, double t_a,
                                                                       const Eigen::MatrixBase<B>& q_b, double t_b, const More&... more) {
  using Sc = Scene<Sys, Effects...>;
  static_assert(!Sc::has_forces && !Sc::has_constraints && !Sc::has_states,
                "qdot: the action is that of T and V: take boundary_value_problem(scene.system(), …), which knows no forces and constraints");
  return boundary_value_problem(scene.system(), q_a, t_a, q_b, t_b, more...);
}

// Old names, accepted until 0.4.

using BetweenOptions [[deprecated("qdot: say BoundaryValueOptions")]] = BoundaryValueOptions;
using BetweenOutcome [[deprecated("qdot: say BoundaryValueOutcome")]] = BoundaryValueOutcome;
template <int n = Dynamic>
using MotionBetween [[deprecated("qdot: say BoundaryValueSolution")]] = BoundaryValueSolution<n>;

/// boundary_value_problem() by its old name.
template <class E, int n, class A, class B, class Path>
[[deprecated("qdot: say boundary_value_problem()")]]
BoundaryValueSolution<n> motion_between(const System<E, n, Inertia::positive_definite>& system, const Eigen::MatrixBase<A>& q_a, double t_a,
                                        const Eigen::MatrixBase<B>& q_b, double t_b, const Path& guess, const BoundaryValueOptions& options = {}) {
  return boundary_value_problem(system, q_a, t_a, q_b, t_b, guess, options);
}
template <class E, int n, class A, class B>
[[deprecated("qdot: say boundary_value_problem()")]]
BoundaryValueSolution<n> motion_between(const System<E, n, Inertia::positive_definite>& system, const Eigen::MatrixBase<A>& q_a, double t_a,
                                        const Eigen::MatrixBase<B>& q_b, double t_b, const BoundaryValueOptions& options = {}) {
  return boundary_value_problem(system, q_a, t_a, q_b, t_b, options);
}
template <class Sys, class... Effects, class A, class B, class... More>
[[deprecated("qdot: say boundary_value_problem()")]]
BoundaryValueSolution<Sys::dof_at_compile_time> motion_between(const Scene<Sys, Effects...>& scene, const Eigen::MatrixBase<A>& q_a, double t_a,
                                                               const Eigen::MatrixBase<B>& q_b, double t_b, const More&... more) {
  return boundary_value_problem(scene, q_a, t_a, q_b, t_b, more...);
}

}  // namespace qdot
