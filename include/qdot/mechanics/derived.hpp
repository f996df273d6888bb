#pragma once
// SPDX-License-Identifier: MIT
//
// derived<n>(T, V), which does nothing any more.
//
// It derived Lagrange's equations when an object was made, for evaluations outside of runs. Every system derives its equations when they are first
// asked for and checks them at each evaluation (mechanics/derive/kept_lines.hpp), so the word is accepted and has no effect.

#include <utility>

#include "qdot/mechanics/system.hpp"

namespace qdot {

/// The same energies; every system derives its equations by itself.
template <int n, class Energies>
[[deprecated("qdot: derived<n>(energies) has no effect any more: every system derives its equations when they are first asked for; give the energies alone")]]
auto derived(Energies energies) {
  return detail::energies_object<n>(std::move(energies));
}

/// The energies T and V of two functors.
template <int n, class Kinetic, class Potential>
[[deprecated("qdot: derived<n>(T, V) has no effect any more: every system derives its equations when they are first asked for; give T and V alone")]]
auto derived(Kinetic T, Potential V) {
  return KineticAndPotential<Kinetic, Potential>{std::move(T), std::move(V)};
}

}  // namespace qdot
