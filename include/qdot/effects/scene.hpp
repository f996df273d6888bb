#pragma once
// SPDX-License-Identifier: MIT
//
// A scene is a system and the effects that it names:
//
//     const auto s = scene(cart_and_pole, rayleigh(R), force_at_point(push, tip));
//
// Its type is Scene<System, Effects...>, and its equations contain the terms of these effects and no
// others:
//
//     M q̈ = rhs + Σ Q + Jᵀ λ .
//
// Terms of the Lagrangian are added to T and V (effects/equations/energy_terms.hpp) before anything is differentiated, so that they share
// their derivatives. A scene without such terms keeps the system's own T and V. A scene without any effects *is* the system for the
// compiler: acceleration(scene, …) is a call of acceleration(system, …) and nothing more.

#include <algorithm>
#include <cstddef>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "qdot/effects/effect.hpp"
#include "qdot/effects/equations/energy_terms.hpp"
#include "qdot/effects/fit.hpp"
#include "qdot/mechanics/equations/solve.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot {

namespace detail {

#if defined(__clang__) && defined(__OPTIMIZE__)  // ad/forward/functor_result.hpp says why
#pragma clang attribute push(__attribute__((always_inline)), apply_to = function)
#endif

// Written out for few effects: each lambda is a type and a function for each scene.
template <class Tuple, class Visit>
constexpr void for_each(const Tuple& effects, Visit&& visit) {
  constexpr std::size_t count = std::tuple_size_v<Tuple>;
  if constexpr (count > 4) {
    [&]<std::size_t... k>(std::index_sequence<k...>) {
      (visit(std::get<k>(effects)), ...);
    }(std::make_index_sequence<count>());
  } else {
    if constexpr (count > 0) visit(std::get<0>(effects));
    if constexpr (count > 1) visit(std::get<1>(effects));
    if constexpr (count > 2) visit(std::get<2>(effects));
    if constexpr (count > 3) visit(std::get<3>(effects));
  }
}

#if defined(__clang__) && defined(__OPTIMIZE__)
#pragma clang attribute pop
#endif

template <class Sys, class... Effects>
constexpr bool has_energy_terms = ((LagrangianEffect<Effects, Sys::dof_at_compile_time> ||
                                    PotentialEffect<Effects, Sys::dof_at_compile_time>) || ...);

// The energies of a system, or of what was made of it, with its names.
template <class Sys, class Energies, class Named>
Sys named_system(const Energies& energies, const Named& named) {
  return Sys(energies, named.dof()).with_names(coordinate_names(named)).by(named.system().kept_lines()->by());
}

// An effect as n coordinates need it: some are others for one number than for several.
template <int n, class Effect>
auto fitted_effect(Effect effect) {
  if constexpr (requires { effect.template fitted<n>(); }) return effect.template fitted<n>();
  else return effect;
}
template <class Effect, int n>
using FittedEffect = decltype(fitted_effect<n>(std::declval<Effect>()));

// The system that Lagrange's equations are written for.
template <class Sys, class... Effects>
auto effective_system(const Sys& system, const std::tuple<Effects...>& effects) {
  if constexpr (has_energy_terms<Sys, Effects...>) {
    constexpr int n = Sys::dof_at_compile_time;
    using Energies = EnergiesWithTerms<typename Sys::EnergiesType, n, Effects...>;
    return named_system<System<Energies, n, Sys::inertia>>(Energies{system.energies(), {effects}}, system);
  } else {
    return system;
  }
}

}  // namespace detail

/// A system with effects. Made by scene().
template <class Sys, class... Effects>
class Scene {
 public:
  static constexpr int dof_at_compile_time = Sys::dof_at_compile_time;  ///< n, or Dynamic
  /// Whether any effect has a force, or a state of its own other than the phase of a contact.
  static constexpr bool has_forces = (ForceEffect<Effects, dof_at_compile_time> || ...) ||
                                     ((StateEffect<Effects> && !UnilateralEffect<Effects, dof_at_compile_time>) || ...);
  static constexpr bool has_states = (StateEffect<Effects> || ...);  ///< whether any effect has states of its own
  /// Whether any effect constrains the motion, at least in some phases.
  static constexpr bool has_constraints = (ConstraintEffect<Effects, dof_at_compile_time> || ...);
  static constexpr std::size_t phases_at_compile_time =
      (0 + ... + static_cast<std::size_t>(SwitchingEffect<Effects, dof_at_compile_time>));  ///< effects that switch
  static constexpr bool has_phases = phases_at_compile_time > 0;  ///< whether any effect switches
  /// Whether any effect has friction in a plane, whose Jacobian changes within a step where it is slow.
  static constexpr bool has_plane_friction = ((FrictionEffect<Effects, dof_at_compile_time> && detail::states_of<Effects>() > 1) || ...);
  /// Whether any constraint holds all the time.
  static constexpr bool has_lasting_constraints =
      ((ConstraintEffect<Effects, dof_at_compile_time> && !SwitchingEffect<Effects, dof_at_compile_time>) || ...);
  static constexpr int states_at_compile_time = detail::total<detail::states_of<Effects>()...>();  ///< length of z
  /// Rows of all constraints, or Dynamic.
  static constexpr int constraints_at_compile_time =
      detail::total<detail::constraint_rows_of<Effects, dof_at_compile_time>()...>();
  static_assert((AnyEffect<Effects, dof_at_compile_time> && ...),
                "qdot: something given to scene() is no effect of this system: an effect has a member force(q, qdot, t), "
                "lagrangian_term(q, qdot, t), phi(q, t), velocity_constraint(q, qdot, t) or initial_state() that works "
                "for vectors with as many entries as the system has coordinates");
  static_assert(states_at_compile_time != Dynamic, "qdot: an effect's own state must have a size known at compile time");

