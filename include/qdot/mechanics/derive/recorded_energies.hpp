#pragma once
// SPDX-License-Identifier: MIT
//
// T and V as nodes of a graph.
//
// The functors are run once with the scalar that records its operations (ad/formula/recording.hpp), and the nodes of their results are noted. T and
// V come first; then, of a scene, forces, rates and constraints (effects/rows/recorded_effects.hpp). Two kinds of code differentiate them to
// Lagrange's equations: power series (integrate/steps/recorded_motion.hpp) and equations of many coordinates
// (mechanics/derive/traced_equations.hpp).
//
// A recording holds as long as nothing changes that the functors read besides their arguments. still_holds() runs them again and
// compares.

#include <Eigen/Core>
#include <concepts>
#include <string>
#include <vector>

#include "qdot/ad/formula/lines.hpp"
#include "qdot/ad/formula/recording.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot::detail {

/// The graph of a motion; all but the recording are numbers of its nodes.
struct RecordedMotion {
  formula::Recording recording = {};
  std::vector<int> q = {}, qdot = {}, z = {};  // variables
  int t = -1;                                  // a variable too
  std::vector<double> phases = {};             // of effects that switch: numbers, for which this holds
  std::size_t guards_of_forces = static_cast<std::size_t>(-1);  // so many before those of constraints, where branches are recorded
  std::vector<int> p = {}, force = {}, zdot = {};
  std::vector<int> mass = {};  // lower triangle, row by row
  std::vector<int> rows = {}, jacobian = {};  // of the constraints: c, and W row by row
  std::vector<std::string> row_names = {};
  std::vector<int> returned = {};  // by the functors, in the order of their calls
  std::vector<int> returned_before = {};  // kept for their memory: a run that finds nothing new allocates nothing
  std::vector<formula::Recording::Assumption> assumed_before = {};
};

// When the lines of what was recorded become machine code.
constexpr formula::MachineCodeBegins machine_code_begins(By by) {
  if (by == By::lines) return {0, 0};
  if (by == By::machine_code) return {1, 1};
  return {};
}

template <class Energies, int n>
concept RecordableEnergies = CallsT<Energies, formula::Recorded, n> && CallsV<Energies, formula::Recorded, n> &&
                             kinetic_returns_scalar<Energies, formula::Recorded, n>() &&
                             potential_returns_scalar<Energies, formula::Recorded, n>();

// Which systems are traced.
template <class Sys>
concept TracedSystem = Sys::dof_at_compile_time == Dynamic && Sys::inertia == Inertia::positive_definite &&
                       RecordableEnergies<typename Sys::EnergiesType, Dynamic>;

inline std::vector<int> new_variables(formula::Recording& recording, Eigen::Index first, Eigen::Index count) {
  std::vector<int> nodes;
  for (Eigen::Index i = 0; i < count; ++i) nodes.push_back(formula::variable_in(recording, static_cast<int>(first + i)));
  return nodes;
}

template <int n>
Vector<formula::Recorded, n> recorded_vector(formula::Recording& recording, const std::vector<int>& nodes) {
  Vector<formula::Recorded, n> x(static_cast<Eigen::Index>(nodes.size()));
  for (std::size_t i = 0; i < nodes.size(); ++i) x[static_cast<Eigen::Index>(i)] = formula::Recorded(recording, nodes[i]);
  return x;
}

// Runs of the functors, some in a run of a method and compiled for size: each notes the nodes of what they return.

// What is run next, for messages; and a node of what came out.
template <class = void>
void name_source(RecordedMotion& m, const char* what, const std::string* name = nullptr) {
  m.recording.source = what;
  if (name) m.recording.source.append(*name).append("'");
}
template <class = void>
void note_returned(RecordedMotion& m, int node) {
  m.returned.push_back(node);
}
#ifdef QDOT_COMPILED
extern template void name_source<void>(RecordedMotion&, const char*, const std::string*);
extern template void note_returned<void>(RecordedMotion&, int);
#endif

template <int n, class Energies>
[[gnu::cold]] void run_energies(RecordedMotion& m, const Energies& energies) {
  name_source(m, "T or V");
  const formula::Recorded t(m.recording, m.t);
  const auto q = recorded_vector<n>(m.recording, m.q), v = recorded_vector<n>(m.recording, m.qdot);
  const int T = kinetic<n>(energies, q, v, t).node_in(m.recording);
  const int V = potential<n>(energies, q, t).node_in(m.recording);
  note_returned(m, T);
  note_returned(m, V);
}

/// Whether functors are the formulas that were recorded, with the same constants: those that run(m) runs, or of a form.
///
/// Runs them once more, and leaves in m what they return now. A graph makes every node once, so the same formulas give the same nodes: a
/// few hash look-ups for each operation, and no derivative.
///
/// @throws NotAnalytic  one of them compares values or has a kink by now
template <std::invocable<RecordedMotion&> Run>
bool still_holds(RecordedMotion& m, const Run& run) {
  m.returned.swap(m.returned_before);
  m.returned.clear();
  m.recording.assumptions.swap(m.assumed_before);
  m.recording.assumptions.clear();
  m.recording.answers.clear();
  m.recording.turnings.clear();
  run(m);
  return m.returned == m.returned_before && m.recording.assumptions == m.assumed_before;
}

/// still_holds() for callers that go on with the recording: m keeps it where it does not hold, and where functors throw.
template <std::invocable<RecordedMotion&> Run>
bool is_unchanged(RecordedMotion& m, const Run& run) {
  try {
    if (still_holds(m, run)) return true;
  } catch (...) {  // what they throw they throw again, where they are asked for values
  }
  m.returned.swap(m.returned_before);
  m.recording.assumptions.swap(m.assumed_before);
  return false;
}

}  // namespace qdot::detail
