#pragma once
// SPDX-License-Identifier: MIT
//
// Lines of q̈ with the forces of effects in them: M q̈ = r + Σ Q.
//
// T, V and the forces are recorded together (effects/rows/recorded_effects.hpp), so that they share their sines. Numbers on which they depend beside q,
// q̇ and t are inputs of the lines: the parameters of a family of scenes (integrate/many_in_lanes.hpp). Scenes with constraints or with states of their
// effects have none.

#include <algorithm>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>

#include "qdot/effects/equations/effect_forces.hpp"
#include "qdot/effects/rows/recorded_effects.hpp"
#include "qdot/mechanics/derive/lane_equations.hpp"

namespace qdot::detail {

/// Lines, which live as long as an owner of them; null where there are none.
using OwnedLines = std::shared_ptr<const DerivedLines>;

// Whether an effect of type E is a force or a part of L that can be recorded; `Made` is its type with recorded parameters.
template <class E, class Made, int n>
consteval bool is_recordable_force() {
  using S = formula::Recorded;
  using V = Vector<S, n>;
  if constexpr (StateEffect<E> || ConstraintEffect<E, n>) {
    return false;
  } else if constexpr (ForceEffect<E, n>) {
    return requires(const Made& e, const V& q, const S& t) {
      { e.force(q, q, t) } -> Records;
    };
  } else {
    return true;  // of energies, which are asked whether they can be recorded
  }
}

// T and V as nodes of m, of energies with recorded parameters; `Numbers` are those energies with plain numbers, which say what T and V take. potentials(q, t)
// are added to V.
template <int n, class Numbers, class Energies, class Potentials>
[[gnu::cold]] void run_energies_like(RecordedMotion& m, const Energies& energies, const Potentials& potentials) {
  m.recording.source = "T or V";
  const formula::Recorded t(m.recording, m.t);
  const auto q = recorded_vector<n>(m.recording, m.q), v = recorded_vector<n>(m.recording, m.qdot);
  const auto T = [&]() -> formula::Recorded {
    if constexpr (kinetic_signature<Numbers, n>() == KineticSignature::velocity) return energies.T(v);
    else if constexpr (kinetic_signature<Numbers, n>() == KineticSignature::state) return energies.T(q, v);
    else return energies.T(q, v, t);
  };
  const auto V = [&]() -> formula::Recorded {
    if constexpr (potential_signature<Numbers, n>() == PotentialSignature::position) return energies.V(q);
    else return energies.V(q, t);
  };
  m.returned.push_back(T().node_in(m.recording));
  m.returned.push_back(formula::Recorded(V() + potentials(q, t)).node_in(m.recording));
}

// Records energies and forces. `Numbers`: as above. `Roles` are the types of the effects with plain numbers for parameters, and parameters are variables
// of m. Potentials of effects are added to V unless the energies have them.
template <int n, bool adds_potentials, class Numbers, class... Roles, class Energies, class Effects>
[[gnu::cold]] void record_under_forces(RecordedMotion& m, const Energies& energies, const Effects& effects) {
  run_energies_like<n, Numbers>(m, energies, [&](const auto& q, const auto& t) {
    formula::Recorded sum(0.0);
    const auto add = [&]<class E>(const auto& e, std::type_identity<E>) {
      if constexpr (adds_potentials && PotentialEffect<E, n>) sum = sum + e.potential_term(q, t);
    };
    [&]<std::size_t... k>(std::index_sequence<k...>) { (add(std::get<k>(effects), std::type_identity<Roles>()), ...); }(std::index_sequence_for<Roles...>());
    return sum;
  });
  if constexpr (sizeof...(Roles) > 0) {
    m.recording.source = "the force of an effect";
    using S = formula::Recorded;
    const Vector<S, n> Q = sum_over<Roles...>(effects, recorded_vector<n>(m.recording, m.q), recorded_vector<n>(m.recording, m.qdot),
                                              Vector<S, 0>(), S(m.recording, m.t));
    for (int i = 0; i < n; ++i) m.returned.push_back(Q[i].node_in(m.recording));
  }
}

// Whether two recordings are of the same formulas.
[[gnu::cold]] inline bool are_alike(const RecordedMotion& a, const RecordedMotion& b) {
  const auto same_node = [](const formula::Node& x, const formula::Node& y) {
    return x.kind == y.kind && x.function == y.function && x.a == y.a && x.b == y.b && x.ca == y.ca && x.cb == y.cb && x.c == y.c;
  };
  return a.returned == b.returned && a.recording.assumptions == b.recording.assumptions &&
         std::equal(a.recording.graph.nodes().begin(), a.recording.graph.nodes().end(), b.recording.graph.nodes().begin(), b.recording.graph.nodes().end(),
                    same_node);
}

// Lines for the lanes of what was recorded, with so many parameters.
template <int n>
[[gnu::cold]] OwnedLines lines_of_recorded(RecordedMotion m, int parameters) {
  auto made = std::make_shared<Derivation<>>();
  made->derive_motion(std::move(m), parameters);
  if (!made->lines.exist()) return {};
  made->derive_solution();
  return made->lines.solution.accelerations.empty() ? OwnedLines() : OwnedLines(made, &made->lines);
}

}  // namespace qdot::detail