  /// The system with terms of effects in T and V.
  using SystemType = decltype(detail::effective_system(std::declval<const Sys&>(), std::declval<const std::tuple<Effects...>&>()));

  Scene(Sys system, Effects... effects)
      : effects_(std::move(effects)...), system_(detail::effective_system(system, effects_)) {
    if constexpr (sizeof...(Effects) > 0) require_fit(detail::zeros<Vector<double, dof_at_compile_time>>(dof()));
  }

  /// The system whose T and V hold the terms of the effects.
  const SystemType& system() const noexcept { return system_; }
  void keep(const detail::KeptLines& lines) { system_.keep(lines); }  ///< as the system has it
  /// A copy whose system is evaluated one way (mechanics/by.hpp).
  Scene by(By way) const {
    Scene other(*this);
    other.keep(detail::KeptLines(*system_.kept_lines(), way));
    return other;
  }
  /// The effects in their order.
  const std::tuple<Effects...>& effects() const noexcept { return effects_; }

  /// Number of coordinates.
  Eigen::Index dof() const noexcept { return system_.dof(); }
  /// As the system has it.
  std::string coordinate_name(Eigen::Index i) const { return system_.coordinate_name(i); }
  /// As the system has it.
  std::string velocity_name(Eigen::Index i) const { return system_.velocity_name(i); }

  /// Rows of each constraint effect, in their order, and of all together; where their types do not say.
  const auto& row_counts() const noexcept
    requires(constraints_at_compile_time == Dynamic)
  {
    return row_counts_;
  }

  /// Initial values of the effects' own states, in the order of the effects.
  Vector<double, states_at_compile_time> initial_states() const {
    Vector<double, states_at_compile_time> z;
    Eigen::Index first = 0;
    detail::for_each(effects_, [&](const auto& e) {
      using E = std::remove_cvref_t<decltype(e)>;
      if constexpr (StateEffect<E>) {
        const Vector<double, detail::states_of<E>()> own = e.initial_state();
        std::copy_n(own.data(), own.size(), z.data() + first);
        first += detail::states_of<E>();
      }
    });
    return z;
  }

 private:
  // Asks each effect whether it fits, and counts the rows of constraints.
  void require_fit(const Vector<double, dof_at_compile_time>& q) {
    detail::for_each(effects_, [&](const auto& e) {
      if constexpr (requires { e.require_fit(q); }) e.require_fit(q);
    });
    row_counts_.count(effects_, q);
  }

  [[no_unique_address]] std::tuple<Effects...> effects_;  // of no size without effects: the scene is then its system
  SystemType system_;
  [[no_unique_address]] detail::RowCounts<constraints_at_compile_time == Dynamic, sizeof...(Effects)> row_counts_;
};

/// The effects' own states at a moment, z; empty for most scenes.
template <class Sc>
using EffectStates = Vector<double, Sc::states_at_compile_time>;

/// A system with the effects that it names, in any order; effects given twice count twice.
///
/// @throws InvalidValue, DimensionError  when an effect does not fit the system, such as a drive of a coordinate that it has not
template <class E, int n, Inertia inertia, class... Effects>
Scene<System<E, n, inertia>, detail::FittedEffect<Effects, n>...> scene(System<E, n, inertia> system, Effects... effects) {
  return {std::move(system), detail::fitted_effect<n>(std::move(effects))...};
}

/// A scene with more effects than it had.
///
/// @throws as above
template <class Sys, class... Effects, class... More>
auto scene(const Scene<Sys, Effects...>& given, More... more) {
  constexpr int n = Sys::dof_at_compile_time;
  using Fuller = Scene<Sys, Effects..., detail::FittedEffect<More, n>...>;
  return std::apply([&](const auto&... effects) {
    if constexpr (detail::has_energy_terms<Sys, Effects...>) {
      return Fuller(detail::named_system<Sys>(given.system().energies().without_terms(), given), effects..., detail::fitted_effect<n>(std::move(more))...);
    } else {
      return Fuller(given.system(), effects..., detail::fitted_effect<n>(std::move(more))...);
    }
  }, given.effects());
}

}  // namespace qdot
