#pragma once
// SPDX-License-Identifier: MIT
//
// written_out_kinematic_system<n>(place, V), which is kinematic_system<n>(place, V) by another name.
//
// It had the compiler run the functor that places the masses and derive the equations, as written_out did of T and V (mechanics/written_out.hpp). The word
// is accepted and has no effect.

#include <utility>

#include "qdot/mechanics/kinematic_system.hpp"

namespace qdot {

/// Returns kinematic_system<n>(place, V), or kinematic_system<n>(place, V, T_extra).
template <int n, class Place, class Potential = NoPotential, class Extra = detail::NoKineticTerm>
[[deprecated("qdot: written_out_kinematic_system has no effect of its own any more: take kinematic_system")]]
auto written_out_kinematic_system(Place place, Potential V = {}, Extra T_extra = {}) {
  return kinematic_system<n>(std::move(place), std::move(V), std::move(T_extra));
}

}  // namespace qdot
