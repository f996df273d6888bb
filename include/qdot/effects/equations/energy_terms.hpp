#pragma once
// SPDX-License-Identifier: MIT
//
// T and V of a system with the terms of its effects in them.
//
// They are a T and a V like others.

#include <cstddef>
#include <tuple>

#include "qdot/effects/effect.hpp"
#include "qdot/mechanics/equations/energy_functors.hpp"

namespace qdot::detail {

// The terms by themselves.
template <int n, class... Effects>
struct EnergyTerms {
  std::tuple<Effects...> effects;

  static constexpr bool in_T = (LagrangianEffect<Effects, n> || ...);
  static constexpr bool in_V = (PotentialEffect<Effects, n> || ...);

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

// The energies of a system with the terms in them, in the shortest signatures that hold the terms. Flattened, so that the compiler
// sees through to the functors when it hashes them.
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

  const Energies& without_terms() const { return energies; }
};

}  // namespace qdot::detail
