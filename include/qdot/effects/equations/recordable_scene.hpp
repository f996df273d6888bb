#pragma once
// SPDX-License-Identifier: MIT
//
// A scene without its type, for what records its functors, asks whether they are the same still, and keeps lines of them.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "qdot/effects/equations/effect_forces.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/effects/rows/recorded_effects.hpp"
#include "qdot/effects/scene.hpp"
#include "qdot/mechanics/derive/fingerprint.hpp"
#include "qdot/mechanics/derive/kept_rates.hpp"
#include "qdot/mechanics/derive/recordable_form.hpp"
#include "qdot/mechanics/equations/solve.hpp"

namespace qdot {

template <class Sys, class... Effects, class S, int n>
auto state_rates(const Scene<Sys, Effects...>& scene, const Vector<S, n>& q, const Vector<S, n>& qdot,
                 const Vector<S, Scene<Sys, Effects...>::states_at_compile_time>& z, const S& t);

namespace detail {

// Runs all functors of a scene in the phases of the recording, and notes of each row of a constraint whether it restricts positions.
template <class Sc>
void run_scene(RecordedMotion& m, const Sc& scene, std::vector<char>* holonomic) {
  constexpr int n = Sc::dof_at_compile_time;
  run_energies<n>(m, scene.system().energies());
  if constexpr (Sc::has_forces) run_forces(m, scene);
  const double* phase = m.phases.data();
  for_each(scene.effects(), [&](const auto& e) {
    using E = std::remove_cvref_t<decltype(e)>;
    if constexpr (SwitchingEffect<E, n>)
      if (!e.is_active(*phase++)) return;
    const std::size_t first = m.returned.size();
    run_rows<n>(m, e);
    if (holonomic) holonomic->resize(holonomic->size() + m.returned.size() - first, HolonomicEffect<E, n>);
  });
}

template <class Sc>
void run_any_scene(const void* scene, RecordedMotion& m, std::vector<char>* holonomic) {
  run_scene(m, *static_cast<const Sc*>(scene), holonomic);
}

// Joins the entries of a number or vector to a hash.
[[gnu::always_inline]] inline void join(formula::Hashed& all, const formula::Hashed& x) { all = formula::Hashed::joined(all, x); }
template <int n>
[[gnu::always_inline]] inline void join(formula::Hashed& all, const Vector<formula::Hashed, n>& x) {
  for_each_entry<n>(x.size(), [&](int i) __attribute__((always_inline)) { join(all, x.data()[i]); });
}

// The fingerprint of a scene: what run_scene() runs, in its order.
template <class Sc>
[[gnu::noinline, gnu::flatten]] Fingerprint fingerprint_of_scene(const Sc& scene, const double* phases, const Answers* answers) {
  using S = formula::Hashed;
  constexpr int n = Sc::dof_at_compile_time, states = Sc::states_at_compile_time;
  HashedMotion<n> m(static_cast<int>(scene.dof()), answers);
  try {
    const auto& energies = scene.system().energies();
    const S T = kinetic<n>(energies, m.q, m.qdot, m.t), V = potential<n>(energies, m.q, m.t);
    S all(0.0);
    if constexpr (Sc::has_forces) {
      Vector<S, states> z;
      const double* phase = phases;
      int first = 0;
      for_each(scene.effects(), [&](const auto& e) __attribute__((always_inline)) {
        using E = std::remove_cvref_t<decltype(e)>;
        for (int k = 0; k < states_of<E>(); ++k) z.data()[first + k] = S(m.comparisons, 2 * n + 1 + first + k);
        if constexpr (SwitchingEffect<E, n>) z.data()[first] = S(*phase++);
        first += states_of<E>();
      });
      join(all, effect_forces(scene, m.q, m.qdot, z, m.t));
      if constexpr (states > 0) join(all, state_rates(scene, m.q, m.qdot, z, m.t));
    }
    for_each(scene.effects(), [&](const auto& e) __attribute__((always_inline)) {
      using E = std::remove_cvref_t<decltype(e)>;
      if constexpr (SwitchingEffect<E, n>)
        if (!e.is_active(*phases++)) return;
      if constexpr (HolonomicEffect<E, n>) join(all, as_rows(e.phi(m.q, m.t)));
      else if constexpr (ConstraintEffect<E, n>) join(all, as_rows(e.velocity_constraint(m.q, m.qdot, m.t)));
    });
    if (m.comparisons.are_given()) return S::with_comparisons(S::joined(S::joined(T, V), all), m.comparisons);
  } catch (...) {  // what functors throw they throw again, where they are asked for values
  }
  return 0;
}

// Which scenes have lines of q̈: of few coordinates, whose functors take the scalar that records.
template <class Sc>
inline constexpr bool has_rates = false;
template <class Sys, class... Effects>
inline constexpr bool has_rates<Scene<Sys, Effects...>> =
    may_have_rates<Sys::dof_at_compile_time> && sizeof...(Effects) > 0 &&
    RecordableEnergies<typename Scene<Sys, Effects...>::SystemType::EnergiesType, Sys::dof_at_compile_time> &&
    (effect_is_recordable<Effects, Sys::dof_at_compile_time, true>() && ...) &&
    (Scene<Sys, Effects...>::has_constraints || Sys::inertia == Inertia::positive_definite);

// Of rows that are nearer to depending on others elimination without an order loses more than six digits: the general way keeps them.
inline constexpr double independent_by_elimination = 1e-6;

/// The functors of a scene, in the phases that a recording has.
template <class Sc>
RecordableForm recordable_scene(const Sc& scene) {
  LimitsOfPivots limits{.singular = singular_pivot<double>(scene.dof()), .dependent = 0.0};
  if constexpr (Sc::has_constraints)
    limits = {.singular = massless_pivot,
              .dependent = independent_by_elimination,
              .may_be_singular = Sc::SystemType::inertia == Inertia::indefinite};
  Fingerprint (*print)(const void*, const double*, const Answers*) = nullptr;
  if constexpr (has_rates<Sc>)
    print = [](const void* it, const double* phases, const Answers* answers) {
      return fingerprint_of_scene(*static_cast<const Sc*>(it), phases, answers);
    };
  constexpr RunsFunctors run = run_any_scene<Sc>;
  return {&scene, run, run, print, scene.dof(), Sc::states_at_compile_time, Sc::has_forces, scene.system().kept_lines()->by(), limits};
}

/// The phases of contacts and dry frictions in the states z of effects.
template <class Sc>
auto phases_in(const Sc& scene, const double* z) {
  constexpr int n = Sc::dof_at_compile_time;
  std::array<double, Sc::phases_at_compile_time> all;
  std::size_t k = 0;
  for_each(scene.effects(), [&](const auto& e) {
    using E = std::remove_cvref_t<decltype(e)>;
    if constexpr (SwitchingEffect<E, n>) all[k++] = *z;
    z += states_of<E>();
  });
  return all;
}

// ydot ← [q̇; q̈; ż] by lines that are checked, and multipliers of all rows, those that are not active 0. False where there are none, and for the change watch,
// which evaluates the functors themselves.
template <class Sc>
bool rates_by_lines(const Sc& scene, const Vector<double, Sc::dof_at_compile_time>& q, const Vector<double, Sc::dof_at_compile_time>& qdot, double t,
                    const EffectStates<Sc>& z, double* ydot, FoundMultipliers* multipliers = nullptr) {
  constexpr int n = Sc::dof_at_compile_time, states = Sc::states_at_compile_time;
  const KeptLines& kept = *scene.system().kept_lines();
  if (!kept.may_be_lines() || !kept.shared() || kept.is_aside()) return false;
  double y[2 * n + states];
  std::copy_n(z.data(), states, std::copy_n(qdot.data(), n, std::copy_n(q.data(), n, y)));
  const auto phases = phases_in(scene, z.data());
  SharedRates& shared = rates_of(*kept.shared());
  const AnyRates* const latest = shared.latest(run_any_scene<Sc>, multipliers != nullptr);
  if (latest != nullptr && latest->are_in(phases) && latest->are_of(fingerprint_of_scene(scene, phases.data(), latest->answers()))) {
    const AnyRates::Written written = latest->write(t, y, ydot, multipliers);
    if (AnyRates::is_on_branch(written)) return written == AnyRates::Written::yes;
  }
  return shared.write(recordable_scene(scene), t, y, phases, ydot, multipliers);
}

}  // namespace detail
}  // namespace qdot
