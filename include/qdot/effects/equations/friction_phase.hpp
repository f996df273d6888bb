#pragma once
// SPDX-License-Identifier: MIT
//
// Phases of dry friction, and the numbers that bound it; for friction along a line (dry_friction.hpp) and in a plane (plane_friction.hpp).

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
}  // namespace qdot
