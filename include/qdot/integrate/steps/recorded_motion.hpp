#pragma once
// SPDX-License-Identifier: MIT
//
// The equations of a motion as a graph.
//
// T, V and the forces of effects are run once with the scalar that records (ad/formula/recording.hpp). Reverse differentiation of
// L = T − V adds what Lagrange's equations need. A constraint is recorded as what it demands of velocities, c = 0, with W = ∂c/∂q̇:
//
//     p = ∂L/∂q̇ ,   M = ∂p/∂q̇ ,   F = ∂L/∂q + Σ Q ,   ż
//     φ(q, t) = 0          c = Σ q̇_j ∂φ/∂q_j + ∂φ/∂t ,    W = ∂φ/∂q         by differentiation of the graph
//     a(q, q̇, t) = 0       c = a ,                          W = ∂a/∂q̇ .
//
// What has a series is one formula everywhere. A force that asks for signs (dry friction, saturation, |x|) is refused when it is
// run. One that asks whether something is exactly zero is taken, and the question checked at each expansion. Drag −b|v|v is
// analytic away from v = 0, where √(v·v) changes its branch. A constraint that switches on and off is refused by the compiler.

#include <Eigen/Core>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/ad/formula/recording.hpp"
#include "qdot/effects/effect.hpp"
#include "qdot/effects/rows/recorded_effects.hpp"
#include "qdot/integrate/steps/form_mechanics.hpp"
#include "qdot/mechanics/derive/recorded_energies.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot {

namespace detail {

// p, ∂L/∂q and M of the T and V that have been run.
template <class Number = double>
[[gnu::cold]] void differentiate_energies(RecordedMotion& m) {
  formula::BasicGraph<Number>& graph = m.recording.graph;
  const int T = m.returned[0], V = m.returned[1];
  m.p = graph.gradient(T, m.qdot);
  m.force = graph.gradient(graph.difference(T, V), m.q);
  for (std::size_t i = 0; i < m.p.size(); ++i) {
    const std::vector<int> row = graph.gradient(m.p[i], m.qdot);
    m.mass.insert(m.mass.end(), row.begin(), row.begin() + static_cast<std::ptrdiff_t>(i) + 1);
  }
}

// c and W of the constraints that have been run last, from `first` on: their rates, where they say what φ is.
template <class Number = double>
[[gnu::cold]] void differentiate_rows(RecordedMotion& m, std::size_t first, bool of_positions, const std::string& name) {
  formula::BasicGraph<Number>& graph = m.recording.graph;
  const std::size_t rows = m.returned.size() - first;
  for (std::size_t i = 0; i < rows; ++i) {
    int c = m.returned[first + i];
    const std::vector<int> W = graph.gradient(c, of_positions ? m.q : m.qdot);
    if (of_positions) {
      c = graph.gradient(c, std::vector<int>{m.t})[0];
      for (std::size_t j = 0; j < W.size(); ++j) c = graph.sum(c, graph.product(W[j], m.qdot[j]));
    }
    m.rows.push_back(c);
    m.jacobian.insert(m.jacobian.end(), W.begin(), W.end());
    m.row_names.push_back(rows == 1 ? name : sentence({name, "[", i, "]"}));
  }
}

// Adds forces that have been run, from `first` on, to those of the energies.
template <class Number = double>
[[gnu::cold]] void add_forces(RecordedMotion& m, std::size_t first) {
  for (std::size_t i = 0; i < m.force.size(); ++i) m.force[i] = m.recording.graph.sum(m.force[i], m.returned[first + i]);
}

#ifdef QDOT_COMPILED
extern template void differentiate_energies<double>(RecordedMotion&);
extern template void differentiate_rows<double>(RecordedMotion&, std::size_t, bool, const std::string&);
extern template void add_forces<double>(RecordedMotion&, std::size_t);
#endif

// Of T and V alone, which run(m) runs. A recording that has other motions already has the same variables, and formulas that are equal are one node.
template <class Run>
[[gnu::cold]] RecordedMotion recorded_energies(Eigen::Index dof, const Run& run, formula::Recording recording = {}) {
  RecordedMotion m;
  m.recording = std::move(recording);
  m.q = new_variables(m.recording, 0, dof);
  m.qdot = new_variables(m.recording, dof, dof);
  m.t = formula::variable_in(m.recording, static_cast<int>(2 * dof));
  run(m);
  differentiate_energies(m);
  return m;
}

template <int n, class Energies>
RecordedMotion recorded_energies(const Energies& energies, Eigen::Index dof, formula::Recording recording) {
  return recorded_energies(dof, [&](RecordedMotion& m) { run_energies<n>(m, energies); }, std::move(recording));
}

// One effect, if it is a constraint.
template <int n, class E>
[[gnu::cold]] void record_constraint(RecordedMotion& m, const E& e) {
  const std::size_t first = m.returned.size();
  run_rows<n>(m, e);
  differentiate_rows(m, first, HolonomicEffect<E, n>, constraint_name(e));
}

/// Runs T and V once.
///
/// @param recording  of other motions with as many coordinates, to be added to
/// @throws NotAnalytic  one of them compares values or has a kink
template <class Sys>
RecordedMotion recorded_motion(const FirstOrderForm<Sys>& form, formula::Recording recording = {}) {
  return recorded_energies<Sys::dof_at_compile_time>(form.system().energies(), form.system().dof(), std::move(recording));
}

/// Runs T, V, the forces and rates of the effects, and the constraints once.
///
/// @param recording  of other motions with as many coordinates, to be added to
/// @throws NotAnalytic  one of them compares values or has a kink
template <class Sc>
RecordedMotion recorded_motion(const SceneForm<Sc>& form, formula::Recording recording = {}) {
  constexpr int n = Sc::dof_at_compile_time;
  RecordedMotion m = recorded_energies<n>(form.scene().system().energies(), form.dof(), std::move(recording));
  if constexpr (Sc::has_forces) {
    m.z = new_variables(m.recording, 2 * form.dof() + 1, Sc::states_at_compile_time);
    const std::size_t first = m.returned.size(), rates = first + m.force.size();
    run_forces(m, form.scene());
    add_forces(m, first);
    m.zdot.assign(m.returned.begin() + static_cast<std::ptrdiff_t>(rates), m.returned.end());
  }
  if (m.recording.branches != nullptr) m.guards_of_forces = m.recording.branches->met.size();
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
  if constexpr (Sc::has_forces) run_forces(m, form.scene());
  if constexpr (Sc::has_constraints) std::apply([&](const auto&... effect) { (run_rows<n>(m, effect), ...); }, form.scene().effects());
}

template <class Form>
bool still_holds(RecordedMotion& m, const Form& form) {
  return still_holds(m, [&](RecordedMotion& again) { run_again(again, form); });
}

}  // namespace detail
}  // namespace qdot
