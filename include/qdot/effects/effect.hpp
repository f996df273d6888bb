#pragma once
// SPDX-License-Identifier: MIT
//
// What an effect is: all of a scene but T and V, an object with one or more of these member functions, its roles.
//
//     potential_term(q, t), lagrangian_term(q, qdot, t)      potential V + term, Lagrangian L + term
//     force(q, qdot, t)                                      generalized force, M q̈ = rhs + Q
//     force(q, qdot, z, t), state_rate(q, qdot, z, t),       own states z, of a controller or a motor: Q, ż, and z at the start,
//     initial_state()                                        whose length is the number of states
//     phi(q, t)                                              holonomic, φ = 0: M q̈ = rhs + Q + Jᵀλ, J = ∂φ/∂q
//     velocity_constraint(q, qdot, t)                        nonholonomic, a(q, q̇, t) = 0, linear in q̇, J = ∂a/∂q̇
//     is_active(z[0])                                        a constraint in some phases only; the phase is constant between events
//     takes_time<n>, require_fit(q)                          false: no functor takes the time; throws, if it can't act on such a q
//
// q, qdot, z are vectors of any scalar, t is that scalar, and a role returns that scalar or a vector of it. The scene's equations are
// assembled at compile time from the roles that its effects have, and no others. So a new effect is one new type, in the library or in
// a user's file, and nothing else changes.

#include <concepts>
#include <string>
#include <type_traits>
#include <utility>

#include "qdot/ad/dual_eigen.hpp"
#include "qdot/ad/forward/functor_result.hpp"
#include "qdot/ad/vector.hpp"

namespace qdot {

namespace detail {

template <int n>
using Point = Vector<double, n>;

// Whether a functor of q, or of q and q̇, asks for the time as well. A member takes_time<n> of the functor decides, if it has one; a plain
// number does not ask for it.
template <int n, class F, int vectors>
consteval bool functor_takes_time() {
  using Q = Point<n>;
  if constexpr (requires { F::template takes_time<n>; }) {
    return F::template takes_time<n>;
  } else if constexpr (requires { F::RowsAtCompileTime; }) {
    return false;
  } else if constexpr (vectors == 0) {
    return detail::is_callable<const F&, const double&>;
  } else if constexpr (vectors == 1) {
    return detail::is_callable<const F&, const Q&, const double&>;
  } else {
    return detail::is_callable<const F&, const Q&, const Q&, const double&>;
  }
}

template <class Effect>
std::string constraint_name(const Effect& e) {
  if constexpr (requires { e.name; }) return e.name;
  else return "constraint";
}

#if defined(__clang__) && defined(__OPTIMIZE__)  // ad/forward/functor_result.hpp says why
#pragma clang attribute push(__attribute__((always_inline)), apply_to = function)
#endif

template <class Result>
concept HasRows = requires { Result::RowsAtCompileTime; };

template <class Result>
constexpr void require_rows() {
  static_assert(require_numbers<Result>());
  if constexpr (HasRows<Result>)
    static_assert(Result::ColsAtCompileTime == 1, "qdot: a constraint must return one scalar, or a column with a row for each condition");
}

// φ or a as a vector: a single constraint may be returned as a plain scalar.
template <class Result>
auto as_rows(const Result& result) {
  require_rows<Result>();
  if constexpr (HasRows<Result>) {
    return Vector<typename Result::Scalar, Result::RowsAtCompileTime>(result);
  } else {
    return Vector<Result, 1>(result);
  }
}

#if defined(__clang__) && defined(__OPTIMIZE__)
#pragma clang attribute pop
#endif

}  // namespace detail

/// Adds to the potential energy of n coordinates.
template <class Effect, int n>
concept PotentialEffect = requires(const Effect& e, const detail::Point<n>& q, double t) { e.potential_term(q, t); };

/// Adds a term to the Lagrangian of n coordinates.
template <class Effect, int n>
concept LagrangianEffect = requires(const Effect& e, const detail::Point<n>& q, double t) { e.lagrangian_term(q, q, t); };

/// Carries a state of its own, z.
template <class Effect>
concept StateEffect = requires(const Effect& e) {
  e.initial_state();
  { std::remove_cvref_t<decltype(e.initial_state())>::RowsAtCompileTime } -> std::convertible_to<int>;
};

/// Applies a generalized force that depends on position, velocity and time.
template <class Effect, int n>
concept ForceEffect = requires(const Effect& e, const detail::Point<n>& q, double t) { e.force(q, q, t); };

/// Constrains positions, φ(q, t) = 0.
template <class Effect, int n>
concept HolonomicEffect = requires(const Effect& e, const detail::Point<n>& q, double t) { e.phi(q, t); };

/// Constrains velocities, a(q, q̇, t) = 0, linear in q̇.
template <class Effect, int n>
concept NonholonomicEffect =
    requires(const Effect& e, const detail::Point<n>& q, double t) { e.velocity_constraint(q, q, t); };

/// Restricts the motion, in positions or in velocities.
template <class Effect, int n>
concept ConstraintEffect = HolonomicEffect<Effect, n> || NonholonomicEffect<Effect, n>;

/// A constraint that is there in some phases and absent in others; the first of its own states is the phase, and all stay as they are between events.
template <class Effect, int n>
concept SwitchingEffect = ConstraintEffect<Effect, n> && requires(const Effect& e, double phase) {
  { e.is_active(phase) } -> std::convertible_to<bool>;
  e.initial_state();
};

/// φ ≥ 0: a contact, an end stop, a rope. Active in phase 1, where φ = 0 is kept by a force λ ≥ 0; reached with an impact.
template <class Effect, int n>
concept UnilateralEffect = SwitchingEffect<Effect, n> && HolonomicEffect<Effect, n> && requires(const Effect& e) { e.law; };

/// Dry friction: active in phase 0, where it sticks.
template <class Effect, int n>
concept FrictionEffect = SwitchingEffect<Effect, n> && NonholonomicEffect<Effect, n>;

/// Plays at least one role in a system of n coordinates.
template <class Effect, int n>
concept AnyEffect = PotentialEffect<Effect, n> || LagrangianEffect<Effect, n> || ForceEffect<Effect, n> || StateEffect<Effect> ||
                    ConstraintEffect<Effect, n>;

namespace detail {

template <class Effect>
constexpr int states_of() {
  if constexpr (StateEffect<Effect>) {
    return std::remove_cvref_t<decltype(std::declval<const Effect&>().initial_state())>::RowsAtCompileTime;
  } else {
    return 0;
  }
}

// Rows that a constraint effect contributes; Dynamic when its functor returns a vector of run-time length.
template <class Effect, int n>
constexpr int constraint_rows_of() {
  if constexpr (HolonomicEffect<Effect, n>) {
    using Result = decltype(as_rows(std::declval<const Effect&>().phi(std::declval<const Point<n>&>(), 0.0)));
    return Result::RowsAtCompileTime;
  } else if constexpr (NonholonomicEffect<Effect, n>) {
    using Result = decltype(as_rows(
        std::declval<const Effect&>().velocity_constraint(std::declval<const Point<n>&>(), std::declval<const Point<n>&>(), 0.0)));
    return Result::RowsAtCompileTime;
  } else {
    return 0;
  }
}

template <int... counts>
constexpr int total() {
  return ((counts == Dynamic) || ...) ? Dynamic : (0 + ... + counts);
}

}  // namespace detail
}  // namespace qdot
