#pragma once
// SPDX-License-Identifier: MIT
//
// Dry friction in a plane: one bound for all directions, Coulomb's circle.
//
//     slides     Q = −F_k (∂v/∂q̇)ᵀ s ,  s = v/|v|      v(q, q̇, t) the sliding velocity, two or three numbers
//     sticks     v = 0, as many constraints            |λ| ≤ F_s
//
// Two frictions along x and y are another law: they fill a square, and a puck that slides between the axes leaves its straight line.
//
// s has no value at v = 0, where sliding begins and ends. So z has a reference direction r, as a velocity w = δ r too slow for the method to resolve, and k:
//
//     u = v + w ,   s = ± u/|u| ,   with the sign of u·r + k|u|² ,        guard  u·r − k|u|²/10
//
// At an onset s is r, along which the acceleration must point. Beyond a stop u changes sign and s does not, so that a step across the stop sees a smooth
// force, and the guard falls through zero. It also does where v has turned by some 85°; then r follows v, and k is 1/|v|.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>
#include <utility>

#include "qdot/effects/equations/friction_phase.hpp"

namespace qdot {

/// Dry friction against a velocity of m = 2 or 3 components, linear in q̇. Made by scene() of dry_friction().
///
/// Its own states z: the phase, w, and kδ.
template <class Velocity, class Sliding, class Sticking, int m>
struct PlaneFriction : FrictionLaw<Velocity, Sliding, Sticking> {
  static_assert(m == 2 || m == 3, "qdot: the sliding velocity of dry friction has one, two or three components");

  /// The sliding velocity, m.
  template <class S, int n>
  Vector<S, m> velocity_constraint(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    return detail::of_state(this->v, q, qdot, t);
  }

  template <class S, int n>
    requires detail::may_take<Sliding, S>
  Vector<S, n> force(const Vector<S, n>& q, const Vector<S, n>& qdot, const Vector<S, 2 + m>& z, const S& t) const {
    const double phase = static_cast<double>(innermost_value(z[0]));
    const bool begins = phase == static_cast<double>(FrictionPhase::begins);
    if (phase != static_cast<double>(FrictionPhase::forward) && !begins) return detail::zeros<Vector<S, n>>(q.size());
    using std::sqrt;
    Vector<S, m> s = velocity_constraint<S, n>(q, qdot, t);
    S square(0.0), along(0.0);
    for (int i = 0; i < m; ++i) {
      s[i] = s[i] + z[1 + i];
      square = square + s[i] * s[i];
      along = along + s[i] * z[1 + i];
    }
    const S F_of_sliding = this->sliding_limit(q, qdot, t);
    const S side = along + z[1 + m] * square;
    const S F = begins ? -F_of_sliding / sqrt(square) : -F_of_sliding * side / sqrt(square * (side * side));  // no comparison for the sign
    return gradient(detail::marked<detail::SlopeOfEffect>([&](const auto& u) {
      using D = typename std::remove_cvref_t<decltype(u)>::Scalar;
      const Vector<D, m> sliding = velocity_constraint<D, n>(detail::converted<D>(q), u, D(t));
      D forward(0.0);
      for (int i = 0; i < m; ++i) forward = forward + D(s[i]) * sliding[i];
      return forward;
    }), qdot) * F;
  }

  /// What stays ≥ 0 while it slides with these states z.
  ///
  /// Behind an onset v grows from 0, and s turns at the rate F_k/(m|v|); an explicit method knows a slow v to its tolerance only. So this is a phase of its
  /// own, until |v| is 10⁴ δ: with s = u/|u|, and without a look for v = 0.
  ///
  /// Noise may keep an explicit method beside v = 0 for ever, so |v| = 30 δ counts as a stop; a guard without that is smooth where v passes through zero.
  template <int n>
  double guard(const Vector<double, n>& q, const Vector<double, n>& qdot, double t, const double* z, bool is_smooth) const {
    constexpr double narrow = 0.1;  // of the cone about r, at the speed 1/k
    const Vector<double, m> w = Eigen::Map<const Vector<double, m>>(z + 1), v_now = velocity_constraint<double, n>(q, qdot, t), u = v_now + w;
    const double length = w.norm();
    if (z[0] == static_cast<double>(FrictionPhase::begins)) return length > 0 ? 1.0 - v_now.norm() / (detail::fastest_onset * length) : 0.0;
    if (length == 0.0) return 0.0;
    const double forward = (u.dot(w) - narrow * z[1 + m] * u.squaredNorm()) / length, least = detail::slowest_slide * length;
    return is_smooth ? forward : std::min(forward, (v_now.squaredNorm() - least * least) / least);
  }

  Vector<double, 2 + m> initial_state() const {
    Vector<double, 2 + m> z = detail::zeros<Vector<double, 2 + m>>(2 + m);
    z[0] = static_cast<double>(FrictionPhase::undecided);
    return z;
  }
};

namespace detail {

// A sliding velocity whose components are stretched, so that an ellipse of bounds becomes a circle.
template <class Velocity, int m>
struct StretchedVelocity {
  Velocity v;
  Vector<double, m> stretch;

  template <int n>
  static constexpr bool takes_time = functor_takes_time<n, Velocity, 2>();
  template <class S, int n>
  Vector<S, m> operator()(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    Vector<S, m> u = of_state(v, q, qdot, t);
    for (int i = 0; i < m; ++i) u[i] = stretch[i] * u[i];
    return u;
  }
};

// How many components a sliding velocity has; 0 where it is one number, or no column.
template <class V>
constexpr int components_of() {
  if constexpr (requires { requires V::ColsAtCompileTime == 1; }) return V::RowsAtCompileTime;
  else return 0;
}

}  // namespace detail
}  // namespace qdot
