#pragma once
// SPDX-License-Identifier: MIT
//
// The model of T and V whose type is hidden. It depends on the number of coordinates alone and is compiled once for all scenes (program/models.cpp).
//
// Models ask T and V for more kinds of numbers than runs do (qdot/mechanics/derive/any_energies.hpp): gradients and momenta for methods that step
// momenta, and long double for references.

#include <memory>

#include "program/runnable_scene.hpp"
#include "qdot/mechanics/derive/any_energies.hpp"
#include "qdot/mechanics/energy.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot::program {

/// T and V of n coordinates, as a model asks for them.
///
/// @tparam timed  whether T or V takes the time
template <int n, bool timed>
using ModelEnergies =
    qdot::detail::AnyEnergies<n, timed, Dual<double, n>, Dual<double, n, qdot::detail::SlopeByVelocity>, qdot::detail::TermDual<long double, n>>;

/// The numbers of coordinates of such models: one to this. With more, a file that made one itself would gain nothing.
inline constexpr int most_hidden_coordinates = 3;

/// The model of hidden energies (program/system_model.hpp).
template <int n, bool timed>
std::shared_ptr<const Model> model_of_energies(ModelEnergies<n, timed> energies, const qdot::detail::SystemParts& parts);

}  // namespace qdot::program
