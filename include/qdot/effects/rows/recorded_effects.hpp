#pragma once
// SPDX-License-Identifier: MIT
//
// Forces, rates and constraints of a scene as nodes of the graph of its motion (mechanics/derive/recorded_energies.hpp).
//
// Where effects switch, a recording holds for the phases that it has: they are numbers in it, and a constraint that is not active is not
// there. In another phase there is another recording.
//
// Nothing of this depends on how an effect is written. ∂R/∂q̇ of a Rayleigh function and Jᵀ F of a force at a point are dual numbers
// in the effect; their parts are now nodes of the graph. A scene's header is not included here: code that has a scene has included it.

#include <Eigen/Core>
#include <string>
#include <type_traits>

#include "qdot/effects/effect.hpp"
#include "qdot/mechanics/derive/recorded_energies.hpp"

namespace qdot {

template <class Sys, class... Effects>
class Scene;
template <class Sys>
class FirstOrderForm;
template <class Sc>
class SceneForm;

namespace detail {

// What is returned by one that records; a function of plain numbers returns these, though Eigen lets any vector look as if it could become theirs.
template <class V>
concept Records = std::is_same_v<typename std::remove_cvref_t<V>::Scalar, formula::Recorded>;

// An effect whose roles take the recording scalar; one that switches does where it is in a phase.
template <class E, int n, bool in_a_phase = false>
consteval bool effect_is_recordable() {
  using S = formula::Recorded;
  using V = Vector<S, n>;
  if constexpr (SwitchingEffect<E, n> && !in_a_phase) {
    return false;
  } else if constexpr (FrictionEffect<E, n>) {
    return requires(const E& e, const V& q, const Vector<S, states_of<E>()>& z, const S& t) {
      e.velocity_constraint(q, q, t);
      { e.force(q, q, z, t) } -> Records;
    };
  } else if constexpr (HolonomicEffect<E, n>) {
    return requires(const E& e, const V& q, const S& t) { e.phi(q, t); };
  } else if constexpr (NonholonomicEffect<E, n>) {
    return requires(const E& e, const V& q, const S& t) { e.velocity_constraint(q, q, t); };
  } else if constexpr (StateEffect<E>) {
    using Z = Vector<S, states_of<E>()>;
    return requires(const E& e, const V& q, const Z& z, const S& t) {
      { e.force(q, q, z, t) } -> Records;
      { e.state_rate(q, q, z, t) } -> Records;
    };
  } else if constexpr (ForceEffect<E, n>) {
    return requires(const E& e, const V& q, const S& t) {
      { e.force(q, q, t) } -> Records;
    };
  } else if constexpr (LagrangianEffect<E, n>) {
    return requires(const E& e, const V& q, const S& t) { e.lagrangian_term(q, q, t); };
  } else {
    return requires(const E& e, const V& q, const S& t) { e.potential_term(q, t); };
  }
}

// Which forms can be recorded in one phase, from begin to end.
template <class F>
struct is_recordable : std::false_type {};
template <class Sys>
struct is_recordable<FirstOrderForm<Sys>>
    : std::bool_constant<RecordableEnergies<typename Sys::EnergiesType, Sys::dof_at_compile_time>> {};
template <class Sys, class... Effects>
struct is_recordable<SceneForm<Scene<Sys, Effects...>>>
    : std::bool_constant<RecordableEnergies<typename Sys::EnergiesType, Sys::dof_at_compile_time> &&
                         (effect_is_recordable<Effects, Sys::dof_at_compile_time>() && ...)> {};

// Forces, then rates of the effects' own states.
template <class Sc>
[[gnu::cold]] void run_forces(RecordedMotion& m, const Sc& scene) {
  constexpr int n = Sc::dof_at_compile_time, states = Sc::states_at_compile_time;
  name_source(m, "the force of an effect");
  const formula::Recorded t(m.recording, m.t);
  const auto q = recorded_vector<n>(m.recording, m.q), v = recorded_vector<n>(m.recording, m.qdot);
  auto z = recorded_vector<states>(m.recording, m.z);
  const double* phase = m.phases.data();
  Eigen::Index first = 0;
  for_each(scene.effects(), [&](const auto& e) {
    using E = std::remove_cvref_t<decltype(e)>;
    if constexpr (SwitchingEffect<E, n>) z[first] = *phase++;
    first += states_of<E>();
  });
  const auto Q = effect_forces(scene, q, v, z, t);
  for (Eigen::Index i = 0; i < Q.size(); ++i) note_returned(m, Q[i].node_in(m.recording));
  if constexpr (states > 0) {
    const auto rates = state_rates(scene, q, v, z, t);
    for (Eigen::Index i = 0; i < rates.size(); ++i) note_returned(m, rates[i].node_in(m.recording));
  }
}

// φ or a of an effect, if it is a constraint.
template <int n, class E>
[[gnu::cold]] void run_rows(RecordedMotion& m, const E& e) {
  if constexpr (ConstraintEffect<E, n>) {
    const std::string name = constraint_name(e);
    name_source(m, "the constraint '", &name);
    const formula::Recorded t(m.recording, m.t);
    const auto q = recorded_vector<n>(m.recording, m.q), v = recorded_vector<n>(m.recording, m.qdot);
    const auto rows = [&] {
      if constexpr (HolonomicEffect<E, n>) {
        return as_rows(e.phi(q, t));
      } else {
        return as_rows(e.velocity_constraint(q, v, t));
      }
    }();
    for (Eigen::Index i = 0; i < rows.size(); ++i) note_returned(m, rows[i].node_in(m.recording));
  }
}

}  // namespace detail
}  // namespace qdot
