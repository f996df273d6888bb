#pragma once
// SPDX-License-Identifier: MIT
//
// What one asks a scene at a State, the three things (t, q, q̇) that a run hands out as one:
//
//     const State<2> s = run.trajectory.at(1.5);
//     energy(scene, s), power(scene, s), reactions(scene, s), acceleration_jacobian(scene, s)
//
// Systems, which are scenes without effects, have the same functions; their power and reactions are zero. The effects' own states z are
// no part of a State: they have their initial values unless they are given after it. Contacts and dry friction are in the phases that
// fit the state; one that is being hit counts as open, since the blow is still to come. Where more than one choice fits, z decides:
//
//     acceleration(scene, s, EffectStates<…>(run.trajectory.y(1.5).tail(k)))       in the phases that the run was in, of k own states
//
// Inverse dynamics is the question turned round: which forces does a wanted motion q(t) need beyond those of the scene?
// F = M q̈ − rhs − Σ Q is zero on a motion that is free. Where there are constraints, they and the drives must give F together; of that,
// JᵀΛ with any Λ is the constraints' to bear.

#include <Eigen/Core>

#include "qdot/effects/equations/scene_jacobian.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/effects/scene_motion.hpp"
#include "qdot/mechanics/acceleration_jacobian.hpp"
#include "qdot/mechanics/energy.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"

