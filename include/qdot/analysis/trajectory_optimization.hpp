#pragma once
// SPDX-License-Identifier: MIT
//
// Optimal motions: the cheapest way from one state to another with the inputs that there are
// ==========================================================================================
//
//     min  ∫ ℓ(q, q̇, u, t) dt + Φ(q, q̇, t) at the end        over inputs u(t) within bounds (effects/input.hpp), in a given or free time
//
//     const auto cart = scene(mechanical_system<2>(CartPole{}), input("motor", 0));
//     const auto swing = trajectory_optimization(cart, {.start = {0.0, {0, 0}, {0, 0}}, .end = {2.0, {1, pi}, {0, 0}}, .bounds = {{"motor", -20, 20}}},
//                                                least_integral([](const auto&, const auto&, const auto& u) { return u[0] * u[0]; }));
//
// Ipopt solves a sparse program by collocation on a mesh (analysis/optimal/collocation.hpp), with exact first and
// second derivatives. Then the motion is run, and the mesh refined until the run agrees (analysis/optimal/search.hpp).
// What is found is a local optimum near the guess; of paths t ↦ q the straight line, if none is given. Conditions that
// no motion meets are named, with what comes nearest. Link qdot::optimal, and solve in one thread at a time: Ipopt's
// linear solver may not be reentrant.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "qdot/ad/forward/functor_result.hpp"
#include "qdot/analysis/action.hpp"
#include "qdot/analysis/optimal/collocation.hpp"
#include "qdot/analysis/optimal/controlled.hpp"
#include "qdot/analysis/optimal/ipopt.hpp"
#include "qdot/analysis/optimal/search.hpp"
#include "qdot/effects/scene.hpp"
#include "qdot/error.hpp"

namespace qdot {

/// Bounds on an input, a coordinate or a velocity, by its name.
struct Bound {
  std::string name;  ///< as the system has it, or the input
  /// In the units of what is bounded.
  double least = -std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();
};

/// When a motion may end.
struct EndTimes {
  double earliest = 0.0, latest = 0.0;  ///< both after the start
};

/// What is asked of a motion.
template <int n>
struct OptimalTask {
  State<n> start;                             ///< where and when it begins
  State<n> end;                               ///< where and when it ends; with `times`, when it may be expected to
  std::vector<std::string> free_at_end = {};  ///< coordinates and velocities that may be anything there
  std::optional<EndTimes> times = {};         ///< the end is free within them
  std::vector<Bound> bounds = {};             ///< all along the way
};

/// An optimal motion, or how far the search for it came.
///
/// @tparam n  number of coordinates, or Dynamic
template <int n = Dynamic>
struct OptimalTrajectory : OptimalEnd {
  double t_end = 0.0;                          ///< when it ends
  std::vector<Eigen::MatrixXd> stage_inputs;   ///< of each interval, a column for each stage
  Eigen::VectorXd least_input, most_input, c;  ///< bounds, and places of the stages within an interval

  /// The inputs at a time, in the order of the scene.
  ///
  /// @throws InvalidValue  when t is not between the start and the end, or no motion was found
  Eigen::VectorXd input(double time) const {
    const std::size_t k = leg(time);
    Eigen::VectorXd u = detail::interpolated(c, stage_inputs[k], (time - t[k]) / (t[k + 1] - t[k]));
    for (Eigen::Index i = 0; i < u.size(); ++i) u[i] = std::clamp(u[i], least_input[i], most_input[i]);
    return u;
  }

  /// The state at a time, by the run of the whole motion with these inputs.
  ///
  /// @throws InvalidValue  as input()
  State<n> at(double time) const {
    const Eigen::VectorXd x = legs[leg(time)].trajectory.y(time);
    return State<n>{time, x.head(x.size() / 2), x.tail(x.size() / 2)};
  }

 private:
  std::size_t leg(double time) const {
    if (legs.empty() || !(time >= t.front() && time <= t.back()))
      detail::throw_invalid_value({"an optimal motion is asked between its start and its end, but t = ", time,
                                   legs.empty() ? " was asked where none was found; look at its outcome and message" : " is not; look at its t and t_end"});
    const auto after = std::upper_bound(t.begin(), t.end(), time) - t.begin();
    return std::min(static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - 1, 0)), legs.size() - 1);
  }
};

