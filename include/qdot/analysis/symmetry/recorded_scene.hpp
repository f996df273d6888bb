#pragma once
// SPDX-License-Identifier: MIT
//
// T, V and effects as formulas, each effect by itself, so that one can say what it does to a momentum or to the energy.
//
// This is all of the search for conserved quantities that depends on the user's types; what is asked of the formulas is compiled once
// (analysis/conserved.hpp). Phases of contacts and friction are all recorded: what acts in one of them acts.

#include <cstddef>
#include <string>
#include <type_traits>
#include <vector>

#include <Eigen/Core>

#include "qdot/ad/formula/recording.hpp"
#include "qdot/effects/effect.hpp"
#include "qdot/effects/equations/friction_phase.hpp"
#include "qdot/effects/scene.hpp"
#include "qdot/error.hpp"
#include "qdot/integrate/steps/recorded_motion.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot::detail {

// What one effect does; nodes of the recording.
struct RecordedEffect {
  std::string name;
  std::string unreadable;    // why it is no formula, or nothing
  std::vector<int> force;    // n after n, for each of its phases
  std::vector<int> J;        // n after n, for each row of a constraint
  std::vector<int> drift;    // what a row demands of velocities when all are zero
  const char* takes = "";    // what takes energy away without doing work along the motion
};

struct RecordedScene {
  RecordedMotion motion;  // variables, T and V only
  int T = -1, V = -1;
  std::string unreadable;  // why T or V is no formula, or nothing
  bool autonomous = false;
  std::vector<std::string> names;
  std::vector<RecordedEffect> effects;
  std::size_t variables = 0;
};

template <class E>
bool ends_run(const E& e) {
  if constexpr (requires { e.ends_run; }) {
    return e.ends_run;
  } else {
    return false;
  }
}

// An effect by its name and what it takes, without any formula.
template <int n, class E>
RecordedEffect unread_effect(const E& e, std::size_t number) {
  RecordedEffect act;
  if constexpr (requires { e.name; }) {
    act.name = std::string("'").append(e.name).append("'");
  } else {
    act.name = "effect " + std::to_string(number + 1);
  }
  if constexpr (UnilateralEffect<E, n>) {
    act.takes = "an impact can take energy";
  } else if constexpr (FrictionEffect<E, n>) {
    act.takes = "friction takes energy";
  }
  return act;
}

// The variables of a recorded motion as arguments of functors.
template <int n>
struct RecordedArguments {
  using S = formula::Recorded;
  explicit RecordedArguments(RecordedMotion& of)
      : m(of), t(m.recording, m.t), q(recorded_vector<n>(m.recording, m.q)), v(recorded_vector<n>(m.recording, m.qdot)) {}

  RecordedMotion& m;
  S t;
  Vector<S, n> q, v;
};

// The force of an effect, whose own states begin at z[first_state]; of friction, one for each direction of sliding.
template <int n, class E>
void record_force(RecordedEffect& act, const RecordedArguments<n>& at, const E& e, std::size_t first_state) {
  using S = formula::Recorded;
  const auto push = [&](const auto&... z) {
    if constexpr (requires { e.force(at.q, at.v, z..., at.t); }) {
      const Vector<S, n> Q = e.force(at.q, at.v, z..., at.t);
      for (Eigen::Index i = 0; i < Q.size(); ++i) act.force.push_back(Q[i].node_in(at.m.recording));
    } else {
      act.unreadable = "does not take every scalar";
    }
  };
  if constexpr (FrictionEffect<E, n>) {
    if constexpr (constexpr int states = states_of<E>(); states == 1) {
      for (const double phase : {1.0, -1.0}) push(Vector<S, 1>(S(phase)));
    } else {
      Vector<S, states> z = zeros<Vector<S, states>>(states);
      z[0] = S(static_cast<double>(FrictionPhase::begins));  // -F_k v/|v|
      push(z);
    }
  } else if constexpr (StateEffect<E>) {
    constexpr int states = states_of<E>();
    Vector<S, states> z;
    for (int i = 0; i < states; ++i) z[i] = S(at.m.recording, at.m.z[first_state + static_cast<std::size_t>(i)]);
    push(z);
  } else {
    push();
  }
}

