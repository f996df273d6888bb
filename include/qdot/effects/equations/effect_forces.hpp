#pragma once
// SPDX-License-Identifier: MIT
//
// Σ Q of a scene's effects, and Σ (Q − ∂V/∂q) with the potentials that they add.
//
// Potentials of effects are a part of V, and what asks for energies or for the whole of the equations finds them there
// (effects/equations/energy_terms.hpp). But their forces can be found without the system's T and V: then the system keeps the equations that it has
// derived, and a spring-damper looks for its length once.

#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

#include "qdot/ad/derivatives.hpp"
#include "qdot/effects/equations/moving_points.hpp"
#include "qdot/effects/scene.hpp"

namespace qdot {

namespace detail {

#if defined(__clang__) && defined(__OPTIMIZE__)  // ad/forward/functor_result.hpp says why
#pragma clang attribute push(__attribute__((always_inline)), apply_to = function)
#endif

// −∂V/∂q of an effect's potential.
template <class E, class S, int n>
[[gnu::flatten]] Vector<S, n> force_of_potential(const E& e, const Vector<S, n>& q, const S& t) {
  if constexpr (moves_by_jets<S, n>) {
    Vector<S, n> Q = Vector<S, n>::Zero();
    ComponentMask present = 0;
    using Number = PositionJet<n>;
    add_gradient(Q, present, -1.0, Number(e.potential_term(MovingCoordinates<n>(q, q, t).q, Number(t))));
    return Q;
  } else {
    return -gradient(marked<SlopeOfEffect>([&](const auto& x) {
      using D = typename std::remove_cvref_t<decltype(x)>::Scalar;
      return D(e.potential_term(x, D(t)));
    }), q);
  }
}

// sum += Q, entry by entry where the compiler sees through: what it then has in registers is not to be read back as vectors.
template <class S, int n, class Force>
[[gnu::always_inline]] inline void add_entries(Vector<S, n>& sum, const Force& Q) {
  if constexpr (moves_by_jets<S, n> && std::is_same_v<Force, Vector<S, n>>) {
    unroll<n>([&](auto i) __attribute__((always_inline)) { sum[i] += Q[i]; });
  } else {
    sum += Q;
  }
}

// How to sum forces: as they are, without numbers that know how they move, with those of potentials, or without those whose slopes are known.
enum class ForceSum { plain, by_duals, with_potentials, unknown_slopes };

// An effect that adds ∂Q/∂(q, q̇) to rows itself, add_slopes(rows), in place of duals.
template <class E>
concept KnowsSlopes = requires(const E& e, double (*rows)[2]) { e.add_slopes(rows); };

// Effects are asked what their `Roles` say: their own types, or those of the same effects with plain numbers for recorded parameters.
template <ForceSum way, class... Roles, class Effects, class S, int n>
Vector<S, n> sum_over(const Effects& effects, const Vector<S, n>& q, const Vector<S, n>& qdot, const Vector<S, total<states_of<Roles>()...>()>& z, const S& t) {
  Vector<S, n> sum = Vector<S, n>::Zero(q.size());
  Eigen::Index first = 0;
  const auto add = [&]<class E>(const auto& e, std::type_identity<E>) {
    if constexpr (way == ForceSum::unknown_slopes && KnowsSlopes<E>) {
      return;
    } else if constexpr (StateEffect<E>) {
      constexpr int k = states_of<E>();
      if constexpr (!UnilateralEffect<E, n>) {
        static_assert(require_numbers<decltype(e.force(q, qdot, Vector<S, k>(), t))>());
        add_entries(sum, e.force(q, qdot, Vector<S, k>(z.template segment<k>(first)), t));
      }
      first += k;
    } else if constexpr (way == ForceSum::by_duals && requires { e.force_by_duals(q, qdot, t); }) {
      add_entries(sum, e.force_by_duals(q, qdot, t));
    } else if constexpr (way == ForceSum::with_potentials && requires { e.force_with_potential(q, qdot, t); }) {
      add_entries(sum, e.force_with_potential(q, qdot, t));
      return;
    } else if constexpr (ForceEffect<E, n>) {
      static_assert(require_numbers<decltype(e.force(q, qdot, t))>());
      add_entries(sum, e.force(q, qdot, t));
    }
    if constexpr (way == ForceSum::with_potentials && PotentialEffect<E, n>) add_entries(sum, force_of_potential(e, q, t));
  };
  [&]<std::size_t... k>(std::index_sequence<k...>) {
    (add(std::get<k>(effects), std::type_identity<Roles>()), ...);
  }(std::index_sequence_for<Roles...>());
  return sum;
}
template <ForceSum way, class Sys, class... Effects, class S, int n>
Vector<S, n> summed_forces(const Scene<Sys, Effects...>& scene, const Vector<S, n>& q, const Vector<S, n>& qdot,
                           const Vector<S, Scene<Sys, Effects...>::states_at_compile_time>& z, const S& t) {
  return sum_over<way, Effects...>(scene.effects(), q, qdot, z, t);
}

// The same at a state, copied entry by entry, so that the compiler sees what it has of it already.
template <ForceSum way, class Sc>
[[gnu::flatten]] inline Vector<double, Sc::dof_at_compile_time> forces_at(const Sc& scene, const EffectStates<Sc>& z, const AtState& at) {
  constexpr int n = Sc::dof_at_compile_time;
  Vector<double, n> q, qdot;
  unroll<n>([&](auto i) __attribute__((always_inline)) {
    q[i] = at.q[i];
    qdot[i] = at.qdot[i];
  });
  return summed_forces<way>(scene, q, qdot, z, at.t);
}

#if defined(__clang__) && defined(__OPTIMIZE__)
#pragma clang attribute pop
#endif

// Duals know that a constant has no derivative, however steep the root of it is.
template <class Sc, int n>
[[gnu::cold, gnu::noinline]] Vector<double, n> forces_by_duals(const Sc& scene, const Vector<double, n>& q, const Vector<double, n>& qdot,
                                                               const Vector<double, Sc::states_at_compile_time>& z, double t) {
  return summed_forces<ForceSum::by_duals>(scene, q, qdot, z, t);
}

// Where what effects add to the energies is potentials only, the energies without them; otherwise the energies.
template <class Sc>
const auto& energies_without_potentials(const Sc& scene) {
  const auto& energies = scene.system().energies();
  if constexpr (Sc::adds_potentials_only) return energies.without_terms();
  else return energies;
}

}  // namespace detail

/// Sum of the generalized forces of the effects at a state, n; z holds the effects' own states.
template <class Sys, class... Effects, class S, int n>
Vector<S, n> effect_forces(const Scene<Sys, Effects...>& scene, const Vector<S, n>& q, const Vector<S, n>& qdot,
                           const Vector<S, Scene<Sys, Effects...>::states_at_compile_time>& z, const S& t) {
  if constexpr (std::is_same_v<S, double> && detail::moves_by_jets<S, n>) {
    const Vector<S, n> Q = detail::summed_forces<detail::ForceSum::plain>(scene, q, qdot, z, t);
    return detail::all_finite(Q) ? Q : detail::forces_by_duals(scene, q, qdot, z, t);
  } else {
    return detail::summed_forces<detail::ForceSum::plain>(scene, q, qdot, z, t);
  }
}

}  // namespace qdot
