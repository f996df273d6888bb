#pragma once
// SPDX-License-Identifier: MIT
//
// Dry friction that really sticks.
//
// Coulomb's law gives the force of friction only while something slides. At rest it is whatever force keeps the rest, up to a limit:
//
//     slides (s = ±1)    Q = −s F_k ∂v/∂q̇           F_k the sliding friction, v the sliding velocity, s its sign
//     sticks (s = 0)     v = 0, a constraint        |λ| ≤ F_s, the limit of sticking, F_s ≥ F_k
//
// Each phase is smooth, and ends with an event: sliding where v passes through zero, sticking where |λ| reaches F_s. Then the sliding goes
// against λ. Where v passes through zero and F_s could not hold the system, it slides on to the other side in the same moment.
//
// A velocity of two or three components has friction in a plane (plane_friction.hpp): one bound for all directions. Friction forces are
// numbers or functions of the state (μ m g cos α on an incline). Since they are bounded, friction has no part in an impact.

#include <cmath>
#include <concepts>
#include <string>
#include <type_traits>
#include <utility>

#include "qdot/effects/fit.hpp"
#include "qdot/effects/plane_friction.hpp"

namespace qdot {

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
struct DryFriction : FrictionLaw<Velocity, Sliding, Sticking> {
  template <class S, int n>
  S velocity_constraint(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    return sliding_velocity(q, qdot, t);
  }

  template <class S, int n>
    requires detail::may_take<Sliding, S>
  Vector<S, n> force(const Vector<S, n>& q, const Vector<S, n>& qdot, const Vector<S, 1>& z, const S& t) const {
    const double s = static_cast<double>(innermost_value(z[0]));
    if (s != 1.0 && s != -1.0) return detail::zeros<Vector<S, n>>(q.size());
    const S F = -s * this->sliding_limit(q, qdot, t);
    return gradient(detail::marked<detail::SlopeOfEffect>([&](const auto& u) {
      using D = typename std::remove_cvref_t<decltype(u)>::Scalar;
      return sliding_velocity<D, n>(detail::converted<D>(q), u, D(t));
    }), qdot) * F;
  }

  template <int n>
  void require_fit(const Vector<double, n>& q) const {
    if constexpr (std::is_same_v<Velocity, detail::CoordinateVelocity>)
      detail::require_coordinate(detail::sentence({"the dry friction '", this->name, "'"}), this->v.k, q.size());
  }
  Vector<double, 1> initial_state() const { return Vector<double, 1>(static_cast<double>(FrictionPhase::undecided)); }

  /// This friction for n coordinates: with bounds in a plane where the sliding velocity has several components.
  template <int n>
  auto fitted() const {
    using Q = detail::Point<n>;
    using V = std::remove_cvref_t<decltype(detail::of_state(this->v, std::declval<const Q&>(), std::declval<const Q&>(), 0.0))>;
    constexpr int m = detail::components_of<V>();
    if constexpr (m == 2 || m == 3) return PlaneFriction<Velocity, Sliding, Sticking, m>{{this->name, this->v, this->F_k, this->F_s}};
    else return *this;
  }

 private:
  template <class S, int n>
  [[gnu::always_inline]] S sliding_velocity(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    const auto sliding = detail::of_state(this->v, q, qdot, t);
    constexpr bool is_one_number = std::is_convertible_v<decltype(sliding), S>;
    static_assert(is_one_number,
                  "qdot: the sliding velocity of dry friction must be one number, or a vector of two or three whose size is known at compile time");
    if constexpr (is_one_number) return S(sliding);
    else return S(0.0);
  }
};

/// Coulomb friction against the sliding velocity v, which sticks.
///
/// Its events: "name sticks", "name slips", and, of one number, "name turns" where sliding changes direction without a stop.
///
/// @param v    v(q, qdot) or v(q, qdot, t), linear in qdot, one number or a vector of two or three; or the number of a coordinate
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
    return DryFriction<detail::CoordinateVelocity, Sliding, Sticking>{{std::move(name), {v}, std::move(F_k), std::move(F_s)}};
  } else {
    return DryFriction<Velocity, Sliding, Sticking>{{std::move(name), std::move(v), std::move(F_k), std::move(F_s)}};
  }
}

/// Dry friction with one limit F for sliding and sticking.
template <class Velocity, class Sliding>
auto dry_friction(std::string name, Velocity v, Sliding F) {
  return dry_friction(std::move(name), std::move(v), F, F);
}

/// Coulomb friction in a plane whose bounds are an ellipse, by its half axes along the components of the sliding velocity.
///
/// The force is that of greatest dissipation, −(F_x² v_x, F_y² v_y)/√(F_x² v_x² + F_y² v_y²): not against v where F_x ≠ F_y.
///
/// @param F_k, F_s  half axes while sliding and sticking; F_s is a multiple of F_k, by at least 1
/// @throws InvalidValue  when they are not positive, or F_s is no such multiple
template <class Velocity, int m>
auto dry_friction(std::string name, Velocity v, const Vector<double, m>& F_k, const Vector<double, m>& F_s) {
  const double most = F_k.maxCoeff(), ratio = F_s[0] / F_k[0];
  bool good = ratio >= 1.0 && ratio < 1e300;
  for (int i = 0; i < m; ++i) good = good && F_k[i] > 0.0 && std::abs(F_s[i] - ratio * F_k[i]) <= 1e-12 * F_s[i];
  if (!good)
    detail::throw_invalid_value({"an ellipse of dry friction needs F_k > 0 and F_s = r F_k with one r >= 1, but '", name, "' has F_k[0] = ",
                                 {F_k[0], 6}, ", F_s[0] = ", {F_s[0], 6}, " and F_k[", m - 1, "] = ", {F_k[m - 1], 6}, ", F_s[", m - 1, "] = ",
                                 {F_s[m - 1], 6}, "; give both ellipses the same shape"});
  return dry_friction(std::move(name), detail::StretchedVelocity<Velocity, m>{std::move(v), F_k / most}, most, ratio * most);
}
template <class Velocity, int m>
auto dry_friction(std::string name, Velocity v, const Vector<double, m>& F) {
  return dry_friction(std::move(name), std::move(v), F, F);
}

}  // namespace qdot