// Slopes and drifts of φ, or of a velocity constraint, row by row.
template <int n, class E>
void record_rows(RecordedEffect& act, const RecordedArguments<n>& at, const E& e) {
  using S = formula::Recorded;
  RecordedMotion& m = at.m;
  formula::Graph& graph = m.recording.graph;
  if constexpr (HolonomicEffect<E, n>) {
    const auto rows = as_rows(e.phi(at.q, at.t));
    for (Eigen::Index i = 0; i < rows.size(); ++i) {
      const int row = rows[i].node_in(m.recording);
      const std::vector<int> slopes = graph.gradient(row, m.q);
      act.J.insert(act.J.end(), slopes.begin(), slopes.end());
      act.drift.push_back(graph.gradient(row, std::vector<int>{m.t})[0]);
    }
  } else if constexpr (NonholonomicEffect<E, n>) {
    const auto rows = as_rows(e.velocity_constraint(at.q, at.v, at.t));
    for (Eigen::Index i = 0; i < rows.size(); ++i) {
      const std::vector<int> slopes = graph.gradient(rows[i].node_in(m.recording), m.qdot);
      act.J.insert(act.J.end(), slopes.begin(), slopes.end());
    }
    Vector<S, n> still(at.q.size());
    for (Eigen::Index i = 0; i < at.q.size(); ++i) still[i] = S(0.0);
    const auto drift = as_rows(e.velocity_constraint(at.q, still, at.t));
    for (Eigen::Index i = 0; i < drift.size(); ++i) act.drift.push_back(drift[i].node_in(m.recording));
  }
}

// One effect that may do something besides adding to T and V.
template <int n, class E>
void record_effect(RecordedScene& r, const E& e, std::size_t number, std::size_t first_state) {
  constexpr bool pushes = (ForceEffect<E, n> || StateEffect<E>) && !UnilateralEffect<E, n>;
  if constexpr (pushes || ConstraintEffect<E, n>) {
    if (ends_run(e)) return;
    RecordedEffect act = unread_effect<n>(e, number);
    r.motion.recording.source = act.name;
    const RecordedArguments<n> arguments(r.motion);
    try {
      if constexpr (pushes) record_force<n>(act, arguments, e, first_state);
      if constexpr (ConstraintEffect<E, n>) record_rows<n>(act, arguments, e);
    } catch (const NotAnalytic&) {
      act.unreadable = "asks for signs or sizes of its arguments";
    }
    r.effects.push_back(act);
  }
}

template <class Sys>
RecordedScene recorded_scene_of(const Sys& system, std::size_t states) {
  constexpr int n = Sys::dof_at_compile_time;
  using Energies = typename Sys::EnergiesType;
  RecordedScene r;
  const Eigen::Index dof = system.dof();
  for (Eigen::Index i = 0; i < dof; ++i) r.names.push_back(system.coordinate_name(i));
  r.autonomous = Sys::autonomous;
  RecordedMotion& m = r.motion;
  m.q = new_variables(m.recording, 0, dof);
  m.qdot = new_variables(m.recording, dof, dof);
  m.t = m.recording.graph.variable(static_cast<int>(2 * dof));
  m.z = new_variables(m.recording, 2 * dof + 1, static_cast<Eigen::Index>(states));
  r.variables = static_cast<std::size_t>(2 * dof + 1) + states;
  if constexpr (RecordableEnergies<Energies, n>) {
    try {
      run_energies<n>(m, system.energies());
      r.T = m.returned[0];
      r.V = m.returned[1];
    } catch (const NotAnalytic&) {
      r.unreadable = "T or V asks for signs or sizes of its arguments";
    }
  } else {
    r.unreadable = "T or V does not take every scalar";
  }
  return r;
}

template <class Sys, class... Effects>
RecordedScene recorded_scene(const Scene<Sys, Effects...>& scene) {
  using Sc = Scene<Sys, Effects...>;
  RecordedScene r = recorded_scene_of(scene.system(), static_cast<std::size_t>(Sc::states_at_compile_time));
  std::size_t number = 0, state = 0;
  for_each(scene.effects(), [&](const auto& e) {
    record_effect<Sc::dof_at_compile_time>(r, e, number++, state);
    state += static_cast<std::size_t>(states_of<std::remove_cvref_t<decltype(e)>>());
  });
  return r;
}

}  // namespace qdot::detail
