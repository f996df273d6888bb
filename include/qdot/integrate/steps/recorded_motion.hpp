#pragma once
// SPDX-License-Identifier: MIT
//
// The equations of a motion as a graph.
//
// T, V and the forces of effects are run once with the scalar that writes down what is done to it (ad/formula/recording.hpp).
// Reverse differentiation of L = T − V adds what Lagrange's equations need,
//
//     p = ∂L/∂q̇ ,   M = ∂p/∂q̇ ,   F = ∂L/∂q + Σ Q ,   ż ,
//
// and nothing of this depends on how an effect is written: ∂R/∂q̇ of a Rayleigh function and Jᵀ F of a force at a point are
// dual numbers in the effect, whose parts now are nodes of the graph.
//
// What has a series is one formula everywhere. A force that asks for signs (dry friction, saturation, |x|) is refused when it is
// run; one that asks whether something is exactly zero is taken, and the question checked at each expansion: drag −b|v|v is
// analytic away from v = 0, where √(v·v) changes its branch.
//
// A constraint is recorded as what it demands of velocities, c = 0, with W = ∂c/∂q̇:
//
//     φ(q, t) = 0          c = Σ q̇_j ∂φ/∂q_j + ∂φ/∂t ,    W = ∂φ/∂q         by differentiation of the graph
//     a(q, q̇, t) = 0       c = a ,                          W = ∂a/∂q̇ .
//
// One that switches on and off is refused by the compiler.
//
// A recording holds as long as nothing changes that the functors read besides their arguments. still_holds() runs them again and
// compares.

#include <Eigen/Core>
#include <concepts>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

#include "qdot/ad/formula/recording.hpp"
#include "qdot/effects/effect.hpp"
#include "qdot/integrate/steps/form_mechanics.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot {

template <class Sys, class... Effects>
class Scene;

