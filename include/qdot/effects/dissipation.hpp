#pragma once
// SPDX-License-Identifier: MIT
//
// Dissipation: what takes energy out.
//
// A Rayleigh function R(q, q̇) ≥ 0 gives the forces Q = −∂R/∂q̇. They take the power −q̇·Q = q̇·∂R/∂q̇ out of the system. That is
// 2R when R is quadratic in q̇ (viscous damping), 3R when it is cubic (quadratic drag), and R when it is of first degree (dry
// friction).
//
// Between two points it is the distance ℓ(q) that matters: a spring-damper with tension f(ℓ, ℓ̇) has Q = −f ∂ℓ/∂q.
// Its energy, if it stores any, belongs into V; so a linear spring-damper plays two roles, a potential and a force.

#include <cmath>
#include <string>
#include <type_traits>
#include <utility>

#include "qdot/effects/fit.hpp"
#include "qdot/effects/forces.hpp"

namespace qdot {

#if defined(__clang__) && defined(__OPTIMIZE__)  // ad/forward/functor_result.hpp says why
#pragma clang attribute push(__attribute__((always_inline)), apply_to = function)
#endif

/// Forces −∂R/∂q̇ of a Rayleigh function.
template <class F>
struct RayleighFunction {
  F R;  ///< of (q, q̇) or (q, q̇, t); half the power lost, where it is quadratic

  template <int n>
  static constexpr bool takes_time = detail::functor_takes_time<n, F, 2>();

  template <class S, int n>
  Vector<S, n> force(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    Vector<S, n> Q = gradient(detail::marked<detail::SlopeOfEffect>([&](const auto& v) {
      using D = typename std::remove_cvref_t<decltype(v)>::Scalar;
      return D(detail::of_state(R, detail::converted<D>(q), v, D(t)));
    }), qdot);
    for (Eigen::Index i = 0; i < Q.size(); ++i) Q[i] = -Q[i];
    return Q;
  }

};

/// The dissipation of the Rayleigh function R(q, qdot) or R(q, qdot, t)   [power].
template <class F>
RayleighFunction<F> rayleigh(F R) {
  return {std::move(R)};
}

/// Viscous damping of single coordinates: Qᵢ = −cᵢ q̇ᵢ.
///
/// @tparam Number  double, or a Pack with the coefficients of several motions
template <int n, class Number = double>
struct ViscousDamping {
  Vector<Number, n> c;  ///< force per velocity of each coordinate, n

  template <int>
  static constexpr bool takes_time = false;

  void require_fit(const Vector<double, n>& q) const {
    if (q.size() != c.size())
      throw DimensionError("viscous damping", static_cast<long>(q.size()), static_cast<long>(c.size()),
                           "give one coefficient for each coordinate of the system, zero where there is no damping");
  }
  template <class S>
  Vector<S, n> force(const Vector<S, n>&, const Vector<S, n>& qdot, const S&) const {
    Vector<S, n> Q(qdot.size());
    for (Eigen::Index i = 0; i < qdot.size(); ++i) Q[i] = -c[i] * qdot[i];
    return Q;
  }
};

/// Viscous damping with one coefficient for each coordinate, n   [force per velocity].
template <class Derived>
auto viscous_damping(const Eigen::MatrixBase<Derived>& c) {
  constexpr int n = Derived::RowsAtCompileTime;
  using Number = typename Derived::Scalar;
  if constexpr (!std::is_arithmetic_v<Number>) {
    return ViscousDamping<n, Number>{c};
  } else {
    for (Eigen::Index i = 0; i < c.size(); ++i)
      if (!(c[i] >= 0) || !std::isfinite(c[i]))
        detail::throw_invalid_value({"a damping coefficient must be finite and not negative, but coefficient ", std::to_string(i), " is ",
                                     std::to_string(c[i]), "; a source of energy is a generalized_force()"});
    return ViscousDamping<n>{c};
  }
}

/// Dry friction of one coordinate, made smooth: Q = −F tanh(q̇/v₀).
struct RegularizedFriction {
  Eigen::Index coordinate;  ///< which one, from 0
  double F;                 ///< force at speeds well above v₀
  double v0;                ///< the speed below which it fades

  template <int>
  static constexpr bool takes_time = false;

