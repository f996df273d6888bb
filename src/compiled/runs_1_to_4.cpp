// SPDX-License-Identifier: MIT
//
// Runs and simulators of systems with one to four coordinates. What they have in common is in equations.cpp.
#define QDOT_COMPILED
#include <qdot/integrate/driver/any_form_of.hpp>
#include <qdot/integrate/driver/engine.hpp>
#include <qdot/integrate/driver/run_of_energies.ipp>

namespace qdot::detail {
template struct RunOfEnergies<1, false>;
template struct RunOfEnergies<1, true>;
template struct RunOfEnergies<2, false>;
template struct RunOfEnergies<2, true>;
template struct RunOfEnergies<3, false>;
template struct RunOfEnergies<3, true>;
template struct RunOfEnergies<4, false>;
template struct RunOfEnergies<4, true>;
}  // namespace qdot::detail
