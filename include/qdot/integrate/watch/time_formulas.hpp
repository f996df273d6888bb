#pragma once
// SPDX-License-Identifier: MIT
//
// The parts of a system that depend on time, as formulas: T, V and the effects that take the time. They are run once with the scalar that records its
// operations. A functor that compares is written down as it is at one time and state (ad/formula/branches.hpp).

#include <Eigen/Core>
#include <tuple>
#include <type_traits>
#include <vector>

#include "qdot/ad/formula/branches.hpp"
#include "qdot/ad/formula/recording.hpp"
#include "qdot/effects/rows/recorded_effects.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot::detail {

// The formulas of a system into which time enters.
struct TimeFormulas {
  formula::Recording recording = {};
  std::vector<int> state = {};  // variables, in the order of y
  int t = -1;
  std::vector<int> roots = {};
  bool complete = true;  // false where there is something besides
  std::vector<formula::Guard> guards = {};
  std::vector<int> places = {};  // of each guard, as a difference from its level
};

// Runs a functor with the recording scalar, if it lets itself be recorded.
template <bool takes_every_scalar, class Record>
void record_part(TimeFormulas& found, const Record& record) {
  if constexpr (takes_every_scalar) {
    try {
      record();
      return;
    } catch (...) {  // not a formula, or not here; it is the method that finds out what is wrong with it
    }
  }
  found.complete = false;
}

// `count` components of the state, from `first` on, as numbers that write down what is done to them.
template <int n>
Vector<formula::Recorded, n> recorded_part(TimeFormulas& found, Eigen::Index first, Eigen::Index count) {
  const auto begin = found.state.begin() + first;
  return recorded_vector<n>(found.recording, std::vector<int>(begin, begin + count));
}

template <class F>
struct TimeOf {
  static constexpr bool enters = false;
};

template <class Sys>
struct TimeOf<FirstOrderForm<Sys>> {
  static constexpr int n = Sys::dof_at_compile_time;
  static constexpr bool enters = !Sys::autonomous;

  // T and V, and what the equations contain of them: ∂T/∂t, as momenta have, and derivatives by q and q̇.
  [[gnu::cold]] static void record_energies(TimeFormulas& found, const Sys& system) {
    constexpr bool can = RecordableEnergies<typename Sys::EnergiesType, n>;
    record_part<can>(found, [&] {
      if constexpr (can) {
        const auto q = recorded_part<n>(found, 0, system.dof()), v = recorded_part<n>(found, system.dof(), system.dof());
        const formula::Recorded t(found.recording, found.t);
        add(found, kinetic<n>(system.energies(), q, v, t), true, true);
        add(found, potential<n>(system.energies(), q, t), false, true);
      }
    });
  }

  // One result; with its derivatives by time and by state where the equations contain them.
  static void add(TimeFormulas& found, const formula::Recorded& result, bool by_time, bool by_state) {
    formula::Graph& graph = found.recording.graph;
    const int root = result.node_in(found.recording);
    found.roots.push_back(root);
    if (by_time) found.roots.push_back(graph.gradient(root, std::vector<int>{found.t})[0]);
    if (!by_state) return;
    const std::vector<int> slopes = graph.gradient(root, found.state);
    found.roots.insert(found.roots.end(), slopes.begin(), slopes.end());
  }

  static void record(TimeFormulas& found, const FirstOrderForm<Sys>& form) { record_energies(found, form.system()); }
};

// An effect whose functor takes the time; where it does not say, it may.
template <class E, int n>
consteval bool effect_takes_time() {
  if constexpr (requires { E::template takes_time<n>; }) {
    return E::template takes_time<n>;
  } else {
    return true;
  }
}

template <class Sys, class... Effects>
struct TimeOf<SceneForm<Scene<Sys, Effects...>>> {
  static constexpr int n = Sys::dof_at_compile_time;
  template <class E>
  static constexpr bool in_energies = LagrangianEffect<E, n> || PotentialEffect<E, n>;
  static constexpr bool energies_take_time = !Sys::autonomous || ((in_energies<Effects> && effect_takes_time<Effects, n>()) || ...);
  static constexpr bool enters = !Sys::autonomous || (effect_takes_time<Effects, n>() || ...);

  template <class Form>
  static void record(TimeFormulas& found, const Form& form) {
    const auto& system = form.scene().system();
    using Behind = TimeOf<FirstOrderForm<std::remove_cvref_t<decltype(system)>>>;
    if constexpr (energies_take_time) Behind::record_energies(found, system);
    Eigen::Index first = 2 * form.dof();
    const auto visit = [&]<class E>(const E& e) {
      if constexpr (effect_takes_time<E, n>()) record_effect(found, e, form.dof(), first);
      first += states_of<E>();
    };
    std::apply([&](const auto&... e) { (visit(e), ...); }, form.scene().effects());
  }

 private:
  template <class E>
  [[gnu::cold]] static void record_effect(TimeFormulas& found, const E& e, Eigen::Index dof, Eigen::Index first) {
    using S = formula::Recorded;
    constexpr int states = states_of<E>();
    const auto q = recorded_part<n>(found, 0, dof), v = recorded_part<n>(found, dof, dof);
    const S t(found.recording, found.t);
    const auto add = [&](const auto& rows, bool by_time) {
      for (Eigen::Index i = 0; i < rows.size(); ++i) TimeOf<FirstOrderForm<Sys>>::add(found, S(rows[i]), by_time, false);
    };
    if constexpr (HolonomicEffect<E, n>) {
      constexpr bool can = requires { e.phi(q, t); };
      record_part<can>(found, [&] {  // φ and its first two derivatives
        if constexpr (can) {
          for (const auto& row : as_rows(e.phi(q, t))) {
            const int rate = found.recording.graph.gradient(row.node_in(found.recording), std::vector<int>{found.t})[0];
            TimeOf<FirstOrderForm<Sys>>::add(found, row, false, true);
            TimeOf<FirstOrderForm<Sys>>::add(found, S(found.recording, rate), true, true);
          }
        }
      });
    } else if constexpr (NonholonomicEffect<E, n>) {
      constexpr bool can = requires { e.velocity_constraint(q, v, t); };
      record_part<can>(found, [&] {
        if constexpr (can) add(as_rows(e.velocity_constraint(q, v, t)), true);
      });
    }
    if constexpr (StateEffect<E> && !SwitchingEffect<E, n>) {
      const auto z = recorded_part<states>(found, first, states);
      constexpr bool can = requires { e.force(q, v, z, t), e.state_rate(q, v, z, t); };
      record_part<can>(found, [&] {
        if constexpr (can) add(e.force(q, v, z, t), false), add(e.state_rate(q, v, z, t), false);
      });
    } else if constexpr (ForceEffect<E, n>) {
      constexpr bool can = requires { e.force(q, v, t); };
      record_part<can>(found, [&] {
        if constexpr (can) add(e.force(q, v, t), false);
      });
    }
  }
};

}  // namespace qdot::detail
