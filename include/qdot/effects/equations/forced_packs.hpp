#pragma once
// SPDX-License-Identifier: MIT
//
// Accelerations of scenes with forces or potentials in packs of states (ad/pack.hpp): those of forced_equations.hpp, lane by lane.
//
// Forces are compiled together with the straight-line code of T and V, or with the lines that the compiler has derived, as there; what a force says of
// the numbers that it is given, it says of packs of them. An effect whose functor takes plain numbers only says nothing of packs, and its scene
// has none.

#include <type_traits>

#include "qdot/ad/unroll.hpp"
#include "qdot/effects/equations/forced_equations.hpp"
#include "qdot/mechanics/ensemble.hpp"

namespace qdot::detail {

// Whether an effect plays its roles for packs P as for numbers: E, and `InPacks` where its parameters are packs as well.
template <class E, class InPacks, class P, int n>
consteval bool plays_for_packs() {
  using V = Vector<P, n>;
  if constexpr (StateEffect<E> || ConstraintEffect<E, n>) {
    return false;
  } else if constexpr (ForceEffect<E, n>) {
    return requires(const InPacks& e, const V& q, const P& t) { e.force(q, q, t); };
  } else {
    return true;  // T and V are asked for packs anyway
  }
}

// Whether the packs P of a system or scene have a way of their own.
template <class Sys, class P>
inline constexpr bool scene_goes_in_packs = goes_in_packs<Sys>;
template <class Sys, class... Effects, class P>
inline constexpr bool scene_goes_in_packs<Scene<Sys, Effects...>, P> = [] {
  if constexpr (goes_in_packs<typename Scene<Sys, Effects...>::SystemType>) return (plays_for_packs<Effects, Effects, P, Sys::dof_at_compile_time>() && ...);
  else return false;
}();

// q̈ of energies under the forces of effects, a register at a time. The roles are those of Sc, whose own effects these are, or the same with packs for
// parameters.
template <class Sc>
struct UnderForces;
template <class Sys, class... Effects>
struct UnderForces<Scene<Sys, Effects...>> {
  using Sc = Scene<Sys, Effects...>;
  static constexpr int n = Sc::dof_at_compile_time;

  template <class Energies, class Tuple, class P>
  static typename P::Mask accelerations(const Energies& energies, const Tuple& effects, const P* q, const P* qdot, const P& t, P* qddot) {
    if constexpr (Sc::has_forces || Sc::adds_potentials_only) {
      const auto forces = [&](const P* at, const P* velocity, P* Q) __attribute__((always_inline)) {
        Vector<P, n> x, v;
        unroll<n>([&](auto i) __attribute__((always_inline)) {
          x[i] = at[i];
          v[i] = velocity[i];
        });
        const Vector<P, n> all = sum_over<sum_beside_energies<Sc>, false, Effects...>(effects, x, v, Vector<P, 0>(), t);
        unroll<n>([&](auto i) __attribute__((always_inline)) { Q[i] = all[i]; });
      };
      return register_accelerations<n>(energies, q, qdot, t, forces, qddot);
    } else {
      return register_accelerations<n>(energies, q, qdot, t, NoForces(), qddot);
    }
  }
};

template <class Sys, class... Effects, class P>
typename P::Mask unchecked_accelerations(const Scene<Sys, Effects...>& scene, const P* q, const P* qdot, const P& t, P* qddot) {
  return UnderForces<Scene<Sys, Effects...>>::accelerations(energies_without_potentials(scene), scene.effects(), q, qdot, t, qddot);
}

}  // namespace qdot::detail