namespace detail {

/// The graph of a motion; all but the recording are numbers of its nodes.
struct RecordedMotion {
  formula::Recording recording = {};
  std::vector<int> q = {}, qdot = {}, z = {};  // variables
  int t = -1;                                  // a variable too
  std::vector<int> p = {}, force = {}, zdot = {};
  std::vector<int> mass = {};  // lower triangle, row by row
  std::vector<int> rows = {}, jacobian = {};  // of the constraints: c, and W row by row
  std::vector<std::string> row_names = {};
  std::vector<int> returned = {};  // by the functors, in the order of their calls
  std::vector<int> returned_before = {};  // kept for their memory: a run that finds nothing new allocates nothing
  std::vector<formula::Recording::Assumption> assumed_before = {};
};

template <class Energies, int n>
concept RecordableEnergies = CallsT<Energies, formula::Recorded, n> && CallsV<Energies, formula::Recorded, n> &&
                             kinetic_returns_scalar<Energies, formula::Recorded, n>() &&
                             potential_returns_scalar<Energies, formula::Recorded, n>();

// An effect whose roles take the recording scalar.
template <class E, int n>
consteval bool effect_is_recordable() {
  using S = formula::Recorded;
  using V = Vector<S, n>;
  if constexpr (SwitchingEffect<E, n>) {
    return false;
  } else if constexpr (HolonomicEffect<E, n>) {
    return requires(const E& e, const V& q, const S& t) { e.phi(q, t); };
  } else if constexpr (NonholonomicEffect<E, n>) {
    return requires(const E& e, const V& q, const S& t) { e.velocity_constraint(q, q, t); };
  } else if constexpr (StateEffect<E>) {
    using Z = Vector<S, states_of<E>()>;
    return requires(const E& e, const V& q, const Z& z, const S& t) { e.force(q, q, z, t), e.state_rate(q, q, z, t); };
  } else if constexpr (ForceEffect<E, n>) {
    return requires(const E& e, const V& q, const S& t) { e.force(q, q, t); };
  } else if constexpr (LagrangianEffect<E, n>) {
    return requires(const E& e, const V& q, const S& t) { e.lagrangian_term(q, q, t); };
  } else {
    return requires(const E& e, const V& q, const S& t) { e.potential_term(q, t); };
  }
}

template <class F>
struct is_recordable : std::false_type {};
template <class Sys>
struct is_recordable<FirstOrderForm<Sys>>
    : std::bool_constant<RecordableEnergies<typename Sys::EnergiesType, Sys::dof_at_compile_time>> {};
template <class Sys, class... Effects>
struct is_recordable<SceneForm<Scene<Sys, Effects...>>>
    : std::bool_constant<RecordableEnergies<typename Sys::EnergiesType, Sys::dof_at_compile_time> &&
                         (effect_is_recordable<Effects, Sys::dof_at_compile_time>() && ...)> {};

inline std::vector<int> new_variables(formula::Recording& recording, Eigen::Index first, Eigen::Index count) {
  std::vector<int> nodes;
  for (Eigen::Index i = 0; i < count; ++i) nodes.push_back(recording.graph.variable(static_cast<int>(first + i)));
  return nodes;
}

template <int n>
Vector<formula::Recorded, n> recorded_vector(formula::Recording& recording, const std::vector<int>& nodes) {
  Vector<formula::Recorded, n> x(static_cast<Eigen::Index>(nodes.size()));
  for (std::size_t i = 0; i < nodes.size(); ++i) x[static_cast<Eigen::Index>(i)] = formula::Recorded(recording, nodes[i]);
  return x;
}

// Runs of the functors: each notes the nodes of what they return.

template <int n, class Energies>
void run_energies(RecordedMotion& m, const Energies& energies) {
  m.recording.source = "T or V";
  const formula::Recorded t(m.recording, m.t);
  const auto q = recorded_vector<n>(m.recording, m.q), v = recorded_vector<n>(m.recording, m.qdot);
  const int T = kinetic<n>(energies, q, v, t).node_in(m.recording);
  const int V = potential<n>(energies, q, t).node_in(m.recording);
  m.returned.push_back(T);
  m.returned.push_back(V);
}

// Forces, then rates of the effects' own states.
template <class Sc>
void run_forces(RecordedMotion& m, const SceneForm<Sc>& form) {
  constexpr int n = Sc::dof_at_compile_time, states = Sc::states_at_compile_time;
  m.recording.source = "the force of an effect";
  const formula::Recorded t(m.recording, m.t);
  const auto q = recorded_vector<n>(m.recording, m.q), v = recorded_vector<n>(m.recording, m.qdot);
  const auto z = recorded_vector<states>(m.recording, m.z);
  const auto Q = effect_forces(form.scene(), q, v, z, t);
  for (Eigen::Index i = 0; i < Q.size(); ++i) m.returned.push_back(Q[i].node_in(m.recording));
  if constexpr (states > 0) {
    const auto rates = state_rates(form.scene(), q, v, z, t);
    for (Eigen::Index i = 0; i < rates.size(); ++i) m.returned.push_back(rates[i].node_in(m.recording));
  }
}

template <class E>
std::string_view recorded_name(const E& e) {
  if constexpr (requires { e.name; }) return e.name;
  return "constraint";
}

// φ or a of an effect, if it is a constraint.
template <int n, class E>
void run_rows(RecordedMotion& m, const E& e) {
  if constexpr (ConstraintEffect<E, n>) {
    m.recording.source = "the constraint '";
    m.recording.source.append(recorded_name(e)).append("'");
    const formula::Recorded t(m.recording, m.t);
    const auto q = recorded_vector<n>(m.recording, m.q), v = recorded_vector<n>(m.recording, m.qdot);
    const auto rows = [&] {
      if constexpr (HolonomicEffect<E, n>) {
        return as_rows(e.phi(q, t));
      } else {
        return as_rows(e.velocity_constraint(q, v, t));
      }
    }();
    for (Eigen::Index i = 0; i < rows.size(); ++i) m.returned.push_back(rows[i].node_in(m.recording));
  }
}

// Of T and V alone, which run(m) runs.
template <class Run>
RecordedMotion recorded_energies(Eigen::Index dof, const Run& run) {
  RecordedMotion m;
  formula::Graph& graph = m.recording.graph;
  m.q = new_variables(m.recording, 0, dof);
  m.qdot = new_variables(m.recording, dof, dof);
  m.t = graph.variable(static_cast<int>(2 * dof));
  run(m);
  const int T = m.returned[0], V = m.returned[1];
  m.p = graph.gradient(T, m.qdot);
  m.force = graph.gradient(graph.difference(T, V), m.q);
  for (std::size_t i = 0; i < m.p.size(); ++i) {
    const std::vector<int> row = graph.gradient(m.p[i], m.qdot);
    m.mass.insert(m.mass.end(), row.begin(), row.begin() + static_cast<std::ptrdiff_t>(i) + 1);
  }
  return m;
}

template <int n, class Energies>
RecordedMotion recorded_energies(const Energies& energies, Eigen::Index dof) {
  return recorded_energies(dof, [&](RecordedMotion& m) { run_energies<n>(m, energies); });
}

// One effect, if it is a constraint.
template <int n, class E>
void record_constraint(RecordedMotion& m, const E& e) {
  formula::Graph& graph = m.recording.graph;
  const std::size_t first = m.returned.size();
  run_rows<n>(m, e);
  const std::size_t rows = m.returned.size() - first;
  for (std::size_t i = 0; i < rows; ++i) {
    int c = m.returned[first + i];
    const std::vector<int> W = graph.gradient(c, HolonomicEffect<E, n> ? m.q : m.qdot);
    if constexpr (HolonomicEffect<E, n>) {
      c = graph.gradient(c, std::vector<int>{m.t})[0];
      for (std::size_t j = 0; j < W.size(); ++j) c = graph.sum(c, graph.product(W[j], m.qdot[j]));
    }
    m.rows.push_back(c);
    m.jacobian.insert(m.jacobian.end(), W.begin(), W.end());
    m.row_names.push_back(std::string(recorded_name(e)) + (rows == 1 ? "" : "[" + std::to_string(i) + "]"));
  }
}

/// Runs T and V once.
///
/// @throws NotAnalytic  one of them compares values or has a kink
template <class Sys>
RecordedMotion recorded_motion(const FirstOrderForm<Sys>& form) {
  return recorded_energies<Sys::dof_at_compile_time>(form.system().energies(), form.system().dof());
}

/// Runs T, V, the forces and rates of the effects, and the constraints once.
///
/// @throws NotAnalytic  one of them compares values or has a kink
template <class Sc>
RecordedMotion recorded_motion(const SceneForm<Sc>& form) {
  constexpr int n = Sc::dof_at_compile_time;
  RecordedMotion m = recorded_energies<n>(form.scene().system().energies(), form.dof());
  if constexpr (Sc::has_forces) {
    m.z = new_variables(m.recording, 2 * form.dof() + 1, Sc::states_at_compile_time);
    const std::size_t first = m.returned.size(), rates = first + m.force.size();
    run_forces(m, form);
    for (std::size_t i = 0; i < m.force.size(); ++i) m.force[i] = m.recording.graph.sum(m.force[i], m.returned[first + i]);
    m.zdot.assign(m.returned.begin() + static_cast<std::ptrdiff_t>(rates), m.returned.end());
  }
  if constexpr (Sc::has_constraints)
    std::apply([&](const auto&... effect) { (record_constraint<n>(m, effect), ...); }, form.scene().effects());
  return m;
}

template <class Sys>
void run_again(RecordedMotion& m, const FirstOrderForm<Sys>& form) {
  run_energies<Sys::dof_at_compile_time>(m, form.system().energies());
}
template <class Sc>
void run_again(RecordedMotion& m, const SceneForm<Sc>& form) {
  constexpr int n = Sc::dof_at_compile_time;
  run_energies<n>(m, form.scene().system().energies());
  if constexpr (Sc::has_forces) run_forces(m, form);
  if constexpr (Sc::has_constraints) std::apply([&](const auto&... effect) { (run_rows<n>(m, effect), ...); }, form.scene().effects());
}

/// Whether functors are the formulas that were recorded, with the same constants: those that run(m) runs, or of a form.
///
/// Runs them once more. A graph makes every node once, so the same formulas give the same nodes: a few hash look-ups for each
/// operation, and no derivative.
///
/// @throws NotAnalytic  one of them compares values or has a kink by now
template <std::invocable<RecordedMotion&> Run>
bool still_holds(RecordedMotion& m, const Run& run) {
  m.returned.swap(m.returned_before);
  m.returned.clear();
  m.recording.assumptions.swap(m.assumed_before);
  m.recording.assumptions.clear();
  run(m);
  return m.returned == m.returned_before && m.recording.assumptions == m.assumed_before;
}
template <class Form>
bool still_holds(RecordedMotion& m, const Form& form) {
  return still_holds(m, [&](RecordedMotion& again) { run_again(again, form); });
}

}  // namespace detail
}  // namespace qdot