namespace qdot {

namespace detail {

template <class Sys, class... Effects>
EffectStates<Scene<Sys, Effects...>> states_at(const Scene<Sys, Effects...>& scene, const State<Sys::dof_at_compile_time>& state) {
  require_sizes(scene, state.q, state.qdot);
  return states_at(scene, Coordinates<Sys>(state.q), Coordinates<Sys>(state.qdot), state.t);
}

}  // namespace detail

/// q̈ of a scene and its exact derivatives with respect to q and q̇ (n×n each), the effects' own states held.
///
/// On constraints: of q̈ as J q̈ = γ and M q̈ = rhs + ΣQ + Jᵀλ give it for any q and q̇, also for such as leave the constraints.
/// Allocates. Cost: that of the Jacobian that the stiff methods use.
///
/// @throws NonFinite  when a derivative is not finite there
template <class Sys, class... Effects>
AccelerationJacobian<Sys::dof_at_compile_time> acceleration_jacobian(const Scene<Sys, Effects...>& scene, const Coordinates<Sys>& q,
                                                                     const Coordinates<Sys>& qdot, double t,
                                                                     const EffectStates<Scene<Sys, Effects...>>& z) {
  if constexpr (sizeof...(Effects) == 0) {
    return acceleration_jacobian(scene.system(), q, qdot, t);
  } else {
    detail::require_sizes(scene, q, qdot);
    const SceneForm<Scene<Sys, Effects...>> form(scene);
    const Eigen::Index n = q.size();
    Eigen::VectorXd y(form.size());
    y << q, qdot, z;
    Eigen::MatrixXd J(form.size(), form.size());
    form.jacobian(t, y, J);
    return {acceleration(scene, q, qdot, t, z), J.block(n, 0, n, n), J.block(n, n, n, n)};
  }
}
template <class Sys, class... Effects>
AccelerationJacobian<Sys::dof_at_compile_time> acceleration_jacobian(const Scene<Sys, Effects...>& scene, const Coordinates<Sys>& q,
                                                                     const Coordinates<Sys>& qdot, double t = 0.0) {
  return acceleration_jacobian(scene, q, qdot, t, detail::states_at(scene, q, qdot, t));
}

/// The forces M q̈ − rhs − ΣQ that a motion needs beyond those of the scene, n (inverse dynamics); what its constraints bear is in them.
///
/// First derivatives only: no mass matrix is formed.
///
/// @param qddot  the wanted accelerations, n
/// @throws DimensionError  when n is known at run time and a size disagrees
template <class Sys, class... Effects>
Coordinates<Sys> inverse_dynamics(const Scene<Sys, Effects...>& scene, const Coordinates<Sys>& q, const Coordinates<Sys>& qdot, const Coordinates<Sys>& qddot,
                                  double t, const EffectStates<Scene<Sys, Effects...>>& z) {
  Coordinates<Sys> F = inverse_dynamics(scene.system(), q, qdot, qddot, t);
  if constexpr (Scene<Sys, Effects...>::has_forces) F -= effect_forces(scene, q, qdot, z, t);
  return F;
}
template <class Sys, class... Effects>
Coordinates<Sys> inverse_dynamics(const Scene<Sys, Effects...>& scene, const Coordinates<Sys>& q, const Coordinates<Sys>& qdot, const Coordinates<Sys>& qddot,
                                  double t = 0.0) {
  return inverse_dynamics(scene, q, qdot, qddot, t, detail::states_at(scene, q, qdot, t));
}

/// q̈ of a scene at a State, with the effects' own states z, n.
template <class Sys, class... Effects>
Coordinates<Sys> acceleration(const Scene<Sys, Effects...>& scene, const State<Sys::dof_at_compile_time>& state,
                              const EffectStates<Scene<Sys, Effects...>>& z) {
  detail::require_sizes(scene, state.q, state.qdot);
  return acceleration(scene, state.q, state.qdot, state.t, z);
}
/// Generalized forces of a scene without its constraints at a State, with z, n.
template <class Sys, class... Effects>
Coordinates<Sys> rhs(const Scene<Sys, Effects...>& scene, const State<Sys::dof_at_compile_time>& state, const EffectStates<Scene<Sys, Effects...>>& z) {
  detail::require_sizes(scene, state.q, state.qdot);
  return rhs(scene, state.q, state.qdot, state.t, z);
}
/// q̈ of a scene and its derivatives at a State, with z.
template <class Sys, class... Effects>
AccelerationJacobian<Sys::dof_at_compile_time> acceleration_jacobian(const Scene<Sys, Effects...>& scene, const State<Sys::dof_at_compile_time>& state,
                                                                     const EffectStates<Scene<Sys, Effects...>>& z) {
  return acceleration_jacobian(scene, state.q, state.qdot, state.t, z);
}
/// Forces M q̈ − rhs − ΣQ of a motion of a scene at a State, with z, n.
template <class Sys, class... Effects>
Coordinates<Sys> inverse_dynamics(const Scene<Sys, Effects...>& scene, const State<Sys::dof_at_compile_time>& state, const Coordinates<Sys>& qddot,
                                  const EffectStates<Scene<Sys, Effects...>>& z) {
  detail::require_sizes(scene, state.q, state.qdot);
  return inverse_dynamics(scene, state.q, state.qdot, qddot, state.t, z);
}
/// Generalized reaction forces Jᵀλ of a scene at a State, with z, n.
template <class Sys, class... Effects>
Coordinates<Sys> reactions(const Scene<Sys, Effects...>& scene, const State<Sys::dof_at_compile_time>& state, const EffectStates<Scene<Sys, Effects...>>& z) {
  detail::require_sizes(scene, state.q, state.qdot);
  return reactions(scene, state.q, state.qdot, state.t, z);
}
/// Power q̇·(ΣQ + Jᵀλ) of a scene at a State, with z.
template <class Sys, class... Effects>
double power(const Scene<Sys, Effects...>& scene, const State<Sys::dof_at_compile_time>& state, const EffectStates<Scene<Sys, Effects...>>& z) {
  detail::require_sizes(scene, state.q, state.qdot);
  return power(scene, state.q, state.qdot, state.t, z);
}

// Old names, accepted until 0.4.

/// inverse_dynamics() by its old name.
template <class Sys, class... Effects>
[[deprecated("qdot: say inverse_dynamics()")]]
Coordinates<Sys> motion_residual(const Scene<Sys, Effects...>& scene, const Coordinates<Sys>& q, const Coordinates<Sys>& qdot, const Coordinates<Sys>& qddot,
                                 double t, const EffectStates<Scene<Sys, Effects...>>& z) {
  return inverse_dynamics(scene, q, qdot, qddot, t, z);
}
template <class Sys, class... Effects>
[[deprecated("qdot: say inverse_dynamics()")]]
Coordinates<Sys> motion_residual(const Scene<Sys, Effects...>& scene, const Coordinates<Sys>& q, const Coordinates<Sys>& qdot, const Coordinates<Sys>& qddot,
                                 double t = 0.0) {
  return inverse_dynamics(scene, q, qdot, qddot, t);
}
template <class Sys, class... Effects>
[[deprecated("qdot: say inverse_dynamics()")]]
Coordinates<Sys> motion_residual(const Scene<Sys, Effects...>& scene, const State<Sys::dof_at_compile_time>& state, const Coordinates<Sys>& qddot,
                                 const EffectStates<Scene<Sys, Effects...>>& z) {
  return inverse_dynamics(scene, state, qddot, z);
}

}  // namespace qdot
