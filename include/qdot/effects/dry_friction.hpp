#pragma once
// SPDX-License-Identifier: MIT
//
// Dry friction that really sticks.
//
// Coulomb's law knows the force of friction only while something slides. At rest it is whatever force keeps the
// rest, up to a limit:
//
//     slides (s = ±1)    Q = −s F_k ∂v/∂q̇           F_k the sliding friction, v the sliding velocity, s its sign
//     sticks (s = 0)     v = 0, a constraint        |λ| ≤ F_s, the limit of sticking, F_s ≥ F_k
//
// Each phase is smooth. What changes the phase is an event: sliding ends when v passes through zero, sticking when |λ|
// reaches F_s; then the sliding goes against λ. If v passes through zero but F_s could not hold the
// system, it slides on to the other side in the same moment.
//
// The friction forces are given, as numbers or functions of the state (μ m g cos α on an incline). Since they are bounded,
// friction has no part in an impact.

#include <concepts>
#include <string>
#include <type_traits>
#include <utility>

#include "qdot/effects/fit.hpp"
#include "qdot/effects/forces.hpp"

namespace qdot {

/// Phases of dry friction, as they stand in z.
enum class FrictionPhase {
  backward = -1,  ///< v < 0
  sticks = 0,     ///< v = 0, kept by a force within its bound
  forward = 1,    ///< v > 0
  undecided = 2   ///< at the start, until the state has been looked at
};

namespace detail {

// q̇_k as a sliding velocity.
struct CoordinateVelocity {
  Eigen::Index k;

  template <int>
  static constexpr bool takes_time = false;
  template <class S, int n>
  S operator()(const Vector<S, n>&, const Vector<S, n>& qdot, const S&) const {
    return qdot[k];
  }
};

}  // namespace detail

/// Dry friction against a velocity v(q, q̇, t), linear in q̇.
template <class Velocity, class Sliding, class Sticking>
struct DryFriction {
  std::string name;  ///< for messages
  Velocity v;        ///< the velocity that it acts against
  Sliding F_k;       ///< force while it slides, a number or of the state
  Sticking F_s;      ///< largest force while it sticks, the same

  template <int n>
  static constexpr bool takes_time = detail::functor_takes_time<n, Velocity, 2>() || detail::functor_takes_time<n, Sliding, 2>() ||
                                     detail::functor_takes_time<n, Sticking, 2>();

  template <class S, int n>
  S velocity_constraint(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    return sliding_velocity(q, qdot, t);
  }

  template <class S, int n>
    requires detail::may_take<Sliding, S>
  Vector<S, n> force(const Vector<S, n>& q, const Vector<S, n>& qdot, const Vector<S, 1>& z, const S& t) const {
    const double s = static_cast<double>(innermost_value(z[0]));
    if (s != 1.0 && s != -1.0) return detail::zeros<Vector<S, n>>(q.size());
    const S F = -s * limit<S>(F_k, q, qdot, t);
    return gradient(detail::marked<detail::SlopeOfEffect>([&](const auto& u) {
      using D = typename std::remove_cvref_t<decltype(u)>::Scalar;
      return sliding_velocity<D, n>(detail::converted<D>(q), u, D(t));
    }), qdot) * F;
  }

  template <int n>
  void require_fit(const Vector<double, n>& q) const {
    if constexpr (std::is_same_v<Velocity, detail::CoordinateVelocity>)
      detail::require_coordinate(detail::sentence({"the dry friction '", name, "'"}), v.k, q.size());
  }
  bool is_active(double phase) const { return phase == static_cast<double>(FrictionPhase::sticks); }
  Vector<double, 1> initial_state() const { return Vector<double, 1>(static_cast<double>(FrictionPhase::undecided)); }

  /// The largest force of sticking, F_s.
  template <int n>
  double sticking_limit(const Vector<double, n>& q, const Vector<double, n>& qdot, double t) const {
    return limit<double>(F_s, q, qdot, t);
  }

 private:
  template <class S, int n>
  [[gnu::always_inline]] S sliding_velocity(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    const auto sliding = detail::of_state(v, q, qdot, t);
    constexpr bool is_one_number = std::is_convertible_v<decltype(sliding), S>;
    static_assert(is_one_number,
                  "qdot: the sliding velocity of dry friction must be one number: its bound is one force. Friction in a plane is not one dry friction for "
                  "each direction, for these fill a square and not Coulomb's circle: take generalized_force() with -F v / sqrt(v*v + v_0*v_0), which creeps "
                  "below v_0");
    if constexpr (is_one_number) return S(sliding);
    else return S(0.0);
  }

  template <class S, class F, int n>
  static S limit(const F& force, const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) {
    if constexpr (std::is_arithmetic_v<F>) {
      return S(static_cast<double>(force));
    } else {
      return detail::of_state(force, q, qdot, t);
    }
  }
};

/// Coulomb friction against the sliding velocity v, which sticks.
///
/// Its events: "name sticks", "name slips", and "name turns" where sliding changes direction without a stop.
///
/// @param v    v(q, qdot) or v(q, qdot, t), linear in qdot; or the number of a coordinate
/// @param F_k  friction force while sliding, ≥ 0: a number, or a function of the state
/// @param F_s  largest friction force while sticking, ≥ F_k
/// @throws InvalidValue  when numbers are negative or F_s < F_k; from scene(), when the system has no such coordinate
template <class Velocity, class Sliding, class Sticking>
auto dry_friction(std::string name, Velocity v, Sliding F_k, Sticking F_s) {
  if constexpr (std::is_arithmetic_v<Sliding> && std::is_arithmetic_v<Sticking>) {
    if (!(F_k >= 0) || !(F_s >= F_k))
      detail::throw_invalid_value({"dry friction needs 0 <= F_k <= F_s, but '", name, "' has F_k = ", std::to_string(F_k), " and F_s = ",
                                   std::to_string(F_s), "; sticking holds at least as much as sliding"});
  }
  if constexpr (std::integral<Velocity>) {
    return DryFriction<detail::CoordinateVelocity, Sliding, Sticking>{std::move(name), {v}, std::move(F_k), std::move(F_s)};
  } else {
    return DryFriction<Velocity, Sliding, Sticking>{std::move(name), std::move(v), std::move(F_k), std::move(F_s)};
  }
}

/// Dry friction with one limit F for sliding and sticking.
template <class Velocity, class Sliding>
auto dry_friction(std::string name, Velocity v, Sliding F) {
  return dry_friction(std::move(name), std::move(v), F, F);
}

}  // namespace qdot
