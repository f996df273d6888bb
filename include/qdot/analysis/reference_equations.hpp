#pragma once
// SPDX-License-Identifier: MIT
//
// The equations of motion in any scalar, as ẏ = f(t, y).
//
// The forms that steppers see (FirstOrderForm, SceneForm) speak double, because steppers do. A reference wants more digits. The
// energies do not mind, being written for any scalar, and neither do effects that are forces:
//
//     y = [q; q̇; z],      q̈ = M⁻¹ (rhs + Σ Q(q, q̇, z, t)),      ż = the effects' own rates.
//
// Constraints are left out: the rank decisions of their solution are made for double.

#include <type_traits>

#include "qdot/effects/scene_motion.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"

namespace qdot::detail {

// Scenes whose equations hold in any scalar.
template <class Sys>
struct has_any_scalar : std::true_type {};
template <class Sys, class... Effects>
struct has_any_scalar<Scene<Sys, Effects...>> : std::bool_constant<!Scene<Sys, Effects...>::has_constraints> {};

// ydot ← f(t, y) of a system.
template <class E, int n, Inertia inertia, class S>
void write_derivative(const System<E, n, inertia>& system, const S& t, const Vector<S, Dynamic>& y, Vector<S, Dynamic>& ydot) {
  const Eigen::Index k = system.dof();
  const Vector<S, n> q = y.head(k), qdot = y.tail(k);
  ydot.head(k) = qdot;
  ydot.tail(k) = acceleration(system, q, qdot, t);
}

// ydot ← f(t, y) of a scene without constraints.
template <class Sys, class... Effects, class S>
  requires has_any_scalar<Scene<Sys, Effects...>>::value
void write_derivative(const Scene<Sys, Effects...>& scene, const S& t, const Vector<S, Dynamic>& y, Vector<S, Dynamic>& ydot) {
  using Sc = Scene<Sys, Effects...>;
  constexpr int n = Sc::dof_at_compile_time, states = Sc::states_at_compile_time;
  const Eigen::Index k = scene.dof();
  const Vector<S, n> q = y.head(k), qdot = y.segment(k, k);
  const Vector<S, states> z = y.tail(states);
  ydot.head(k) = qdot;
  if constexpr (Sc::has_forces) {
    const Matrix<S, n> M = mass_matrix(scene.system(), q, qdot, t);
    const Vector<S, n> force = rhs(scene.system(), q, qdot, t) + effect_forces(scene, q, qdot, z, t);
    ydot.segment(k, k) = solved_with_mass_matrix(scene.system(), M, force, t);
  } else {
    ydot.segment(k, k) = acceleration(scene.system(), q, qdot, t);
  }
  if constexpr (Sc::has_states) ydot.tail(states) = state_rates(scene, q, qdot, z, t);
}

}  // namespace qdot::detail
