#pragma once
// SPDX-License-Identifier: MIT
//
// written_out<n>(T, V), which does nothing any more.
//
// It had the compiler run T and V and derive the equations of motion. Every system records T and V when the equations are first asked for, derives them
// from that, and turns them into machine code where they are asked for often (mechanics/derive/kept_lines.hpp, ad/native/line_evaluator.ipp). So the word is
// accepted and has no effect.

#include <utility>

#include "qdot/mechanics/system.hpp"

namespace qdot {

/// The energies as they are given; every system derives its equations by itself.
template <int n, class Energies>
[[deprecated("qdot: written_out<n>(energies) has no effect any more: every system derives its equations by itself; give the energies alone")]]
auto written_out(Energies energies) {
  return detail::energies_object<n>(std::move(energies));
}

/// The energies T and V of two functors, as they are given.
template <int n, class Kinetic, class Potential>
[[deprecated("qdot: written_out<n>(T, V) has no effect any more: every system derives its equations by itself; give T and V alone")]]
auto written_out(Kinetic T, Potential V) {
  return KineticAndPotential<Kinetic, Potential>{std::move(T), std::move(V)};
}

}  // namespace qdot
