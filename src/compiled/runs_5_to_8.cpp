// SPDX-License-Identifier: MIT
//
// Runs and simulators of systems with five to eight coordinates. What they have in common is in equations.cpp.
#define QDOT_COMPILED
#include <qdot/integrate/driver/any_form_of.hpp>
#include <qdot/integrate/driver/engine.hpp>
#include <qdot/integrate/driver/run_of_energies.ipp>

namespace qdot::detail {
template struct RunOfEnergies<5, false>;
template struct RunOfEnergies<5, true>;
template struct RunOfEnergies<6, false>;
template struct RunOfEnergies<6, true>;
template struct RunOfEnergies<7, false>;
template struct RunOfEnergies<7, true>;
template struct RunOfEnergies<8, false>;
template struct RunOfEnergies<8, true>;
}  // namespace qdot::detail
