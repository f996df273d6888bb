#pragma once
// SPDX-License-Identifier: MIT
//
// What a user writes: the two energies. And how the library reads physics off their signatures.
//
//     T(qdot)             constant inertia          M is constant, no velocity terms
//     T(q, qdot)          scleronomic               M(q), centrifugal and Coriolis terms
//     T(q, qdot, t)       rheonomic                 adds ∂²T/∂q̇∂t
//     V(q)   V(q, t)      potential energy
//
// What a signature does not mention is never computed. Where several fit, it is the longest: a T(q, qdot, S t = S(0))
// is given the time, and what comes after q and q̇ is always the time, of the same scalar. The first argument of T is
// q̇ where it is alone and q where it is not. So a T that can be called both ways is ambiguous and is refused.
//
// The functors are generic: they are called with vectors of plain numbers for energies and with vectors of duals for
// derivatives, and return the scalar that they were given. `const auto&` parameters, or `template <class S>`, do that.
// A functor that breaks these rules is refused in English, by the checks at the end of this file.

#include <cmath>
#include <concepts>
#include <cstddef>
#include <utility>

#include "qdot/ad/dual_eigen.hpp"
#include "qdot/ad/vector.hpp"

namespace qdot {

/// The arguments of a kinetic energy.
enum class KineticSignature { velocity, state, state_and_time };

/// The arguments of a potential energy.
enum class PotentialSignature { position, position_and_time };

/// The potential energy of a system that has none.
struct NoPotential {
  template <class Position>
  constexpr auto operator()(const Position&) const {
    return typename Position::Scalar(0);
  }
};

/// Two functors side by side, called as energies.T(…) and energies.V(…).
template <class Kinetic, class Potential>
struct KineticAndPotential {
  Kinetic T;
  Potential V;
};

namespace detail {

template <class E, class S, int n>
concept CallsTOfVelocity = requires(const E& e, const Vector<S, n>& v) { e.T(v); };
template <class E, class S, int n>
concept CallsTOfState = requires(const E& e, const Vector<S, n>& v) { e.T(v, v); };
template <class E, class S, int n>
concept CallsTOfStateAndTime = requires(const E& e, const Vector<S, n>& v, const S& t) { e.T(v, v, t); };
template <class E, class S, int n>
concept CallsVOfPosition = requires(const E& e, const Vector<S, n>& q) { e.V(q); };
template <class E, class S, int n>
concept CallsVOfPositionAndTime = requires(const E& e, const Vector<S, n>& q, const S& t) { e.V(q, t); };

template <class E, class S, int n>
concept CallsT = CallsTOfVelocity<E, S, n> || CallsTOfState<E, S, n> || CallsTOfStateAndTime<E, S, n>;
template <class E, class S, int n>
concept CallsV = CallsVOfPosition<E, S, n> || CallsVOfPositionAndTime<E, S, n>;

// An object with a member T or V is taken as it is; anything else is T itself.
template <int n, class E>
auto energies_object(E energies) {
  if constexpr (CallsT<E, double, n> || CallsV<E, double, n>) {
    return energies;
  } else {
    return KineticAndPotential<E, NoPotential>{std::move(energies), NoPotential{}};
  }
}

template <class E, int n>
consteval KineticSignature kinetic_signature() {
  if constexpr (CallsTOfStateAndTime<E, double, n>) {
    return KineticSignature::state_and_time;
  } else if constexpr (CallsTOfState<E, double, n>) {
    return KineticSignature::state;
  } else {
    return KineticSignature::velocity;
  }
}

template <class E, int n>
consteval PotentialSignature potential_signature() {
  return CallsVOfPositionAndTime<E, double, n> ? PotentialSignature::position_and_time : PotentialSignature::position;
}

// Whether T depends on q; of energies whose type is hidden that is known when the program runs.
template <int n, class E>
constexpr bool kinetic_energy_takes_q(const E& e) {
  if constexpr (requires { { e.kinetic_energy_takes_q() } -> std::same_as<bool>; }) return e.kinetic_energy_takes_q();
  else return kinetic_signature<E, n>() != KineticSignature::velocity;
}

// How many arguments T and V take.
template <class E, int n>
inline constexpr std::size_t kinetic_arguments = 1 + static_cast<std::size_t>(kinetic_signature<E, n>());
template <class E, int n>
inline constexpr std::size_t potential_arguments = 1 + static_cast<std::size_t>(potential_signature<E, n>());

// What T and V return, whatever arguments they take.
template <int n, class E, class Q, class Qdot, class Time>
constexpr auto returned_by_T(const E& e, const Q& q, const Qdot& qdot, const Time& t) {
  if constexpr (kinetic_arguments<E, n> == 1) return e.T(qdot);
  else if constexpr (kinetic_arguments<E, n> == 2) return e.T(q, qdot);
  else return e.T(q, qdot, t);
}
template <int n, class E, class Q, class Time>
constexpr auto returned_by_V(const E& e, const Q& q, const Time& t) {
  if constexpr (potential_arguments<E, n> == 1) return e.V(q);
  else return e.V(q, t);
}
// T and V as the scalar of the arguments.
template <int n, class E, class S>
S kinetic(const E& e, const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) { return returned_by_T<n>(e, q, qdot, t); }
template <int n, class E, class S>
S potential(const E& e, const Vector<S, n>& q, const S& t) { return returned_by_V<n>(e, q, t); }

// Whether they are not noexcept, for a scalar whose functions throw.
template <class E, class S, int n>
inline constexpr bool T_may_throw = !requires(const E& e, const Vector<S, n>& v) { { e.T(v) } noexcept; } &&
                                    !requires(const E& e, const Vector<S, n>& v) { { e.T(v, v) } noexcept; } &&
                                    !requires(const E& e, const Vector<S, n>& v, const S& t) { { e.T(v, v, t) } noexcept; };
template <class E, class S, int n>
inline constexpr bool V_may_throw = !requires(const E& e, const Vector<S, n>& q) { { e.V(q) } noexcept; } &&
                                    !requires(const E& e, const Vector<S, n>& q, const S& t) { { e.V(q, t) } noexcept; };

// The scalar that a call returns is S itself. The longest call that there is, as above.
template <class E, class S, int n>
consteval bool kinetic_returns_scalar() {
  if constexpr (CallsTOfStateAndTime<E, S, n>) {
    return requires(const E& e, const Vector<S, n>& v, const S& t) { { e.T(v, v, t) } -> std::same_as<S>; };
  } else if constexpr (CallsTOfState<E, S, n>) {
    return requires(const E& e, const Vector<S, n>& v) { { e.T(v, v) } -> std::same_as<S>; };
  } else {
    return requires(const E& e, const Vector<S, n>& v) { { e.T(v) } -> std::same_as<S>; };
  }
}

template <class E, class S, int n>
consteval bool potential_returns_scalar() {
  if constexpr (CallsVOfPositionAndTime<E, S, n>) {
    return requires(const E& e, const Vector<S, n>& q, const S& t) { { e.V(q, t) } -> std::same_as<S>; };
  } else {
    return requires(const E& e, const Vector<S, n>& q) { { e.V(q) } -> std::same_as<S>; };
  }
}

// Energies of S whose last argument is a double where it should be S: a time without derivatives, or a parameter.
template <class E, class S, int n>
concept TTakesDouble = !CallsTOfStateAndTime<E, S, n> && requires(const E& e, const Vector<S, n>& v, double t) { e.T(v, v, t); };
template <class E, class S, int n>
concept VTakesDouble = !CallsVOfPositionAndTime<E, S, n> && requires(const E& e, const Vector<S, n>& q, double t) { e.V(q, t); };

// The English of a functor's mistakes. Each message is reported once and stops the ones that follow from it.
template <class E, int n>
consteval bool require_kinetic_energy() {
  using D = Dual<double, 1>;
  static_assert(CallsT<E, double, n>,
                "qdot: the kinetic energy must be callable as T(qdot), T(q, qdot) or T(q, qdot, t), where q and "
                "qdot are vectors with as many entries as the system has coordinates");
  if constexpr (CallsT<E, double, n>) {
    constexpr bool one_reading = !(CallsTOfVelocity<E, double, n> && (CallsTOfState<E, double, n> || CallsTOfStateAndTime<E, double, n>));
    static_assert(one_reading,
                  "qdot: the kinetic energy can be called as T(qdot) and as T(q, qdot), and nothing tells which is meant: leave one of them, "
                  "and name the arguments where there is a pack, T(const auto& q, const auto& qdot)");
    static_assert(!TTakesDouble<E, D, n>,
                  "qdot: what the kinetic energy T takes after q and qdot is the time, which carries derivatives as they do: take "
                  "`const auto& t`, or `S t = S(0)` in a template <class S>; a parameter that is a double is a member or a capture");
    static_assert(TTakesDouble<E, D, n> || CallsT<E, D, n>,
                  "qdot: the kinetic energy T works only for double; derivatives need it for every scalar: take "
                  "`const auto& q, const auto& qdot`, or make it a template <class S>; and for functions say `using std::cos;` and then "
                  "`cos(q[0])`, since std::cos itself takes nothing but numbers");
    if constexpr (one_reading && !TTakesDouble<E, D, n> && CallsT<E, D, n>)
      static_assert(kinetic_returns_scalar<E, D, n>(),
                    "qdot: the kinetic energy T must return the scalar type of its arguments: not a double (take "
                    "`const auto& q` and compute with its entries; a constant is `S(0)`) and not an Eigen "
                    "expression (take `(…).value()` or `.dot()`)");
  }
  return true;
}

template <class E, int n>
consteval bool require_potential_energy() {
  using D = Dual<double, 1>;
  static_assert(CallsV<E, double, n>,
                "qdot: the potential energy must be callable as V(q) or V(q, t); a potential that depends on "
                "velocities belongs into T, and an object with a member T has a member V as well: without potential give T alone, as a function");
  if constexpr (CallsV<E, double, n>) {
    static_assert(!VTakesDouble<E, D, n>,
                  "qdot: what the potential energy V takes after q is the time, which carries derivatives as q does: take `const auto& t`, or "
                  "`S t = S(0)` in a template <class S>; a parameter that is a double is a member or a capture");
    static_assert(VTakesDouble<E, D, n> || CallsV<E, D, n>,
                  "qdot: the potential energy V works only for double; derivatives need it for every scalar: take "
                  "`const auto& q`, or make it a template <class S>; and for functions say `using std::cos;` and then "
                  "`cos(q[0])`, since std::cos itself takes nothing but numbers");
    if constexpr (!VTakesDouble<E, D, n> && CallsV<E, D, n>)
      static_assert(potential_returns_scalar<E, D, n>(),
                    "qdot: the potential energy V must return the scalar type of its argument: not a double (take "
                    "`const auto& q` and compute with its entries; for no potential at all, leave V out) and not "
                    "an Eigen expression (take `(…).value()` or `.dot()`)");
  }
  return true;
}

template <class E, int n>
consteval bool require_energies() {
  static_assert(require_kinetic_energy<E, n>());
  static_assert(require_potential_energy<E, n>());
  return true;
}

}  // namespace detail
}  // namespace qdot
