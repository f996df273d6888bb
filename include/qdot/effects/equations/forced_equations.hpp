#pragma once
// SPDX-License-Identifier: MIT
//
// Accelerations of scenes with forces or potentials, and without constraints: M q̈ = r + Σ (Q − ∂V/∂q).
//
// M and r are those of the system by itself. They come down the ladder of mechanics/mass_and_rhs.hpp to the object `ForcedTo` below, which
// evaluates the forces where they are added: compiled together with straight-line equations they share the sines of the coordinates and
// whatever else both need.

#include <type_traits>
#include <utility>

#include "qdot/ad/unroll.hpp"
#include "qdot/effects/equations/effect_forces.hpp"
#include "qdot/mechanics/mass_and_rhs.hpp"

namespace qdot::detail {

template <class Sc>
using EnergiesWithoutPotentials = std::remove_cvref_t<decltype(energies_without_potentials(std::declval<const Sc&>()))>;

// Which scenes go this way.
template <class Sc>
inline constexpr bool has_forced_equations =
    straight_line_pays && (Sc::has_forces || Sc::adds_potentials_only) && Sc::SystemType::inertia == Inertia::positive_definite &&
    Sc::dof_at_compile_time >= 1 && Sc::dof_at_compile_time <= straight_line_limit;

// What is to be added to these: no potential twice. Where a run keeps lines of the scene's own energies, potentials are in them.
template <class Sc>
inline constexpr ForceSum sum_beside_energies = Sc::adds_potentials_only ? ForceSum::with_potentials : ForceSum::plain;

// A use of M and r: q̈ of a scene.
template <class Sc, ForceSum sum = sum_beside_energies<Sc>>
struct ForcedTo {
  static constexpr int n = Sc::dof_at_compile_time;
  static constexpr bool shared = false;

  const Sc& scene;
  const EffectStates<Sc>& z;
  AccelerationTo<n> free;

  // Not always_inline, for the reason that mechanics/equations/straight_line.hpp tells of euler_lagrange_of().
  [[gnu::flatten]] bool packed(const AtState& at, double* M, double* r, ComponentMask present) const {
    const Vector<double, n> Q = forces_at<sum>(scene, z, at);
    unroll<n>([&](auto i) __attribute__((always_inline)) { r[i] += Q[i]; });
    return free.packed(at, M, r, present);
  }
  bool full(const AtState& at, double* M, double* r) const {
    add_forces(at, r);
    return free.full(at, M, r);
  }
  static constexpr bool is_forced = true;
  bool by_solution(const AtState& at, const DerivedLines& lines, double* x) const {
    const Vector<double, n> Q = forces_at<sum>(scene, z, at);
    return lines.write_accelerations<n>(x, Q.data(), free.threshold, free.qddot);
  }

 private:
  [[gnu::noinline]] void add_forces(const AtState& at, double* r) const {
    const Vector<double, n> Q = forces_at<sum>(scene, z, at);
    for (int i = 0; i < n; ++i) r[i] += Q[i];
  }
};

// q̈ by the shortest way; false where that is none.
template <class Sc, int n>
[[gnu::always_inline]] inline bool forced_acceleration(const Sc& scene, const Vector<double, n>& q, const Vector<double, n>& qdot, double t,
                                                       const EffectStates<Sc>& z, Vector<double, n>& qddot) {
  return with_shortest_mass_and_rhs<n>(energies_without_potentials(scene), q, qdot, t, ForcedTo<Sc>{scene, z, {qddot.data(), singular_pivot<double>(n)}},
                                       scene.system().kept_lines());
}

// q̈ by the other steps of the ladder, lines that a run keeps among them; false where there is none.
template <class Sc, int n>
bool longer_forced_acceleration(const Sc& scene, const Vector<double, n>& q, const Vector<double, n>& qdot, double t, const EffectStates<Sc>& z,
                                Vector<double, n>& qddot) {
  const AccelerationTo<n> free{qddot.data(), singular_pivot<double>(n)};
  const auto& own = scene.system().energies();
  constexpr ForceSum sum = ForceSum::plain;
  const auto evaluated = [&](const DerivedLines& lines) {
    return lines.template with_mass_and_rhs<n>(q.data(), qdot.data(), t, ForcedTo<Sc, sum>{scene, z, free});
  };
  if (with_lines<n>(scene.system().kept_lines(), own, AtState{q.data(), qdot.data(), t, static_cast<int>(q.size())}, evaluated)) return true;
  return may_be_straight(scene.system().kept_lines()) &&
         with_longer_mass_and_rhs<n>(energies_without_potentials(scene), q, qdot, t, ForcedTo<Sc>{scene, z, free});
}

}  // namespace qdot::detail