  template <int n>
  void require_fit(const Vector<double, n>& q) const {
    detail::require_coordinate("regularized friction", coordinate, q.size());
  }
  template <class S, int n>
  Vector<S, n> force(const Vector<S, n>&, const Vector<S, n>& qdot, const S&) const {
    using std::tanh;
    const S drag = -F * tanh(qdot[coordinate] * (1.0 / v0));  // a quotient that does not wait for q̇
    Vector<S, n> Q = detail::zeros<Vector<S, n>>(qdot.size());
    Q[coordinate] = drag;
    return Q;
  }
};

/// Coulomb friction of magnitude F on a coordinate, regularized over velocities of about v0.
///
/// It never sticks: at rest under a load f < F the coordinate creeps at v0 artanh(f/F). A small v0 is stiff.
///
/// @throws InvalidValue  unless F ≥ 0 and v0 > 0; from scene(), when the system has no such coordinate
inline RegularizedFriction regularized_friction(Eigen::Index coordinate, double F, double v0) {
  if (!(F >= 0) || !(v0 > 0))
    detail::throw_invalid_value({"regularized friction needs F >= 0 and v0 > 0, but F = ", std::to_string(F), " and v0 = ", std::to_string(v0),
                                 "; v0 is the velocity below which friction fades"});
  return {coordinate, F, v0};
}

/// Drag −b |v| v on a point with velocity v.
template <class Position>
auto quadratic_drag(Position r, double b) {
  return force_at_point(std::move(r), [b](const auto& position, const auto& velocity) {
    using S = typename std::remove_cvref_t<decltype(velocity)>::Scalar;
    using std::sqrt;
    (void)position;
    const S v2 = velocity.squaredNorm();
    const S speed = v2 == S(0) ? S(0) : S(sqrt(v2));  // at rest: |v| v has the derivative 0
    return (velocity * S(-b * speed)).eval();
  });
}

/// A spring and a damper in parallel between two points of the system.
template <class P1, class P2>
struct SpringDamper {
  P1 r1;                     ///< one end, of q or (q, t), or fixed
  P2 r2;                     ///< the other
  double k, rest_length, c;  ///< stiffness, length without tension, and damping along the line

  template <int n>
  static constexpr bool takes_time = detail::functor_takes_time<n, P1, 1>() || detail::functor_takes_time<n, P2, 1>();

  /// Distance of the two points.
  template <class S, int n>
  S length(const Vector<S, n>& q, const S& t) const {
    return detail::distance_of(r1, r2, q, t);
  }

  template <class S, int n>
  S potential_term(const Vector<S, n>& q, const S& t) const {
    const S stretch = length(q, t) - S(rest_length);
    return 0.5 * k * stretch * stretch;
  }

  template <class S, int n>
  Vector<S, n> force(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    return pull(damping<S>(), q, qdot, t);
  }
  /// Forces of a tension f(length, rate) between the two points.
  template <class Law, class S, int n>
  Vector<S, n> pull(const Law& f, const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    const auto moving = value_and_velocity_of([&](const auto& x, const auto& s) { return length(x, s); }, q, qdot, t);
    return gradient(detail::marked<detail::SlopeOfEffect>([&](const auto& x) {
      using D = typename std::remove_cvref_t<decltype(x)>::Scalar;
      return length(x, D(t));
    }), q) * S(-f(moving.value, moving.rate));
  }

 private:
  template <class S>
  auto damping() const {
    return [this](const S&, const S& rate) { return S(c * rate); };
  }
};

/// A linear spring (stiffness k, rest length) and damper c between the points r1(q) and r2(q).
///
/// The spring's energy ½ k (ℓ − ℓ₀)² counts as potential energy of the scene; the damper dissipates c ℓ̇².
/// Either point may be a fixed one, given as a plain vector. The points must not coincide.
template <class P1, class P2>
SpringDamper<P1, P2> spring_damper(P1 r1, P2 r2, double k, double rest_length, double c = 0.0) {
  if (!(k >= 0) || !(c >= 0) || !(rest_length >= 0))
    detail::throw_invalid_value({"a spring-damper needs k >= 0, rest_length >= 0 and c >= 0, but k = ", std::to_string(k), ", rest_length = ",
                                 std::to_string(rest_length), ", c = ", std::to_string(c), "; for other laws use tension_between()"});
  return {std::move(r1), std::move(r2), k, rest_length, c};
}

/// Any law of tension between two points.
template <class P1, class P2, class Law>
struct TensionBetween {
  SpringDamper<P1, P2> line;  ///< where it pulls
  Law f;                      ///< tension, of length and rate

  template <int n>
  static constexpr bool takes_time = SpringDamper<P1, P2>::template takes_time<n>;

  template <class S, int n>
  Vector<S, n> force(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    return line.pull(f, q, qdot, t);
  }
};

/// The tension f(length, rate), positive when it pulls, between r1(q) and r2(q): nonlinear springs and dampers.
template <class P1, class P2, class Law>
TensionBetween<P1, P2, Law> tension_between(P1 r1, P2 r2, Law f) {
  return {{std::move(r1), std::move(r2), 0.0, 0.0, 0.0}, std::move(f)};
}

#if defined(__clang__) && defined(__OPTIMIZE__)
#pragma clang attribute pop
#endif

}  // namespace qdot
