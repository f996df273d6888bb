#pragma once
// SPDX-License-Identifier: MIT
//
// Equilibria of scenes, and steady motions
// ========================================
//
//     ∂L/∂q + Q + Jᵀλ = 0 ,    φ(q) = 0           (q̇ = 0; and ż = 0 for the effects' own states)
//
// are the conditions of rest. A *steady motion*, or relative equilibrium, looks the same at all times: coordinates that
// nothing depends on turn at constant rates, and the others keep their values. A conical pendulum is one, a top that
// precesses regularly, a hoop that rolls straight on. There q̇ is the given vector of rates, and all of q̈ must vanish.
//
// Newton's method solves all equations at once with exact slopes (analysis/linear/rest_search.hpp). It goes to what is
// near, stable or not. What nothing depends on, such as the place of a cart, keeps the value that it started with.
// Contacts are closed where they bear something, and open elsewhere. Friction without a velocity sticks, so what it can
// hold rests where it is.

#include <optional>

#include "qdot/analysis/equilibrium.hpp"
#include "qdot/analysis/linear/flow.hpp"
#include "qdot/analysis/linear/rest_search.hpp"
#include "qdot/effects/scene_motion.hpp"

namespace qdot {

/// A state of a scene at which nothing changes but cyclic coordinates.
template <class Sc>
struct SteadyState {
  State<Sc::dof_at_compile_time> state;  ///< q, the rates q̇, and the time that was fixed
  EffectStates<Sc> z;                    ///< of effects with states of their own
  Vector<double, Sc::constraints_at_compile_time>
      lambda;                  ///< multipliers; the shortest ones where constraints are redundant
  Eigen::Index redundant = 0;  ///< rows of constraints that repeat others
};

namespace detail {

// In the phases that the search comes to. Contacts that would be penetrated are closed, those that would pull are opened, and where nothing can rest
// the nearest one is closed.
template <class Sc>
Eigen::VectorXd steady_state_in_phases(const Sc& scene, const Flow& flow, const SteadySearch& search, const Coordinates<Sc>& q, const Coordinates<Sc>& qdot) {
  const PhasesAtState<Sc> phases(scene);
  const Eigen::Index n = scene.dof();
  EffectStates<Sc> z = phases.first_guess(0.0, q, qdot);
  std::optional<InvalidValue> first;
  for (int tries = 0; tries < 8 * static_cast<int>(Sc::phases_at_compile_time); ++tries) {
    Eigen::VectorXd y(flow.size());
    y << q, qdot, z;
    try {
      y = steady_state_near(flow, search, 0.0, y);
    } catch (const InvalidValue& error) {
      if (!first) first = error;
      if (!phases.close_nearest(0.0, q, z)) throw *first;
      continue;
    }
    EffectStates<Sc> found = y.tail(Sc::states_at_compile_time);
    if (!phases.revise(0.0, Coordinates<Sc>(y.head(n)), qdot, found)) return y;
    for (const Eigen::Index i : flow.phases()) z[i - 2 * n] = found[i - 2 * n];
  }
  throw_invalid_value({search.who, ": contacts must agree on where to rest, but each choice of closed and open leads to another one; start closer"});
}

template <class Sc>
SteadyState<Sc> steady_state_of(const Sc& scene, const Eigen::Ref<const Eigen::VectorXd>& q,
                                const Eigen::Ref<const Eigen::VectorXd>& qdot, const SteadySearch& search) {
  require_sizes(scene, q, qdot);
  const FlowOf<Sc> flow(scene);
  const Eigen::Index n = scene.dof();
  Eigen::VectorXd y(flow.size());
  if constexpr (Sc::has_phases) {
    y = steady_state_in_phases(scene, flow, search, q, qdot);
  } else {
    y << q, qdot, scene.initial_states();
    y = steady_state_near(static_cast<const Flow&>(flow), search, 0.0, y);
  }
  SteadyState<Sc> found{{0.0, y.head(n), y.segment(n, n)}, y.tail(Sc::states_at_compile_time), {}};
  if constexpr (Sc::has_constraints) {
    const auto solution = constrained_acceleration(scene, found.state.q, found.state.qdot, 0.0, found.z);
    found.lambda = solution.lambda;
    found.redundant = solution.lambda.size() - solution.rank;
  }
  return found;
}

}  // namespace detail

/// The equilibrium of a scene close to `start`; forces, constraints and controllers included.
///
/// @param start  q where to begin, n; it need not satisfy the constraints
/// @return       q with all accelerations zero to rounding, and the multipliers λ there
/// @throws       InvalidValue when there is none near, with the acceleration or constraint that is worst off; when something depends on the time
/// @throws       as acceleration() of the scene on the way: MassMatrixError, ConstraintError, NonFinite
template <class Sys, class... Effects, class Q>
SteadyState<Scene<Sys, Effects...>> equilibrium_near(const Scene<Sys, Effects...>& scene,
                                                     const Eigen::MatrixBase<Q>& start,
                                                     const EquilibriumOptions& options = {}) {
  return detail::steady_state_of(scene, start, Eigen::VectorXd::Zero(start.size()),
                                 {"equilibrium_near", options.max_iterations, options.tolerance});
}

/// The steady motion of a scene close to `start` in which coordinates turn at given rates.
///
/// @param start  q where to begin, n
/// @param rates  q̇, n: zero for each coordinate that keeps its value, the rate for each cyclic one that turns
/// @return       q with q̈ = 0, and the multipliers λ there
/// @throws       as equilibrium_near; and InvalidValue when something depends on a coordinate that turns
template <class Sys, class... Effects, class Q, class Rates>
SteadyState<Scene<Sys, Effects...>> steady_motion_near(const Scene<Sys, Effects...>& scene,
                                                       const Eigen::MatrixBase<Q>& start,
                                                       const Eigen::MatrixBase<Rates>& rates,
                                                       const EquilibriumOptions& options = {}) {
  return detail::steady_state_of(scene, start, rates,
                                 {"steady_motion_near", options.max_iterations, options.tolerance});
}

/// The steady motion of a system without effects.
template <class E, int n, Inertia inertia, class Q, class Rates>
SteadyState<Scene<System<E, n, inertia>>> steady_motion_near(const System<E, n, inertia>& system, const Eigen::MatrixBase<Q>& start,
                                                             const Eigen::MatrixBase<Rates>& rates,
                                                             const EquilibriumOptions& options = {}) {
  return steady_motion_near(scene(system), start, rates, options);
}

}  // namespace qdot
