#pragma once
// SPDX-License-Identifier: MIT
//
// The model of T and V whose type is hidden, which depends on the number of coordinates alone. The most frequent ones are compiled once for all
// scenes (program/models.cpp), the others in each file that makes one.
//
// Models ask T and V for more kinds of numbers than runs do (qdot/mechanics/derive/any_energies.hpp): gradients and momenta for methods that step
// momenta, and long double for references.

#include <memory>
#include <type_traits>

#include "program/runnable_scene.hpp"
#include "qdot/integrate/energy_balance.hpp"
#include "qdot/mechanics/derive/any_energies.hpp"
#include "qdot/mechanics/energy.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot::program {

namespace detail {

using qdot::detail::AnyEnergies, qdot::detail::SlopeByTime, qdot::detail::SlopeByVelocity, qdot::detail::TermDual;

template <int n, bool timed, class... More>
struct WithNumbers {
  using type = AnyEnergies<n, timed, Dual<double, n, SlopeByVelocity>, TermDual<long double, n>, More...>;
};
template <int n, class... More>
using WithTime = WithNumbers<n, true, Dual<double, 1, SlopeByTime>, More...>;
template <int n, bool timed, class... More>
using WithAll = std::conditional_t<timed, WithTime<n, More...>, WithNumbers<n, false, More...>>;
// Runs ask for Dual<double, 1> themselves.
template <int n, bool timed>
struct ModelEnergiesOf : std::conditional_t<n == 1, WithAll<n, timed>, WithAll<n, timed, Dual<double, n>>> {};

}  // namespace detail

/// T and V of n coordinates, as a model asks for them.
///
/// @tparam timed  whether T or V takes the time
template <int n, bool timed>
using ModelEnergies = typename detail::ModelEnergiesOf<n, timed>::type;

/// The numbers of coordinates of such models.
inline constexpr int most_coordinates_of_hidden_models = 8;

/// The model of hidden energies (program/system_model.hpp).
template <int n, bool timed>
std::shared_ptr<const Model> model_of_energies(ModelEnergies<n, timed> energies, const qdot::detail::SystemParts& parts);

}  // namespace qdot::program
