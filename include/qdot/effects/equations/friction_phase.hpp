#pragma once
// SPDX-License-Identifier: MIT
//
// What dry friction along a line (dry_friction.hpp) and in a plane (plane_friction.hpp) have in common: phases, a sliding velocity, and its bounds.

#include <string>
#include <type_traits>

#include "qdot/effects/forces.hpp"

namespace qdot {

/// Phases of dry friction, as they stand in z.
enum class FrictionPhase {
  backward = -1,  ///< v < 0; along a line only
  sticks = 0,     ///< v = 0, kept by a force within its bound
  forward = 1,    ///< v > 0; in a plane, whatever the direction
  undecided = 2,  ///< at the start, until the state has been looked at
  begins = 3      ///< in a plane, behind an onset, while v is slow
};

namespace detail {

// Of friction in a plane, in units of w: the speeds where it no longer begins, and where it stops.
inline constexpr double fastest_onset = 1e4, slowest_slide = 30.0;

// A bound of friction, a number or a functor of the state.
template <class S, class F, int n>
S friction_bound(const F& force, const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) {
  if constexpr (std::is_arithmetic_v<F>) return S(static_cast<double>(force));
  else return of_state(force, q, qdot, t);
}

}  // namespace detail

/// What dry friction along a line and in a plane have in common: a name, a sliding velocity and its bounds.
template <class Velocity, class Sliding, class Sticking>
struct FrictionLaw {
  std::string name;  ///< for messages
  Velocity v;        ///< the velocity that it acts against, of (q, q̇) or (q, q̇, t)
  Sliding F_k;       ///< force while it slides, a number or of the state
  Sticking F_s;      ///< largest force while it sticks, a number or of the state

  template <int n>
  static constexpr bool takes_time = detail::functor_takes_time<n, Velocity, 2>() || detail::functor_takes_time<n, Sliding, 2>() ||
                                     detail::functor_takes_time<n, Sticking, 2>();

  /// Whether a phase keeps v = 0.
  bool is_active(double phase) const { return phase == static_cast<double>(FrictionPhase::sticks); }

  /// The force of sliding, F_k.
  template <class S, int n>
  S sliding_limit(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    return detail::friction_bound<S>(F_k, q, qdot, t);
  }
  /// The largest force of sticking, F_s.
  template <int n>
  double sticking_limit(const Vector<double, n>& q, const Vector<double, n>& qdot, double t) const {
    return detail::friction_bound<double>(F_s, q, qdot, t);
  }
};

}  // namespace qdot