/// The cost ∫ ℓ dt + Φ. Made by least_integral().
template <class Running, class Final>
struct IntegralCost {
  Running l;  ///< of (q, q̇, u) or (q, q̇, u, t)
  Final phi;  ///< of (q, q̇) or (q, q̇, t), at the end

  /// ℓ.
  template <int n, class S, int m>
  S running(const Vector<S, n>& q, const Vector<S, n>& qdot, const Vector<S, m>& u, const S& t) const {
    using V = Vector<S, n>;
    if constexpr (detail::is_callable<const Running&, const V&, const V&, const Vector<S, m>&, const S&>) return S(l(q, qdot, u, t));
    else return S(l(q, qdot, u));
  }
  /// Φ.
  template <int n, class S>
  S at_end(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    if constexpr (detail::is_callable<const Final&, const Vector<S, n>&, const Vector<S, n>&, const S&>) return S(phi(q, qdot, t));
    else return S(phi(q, qdot));
  }
};

/// The cost ∫ ℓ(q, q̇, u) dt + Φ(q, q̇), generic functions; both may take the time as well.
template <class Running, class Final>
IntegralCost<Running, Final> least_integral(Running l, Final phi) {
  return {std::move(l), std::move(phi)};
}

namespace detail {

struct NoCost {
  template <class V>
  auto operator()(const V& q, const V&) const {
    return typename V::Scalar(0.0 * q[0]);
  }
};

}  // namespace detail

/// The cost ∫ ℓ(q, q̇, u) dt.
template <class Running>
IntegralCost<Running, detail::NoCost> least_integral(Running l) {
  return {std::move(l), {}};
}

/// The time of the end as the cost.
struct MinimumTime {
  /// Zero.
  template <int n, class S, int m>
  S running(const Vector<S, n>&, const Vector<S, n>&, const Vector<S, m>&, const S&) const {
    return S(0.0);
  }
  /// t.
  template <int n, class S>
  S at_end(const Vector<S, n>&, const Vector<S, n>&, const S& t) const {
    return t;
  }
};
/// The shortest time as the aim.
inline MinimumTime minimum_time() { return {}; }

