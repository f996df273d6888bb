#pragma once
// SPDX-License-Identifier: MIT
//
// The branch that functors take at a state, as a graph.
//
// T, V, forces and active constraints are run with numbers that record and know the state (ad/formula/branches.hpp). What is done with branches, and with
// their neighbours, is in integrate/steps/neighbouring_branches.hpp.
//
// What cannot be recorded is left out, from where it cannot: a functor that asks for a plain value, and one that does not take every scalar.

#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/ad/formula/branches.hpp"
#include "qdot/effects/effect.hpp"
#include "qdot/effects/rows/recorded_effects.hpp"

namespace qdot::detail {

// One branch.
struct RecordedBranch {
  formula::Branches branches{};
  RecordedMotion motion{};
  std::size_t forces = 0;  // of what was returned behind T and V: forces and rates; then come rows of constraints
  std::vector<char> holonomic{};  // of each row: whether it is φ, and not a
  RecordedBranch() { motion.recording.branches = &branches; }
  RecordedBranch(const RecordedBranch&) = delete;
  RecordedBranch& operator=(const RecordedBranch&) = delete;

  // q, q̇, z, and t last.
  std::vector<int> variables() const;
  // Of nodes, where the variables have these values.
  std::vector<double> values(const std::vector<int>& nodes, const std::vector<double>& at) const;
};

template <class Form>
inline constexpr bool has_branches_recorded = false;
template <class Sys>
inline constexpr bool has_branches_recorded<FirstOrderForm<Sys>> = is_recordable<FirstOrderForm<Sys>>::value;
template <class Form>
  requires requires { Form::functors_are_recordable; }
inline constexpr bool has_branches_recorded<Form> = Form::functors_are_recordable;

// Runs what a form has.
template <class Sys>
void run_functors(RecordedBranch& branch, const FirstOrderForm<Sys>& form) {
  run_energies<Sys::dof_at_compile_time>(branch.motion, form.system().energies());
}
// That of a scene, which is not known here.
template <class Form>
  requires requires { Form::functors_are_recordable; }
void run_functors(RecordedBranch& branch, const Form& form) {
  using Sc = std::remove_cvref_t<decltype(form.scene())>;
  constexpr int n = Sc::dof_at_compile_time;
  RecordedMotion& m = branch.motion;
  if constexpr (Sc::has_forces) branch.forces = m.q.size() + m.z.size();
  m.phases.clear();
  [[maybe_unused]] std::size_t place = m.q.size() + m.qdot.size() + 1;
  const auto note = [&]<class E>(const E&) {
    if constexpr (SwitchingEffect<E, n>) m.phases.push_back(branch.branches.variables[place]);
    place += static_cast<std::size_t>(states_of<E>());
  };
  std::apply([&](const auto&... e) { (note(e), ...); }, form.scene().effects());
  run_scene(m, form.scene(), &branch.holonomic);
}

}  // namespace qdot::detail
