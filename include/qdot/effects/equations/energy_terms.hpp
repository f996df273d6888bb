#pragma once
// SPDX-License-Identifier: MIT
//
// T and V of a system with the terms of its effects in them.
//
// Most energies are a T and a V and nothing else, and a term more or less in them changes nothing. Energies that know more of themselves
// (mechanics/mass_and_rhs.hpp), such as those made of positions and masses, give M and r their own way; what the terms add to them,
//
//     M += ∂²L/∂q̇∂q̇ ,   r += X L      of terms in the Lagrangian
//     r −= ∂V/∂q                       of potentials alone, which is a first derivative,
//
// comes from the terms by themselves, in straight-line code where that is what they are.

#include <cstddef>
#include <tuple>

#include "qdot/ad/places/position_jet.hpp"
#include "qdot/ad/unroll.hpp"
#include "qdot/effects/effect.hpp"
#include "qdot/mechanics/mass_and_rhs.hpp"

namespace qdot::detail {

// The terms by themselves.
template <int n, class... Effects>
struct EnergyTerms {
  std::tuple<Effects...> effects;

  static constexpr bool in_T = (LagrangianEffect<Effects, n> || ...);
  static constexpr bool in_V = (PotentialEffect<Effects, n> || ...);

  template <class S>
  S T(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    return added_to_T(S(0.0), q, qdot, t);
  }
  template <class S>
  S V(const Vector<S, n>& q, const S& t) const {
    return added_to_V(S(0.0), q, t);
  }

  template <std::size_t i = 0, class S>
  [[gnu::flatten]] S added_to_T(const S& sum, const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    if constexpr (i == sizeof...(Effects)) {
      return sum;
    } else if constexpr (LagrangianEffect<std::tuple_element_t<i, std::tuple<Effects...>>, n>) {
      return added_to_T<i + 1>(S(sum + std::get<i>(effects).lagrangian_term(q, qdot, t)), q, qdot, t);
    } else {
      return added_to_T<i + 1>(sum, q, qdot, t);
    }
  }
  template <std::size_t i = 0, class S>
  [[gnu::flatten]] S added_to_V(const S& sum, const Vector<S, n>& q, const S& t) const {
    if constexpr (i == sizeof...(Effects)) {
      return sum;
    } else if constexpr (PotentialEffect<std::tuple_element_t<i, std::tuple<Effects...>>, n>) {
      return added_to_V<i + 1>(S(sum + std::get<i>(effects).potential_term(q, t)), q, t);
    } else {
      return added_to_V<i + 1>(sum, q, t);
    }
  }
};

// A use of M and r: hands them on to another, with the share of the terms.
template <int n, class Terms, class Use>
struct WithTerms {
  const Terms& terms;
  const Use& use;

  [[gnu::flatten]] bool packed(const AtState& at, double* M, double* r, ComponentMask present) const {
    if constexpr (Terms::in_T) {
      const EulerLagrange<n> L = euler_lagrange_of<n>(terms, at.q, at.qdot, at.t);
      if (!__builtin_constant_p(L.g_mask | L.h_mask)) return false;
      unroll<n>([&](auto i) __attribute__((always_inline)) { r[i] = sum_of(1U, r[i], has(L.x_mask, i), L.template x<i>()); });
      unroll<n*(n + 1) / 2>([&](auto k) __attribute__((always_inline)) { M[k] = sum_of(1U, M[k], has(L.h_mask, k), L.template h<k>()); });
      present |= L.h_mask;
    } else {
      using S = PositionJet<n>;
      Vector<S, n> x;
      unroll<n>([&](auto i) __attribute__((always_inline)) { x[i] = S::template coordinate<i>(at.q[i], 0.0); });
      const S V = S(terms.V(x, S(at.t))).whole();
      if (!__builtin_constant_p(V.mask)) return false;
      unroll<n>([&](auto i) __attribute__((always_inline)) { r[i] = sum_of(1U, r[i], has(V.mask, i), -V.template J<i>()); });
    }
    return use.packed(at, M, r, present);
  }
};

// The energies of a system with the terms in them, in the shortest signatures that hold the terms. Flattened, so that the compiler
// sees through to the functors (mechanics/equations/straight_line.hpp).
template <class Energies, int n, class... Effects>
struct EnergiesWithTerms {
  using Terms = EnergyTerms<n, Effects...>;
  Energies energies;
  Terms terms;

  static constexpr KineticSignature kinetic_was = kinetic_signature<Energies, n>();
  static constexpr PotentialSignature potential_was = potential_signature<Energies, n>();

  template <class S>
    requires(!Terms::in_T && kinetic_was == KineticSignature::velocity)
  [[gnu::flatten]] S T(const Vector<S, n>& qdot) const {
    return energies.T(qdot);
  }
  template <class S>
    requires(!Terms::in_T && kinetic_was == KineticSignature::state)
  [[gnu::flatten]] S T(const Vector<S, n>& q, const Vector<S, n>& qdot) const {
    return energies.T(q, qdot);
  }
  template <class S>
    requires(Terms::in_T || kinetic_was == KineticSignature::state_and_time)
  [[gnu::flatten]] S T(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    return terms.added_to_T(kinetic<n>(energies, q, qdot, t), q, qdot, t);
  }
  template <class S>
    requires(!Terms::in_V && potential_was == PotentialSignature::position)
  [[gnu::flatten]] S V(const Vector<S, n>& q) const {
    return energies.V(q);
  }
  template <class S>
    requires(Terms::in_V || potential_was == PotentialSignature::position_and_time)
  [[gnu::flatten]] S V(const Vector<S, n>& q, const S& t) const {
    return terms.added_to_V(potential<n>(energies, q, t), q, t);
  }

  static constexpr bool has_own_equations = HasOwnEquations<Energies>;
  template <class Use>
  bool equations(const double* q, const double* qdot, Eigen::Index size, double t, const Use& use) const {
    return energies.equations(q, qdot, size, t, WithTerms<n, Terms, Use>{terms, use});
  }
  const Energies& without_terms() const { return energies; }
};

}  // namespace qdot::detail