namespace detail {

[[gnu::cold, gnu::noinline]] inline Eigen::Index place_of(const Controlled& of, const std::string& name, bool with_inputs) {
  std::string known;
  for (Eigen::Index i = 0; i < of.states() + (with_inputs ? of.inputs() : 0); ++i) {
    const std::string each = i < of.states() ? of.state_name(i) : of.input_name(i - of.states());
    if (each == name) return i;
    known += (known.empty() ? "" : ", ") + each;
  }
  throw_invalid_value({"trajectory_optimization: a bound or a free end must be that of something in the scene, but there is no '", name, "'; there are ",
                       known});
}

template <class = void>  // compiled only where it is called
ControlTask control_task(const Controlled& of, double t_a, double t_b, const std::optional<EndTimes>& times, const Eigen::VectorXd& start,
                         const Eigen::VectorXd& end, const std::vector<std::string>& free_at_end, const std::vector<Bound>& bounds,
                         const OptimalOptions& options) {
  require_duration("trajectory_optimization", t_a, t_b);
  if (options.intervals < 1 || options.stages < 1 || options.stages > 8 || !(options.tolerance > 0.0) || options.most_iterations < 1 ||
      options.most_refinements < 0)
    throw_invalid_value({"trajectory_optimization: there must be at least 1 interval, 1 to 8 stages and 1 iteration, and a positive tolerance, but there are ",
                         options.intervals, ", ", options.stages, ", ", options.most_iterations, " and ", options.tolerance,
                         "; leave them out for the defaults"});
  const EndTimes range = times.value_or(EndTimes{t_b, t_b});
  if (!(range.earliest > t_a && range.earliest <= t_b && t_b <= range.latest))
    throw_invalid_value({"trajectory_optimization: the end must be expected within its times and behind the start, but it is t = ", t_b, ", between ",
                         range.earliest, " and ",
                         range.latest, "; give end.t a time between them"});
  const Eigen::Index N = of.states(), m = of.inputs();
  ControlTask task{&of, t_a, range.earliest, range.latest};
  task.start = start;
  std::vector<bool> is_free(static_cast<std::size_t>(N), false);
  for (const std::string& name : free_at_end) is_free[static_cast<std::size_t>(place_of(of, name, false))] = true;
  task.scale = Eigen::VectorXd::Ones(N);
  task.target.resize(N);
  for (Eigen::Index i = 0; i < N; ++i) {
    if (!std::isfinite(start[i]) || !std::isfinite(end[i]))
      throw_invalid_value({"trajectory_optimization: both ends must be finite, but ", of.state_name(i), " goes from ", start[i], " to ", end[i],
                           "; give every entry a number, also those that are free"});
    if (is_free[static_cast<std::size_t>(i)]) continue;
    task.target[static_cast<Eigen::Index>(task.held.size())] = end[i];
    task.held.push_back(i);
    if (end[i] != start[i]) task.scale[i] = std::abs(end[i] - start[i]);
  }
  task.target.conservativeResize(static_cast<Eigen::Index>(task.held.size()));
  task.lower = Eigen::VectorXd::Constant(N + m, -std::numeric_limits<double>::infinity());
  task.upper = -task.lower;
  for (const Bound& bound : bounds) {
    const Eigen::Index i = place_of(of, bound.name, true);
    if (!(bound.least < bound.most))
      throw_invalid_value({"trajectory_optimization: a bound must leave room, but that of ", bound.name, " goes from ", bound.least, " to ", bound.most,
                           "; give the smaller one first"});
    task.lower[i] = bound.least;
    task.upper[i] = bound.most;
    for (const bool at_start : {true, false}) {
      if (i >= N || (!at_start && is_free[static_cast<std::size_t>(i)])) continue;
      const double x = at_start ? start[i] : end[i];
      if (!(x >= bound.least && x <= bound.most))
        throw_invalid_value({"trajectory_optimization: ", at_start ? "the start" : "the end", " must lie within the bounds, but ", bound.name, " is ", x,
                             " there, not between ",
                             bound.least, " and ", bound.most, "; move it, or widen the bound"});
    }
  }
  return task;
}

// @param on_path  x of the guess at a time
template <class = void>  // compiled only where it is called
ControlMesh control_guess(const ControlTask& task, double t_b, const OptimalOptions& options,
                          const std::function<Eigen::VectorXd(double)>& on_path) {
  const Eigen::Index N = task.of->states(), m = task.of->inputs(), K = options.intervals;
  const GaussTable table(options.stages);
  ControlMesh mesh;
  mesh.t_b = t_b;
  mesh.x.resize(N, K + 1);
  const auto at = [&](double part) { return on_path(part == 1.0 ? t_b : task.t_a + part * (t_b - task.t_a)); };
  for (Eigen::Index k = 0; k <= K; ++k) mesh.x.col(k) = at(static_cast<double>(k) / static_cast<double>(K));
  for (Eigen::Index k = 0; k < K; ++k) {
    mesh.part.push_back(1.0 / static_cast<double>(K));
    Eigen::MatrixXd stages(N + m, options.stages);
    for (Eigen::Index j = 0; j < stages.cols(); ++j) {
      const Eigen::VectorXd x = at((static_cast<double>(k) + table.c[j]) / static_cast<double>(K));
      stages.col(j) << x, Eigen::VectorXd::Zero(m);
      for (Eigen::Index i = 0; i < N + m; ++i) stages(i, j) = std::clamp(stages(i, j), task.lower[i], task.upper[i]);
    }
    mesh.stages.push_back(std::move(stages));
  }
  return mesh;
}

template <class Sc, class Cost>
auto optimal_trajectory_of(const Sc& scene, const OptimalTask<Sc::dof_at_compile_time>& task, const Cost& cost, const OptimalOptions& options,
                           const std::function<Eigen::VectorXd(double)>& on_path) {
  constexpr int n = Sc::dof_at_compile_time;
  require_sizes(scene, task.start.q, task.start.qdot);
  require_sizes(scene, task.end.q, task.end.qdot);
  const ControlledScene<Sc, Cost> controlled(scene, cost);
  Eigen::VectorXd start(2 * scene.dof()), end(2 * scene.dof());
  start << task.start.q, task.start.qdot;
  end << task.end.q, task.end.qdot;
  const ControlTask erased = control_task(controlled, task.start.t, task.end.t, task.times, start, end, task.free_at_end, task.bounds, options);
  const double t_a = task.start.t, t_b = task.end.t;
  const auto straight = [&](double t) -> Eigen::VectorXd { return start + (t - t_a) / (t_b - t_a) * (end - start); };
  OptimalSearchEnd found = OptimalSearch<>(erased, options, solved_by_ipopt<>).end(control_guess(erased, t_b, options, on_path ? on_path : straight));
  OptimalTrajectory<n> result;
  static_cast<OptimalEnd&>(result) = std::move(found);
  if (result.outcome != OptimalOutcome::solved && result.outcome != OptimalOutcome::not_accurate) result.legs.clear();
  result.t_end = found.mesh.t_b;
  for (const Eigen::MatrixXd& stages : found.mesh.stages) result.stage_inputs.push_back(stages.bottomRows(controlled.inputs()));
  result.least_input = erased.lower.tail(controlled.inputs());
  result.most_input = erased.upper.tail(controlled.inputs());
  result.c = GaussTable(options.stages).c;
  return result;
}

}  // namespace detail

/// The motion of a scene with inputs from a state to another at the least cost, near the straight line between them.
///
/// For each iteration on a mesh of K intervals and s stages, K s times the slopes and the curvature of the scene, and a sparse
/// factorization. Slopes and curvature are (2n + m + 1)(2n + m + 4)/2 evaluations of T, V and effects on duals of duals.
///
/// @param scene  whose effects have no states but inputs, and without constraints
/// @param cost   minimum_time(), least_integral(ℓ) or least_integral(ℓ, Φ)
/// @return       the motion, its inputs and errors, or how far the search came, with a named outcome
/// @throws       InvalidValue for ends outside of bounds, unknown names, times in the wrong order; DimensionError
template <class Sys, class... Effects, class Cost>
OptimalTrajectory<Sys::dof_at_compile_time> trajectory_optimization(const Scene<Sys, Effects...>& scene, const OptimalTask<Sys::dof_at_compile_time>& task,
                                                                    const Cost& cost,
                                                                    const OptimalOptions& options = {}) {
  return detail::optimal_trajectory_of(scene, task, cost, options, {});
}

/// The optimal motion near a path t ↦ q, generic in t.
template <class Sys, class... Effects, class Cost, class Path>
  requires(!std::is_same_v<Path, OptimalOptions>)
OptimalTrajectory<Sys::dof_at_compile_time> trajectory_optimization(const Scene<Sys, Effects...>& scene, const OptimalTask<Sys::dof_at_compile_time>& task,
                                                                    const Cost& cost,
                                                                    const Path& guess, const OptimalOptions& options = {}) {
  return detail::optimal_trajectory_of(scene, task, cost, options, [&](double t) {
    const auto state = detail::state_on_path<Sys::dof_at_compile_time>(guess, t, scene.dof());
    Eigen::VectorXd x(2 * scene.dof());
    x << state.q, state.qdot;
    return x;
  });
}

// Old names, accepted until 0.4.

template <int n = Dynamic>
using OptimalMotion [[deprecated("qdot: say OptimalTrajectory")]] = OptimalTrajectory<n>;
using LeastTime [[deprecated("qdot: say MinimumTime")]] = MinimumTime;

/// minimum_time() by its old name.
[[deprecated("qdot: say minimum_time()")]] inline MinimumTime least_time() { return {}; }

/// trajectory_optimization() by its old name.
template <class Sys, class... Effects, class Cost>
[[deprecated("qdot: say trajectory_optimization()")]]
OptimalTrajectory<Sys::dof_at_compile_time> optimal_motion(const Scene<Sys, Effects...>& scene, const OptimalTask<Sys::dof_at_compile_time>& task,
                                                           const Cost& cost, const OptimalOptions& options = {}) {
  return trajectory_optimization(scene, task, cost, options);
}
template <class Sys, class... Effects, class Cost, class Path>
  requires(!std::is_same_v<Path, OptimalOptions>)
[[deprecated("qdot: say trajectory_optimization()")]]
OptimalTrajectory<Sys::dof_at_compile_time> optimal_motion(const Scene<Sys, Effects...>& scene, const OptimalTask<Sys::dof_at_compile_time>& task,
                                                           const Cost& cost, const Path& guess, const OptimalOptions& options = {}) {
  return trajectory_optimization(scene, task, cost, guess, options);
}

}  // namespace qdot
