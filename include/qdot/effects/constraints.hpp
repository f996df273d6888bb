#pragma once
// SPDX-License-Identifier: MIT
//
// Constraints, as the user writes them.
//
//     holonomic       φ(q, t) = 0            a rod of fixed length, a closed loop, a guided pin
//     prescribed      q_k − s(t) = 0         a drive: its multiplier is the force that the drive needs
//     nonholonomic    a(q, q̇, t) = 0         rolling, skates; linear in q̇, and not the rate of any φ
//
// Each may have several rows and a name, which messages use. A functor that returns a vector of run-time length is given its number of
// rows, holonomic<3>("loop", phi). Then sizes are known to the compiler, and every result is compared with them. Write a constraint so
// that its gradient does not vanish where it is satisfied: x² + y² − l² is good, (x² + y² − l²)² is not. √(x² + y²) − l is as good as the
// first, since rows are scaled before their rank is judged.

#include <string>
#include <utility>

#include "qdot/effects/fit.hpp"
#include "qdot/effects/forces.hpp"

namespace qdot {

#if defined(__clang__) && defined(__OPTIMIZE__)  // ad/forward/functor_result.hpp says why
#pragma clang attribute push(__attribute__((always_inline)), apply_to = function)
#endif

/// φ(q, t) = 0 with a name.
template <class F, int rows = rows_as_returned>
struct HolonomicConstraint {
  std::string name;  ///< for messages
  F phi_of;          ///< φ, of q or (q, t)

  template <int n>
  static constexpr bool takes_time = detail::functor_takes_time<n, F, 1>();

  template <class S, int n>
  auto phi(const Vector<S, n>& q, const S& t) const {
    if constexpr (rows == rows_as_returned) {
      return detail::of_position(phi_of, q, t);
    } else {
      return detail::declared_rows<rows>(detail::of_position(phi_of, q, t), name, t);
    }
  }
};

/// The holonomic constraint φ = 0.
///
/// @tparam rows  their number, to be given where φ returns a vector of run-time length
/// @param phi    φ(q) or φ(q, t): one scalar, or a vector with a row for each condition
/// @throws       ConstraintError where it is evaluated and returns another number of rows
template <int rows = rows_as_returned, class F>
HolonomicConstraint<F, rows> holonomic(std::string name, F phi) {
  return {std::move(name), std::move(phi)};
}

/// a(q, q̇, t) = 0 with a name.
template <class F, int rows = rows_as_returned>
struct NonholonomicConstraint {
  std::string name;  ///< for messages
  F a;               ///< of (q, q̇) or (q, q̇, t), linear in q̇

  template <int n>
  static constexpr bool takes_time = detail::functor_takes_time<n, F, 2>();

  template <class S, int n>
  auto velocity_constraint(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    if constexpr (rows == rows_as_returned) {
      return detail::of_state(a, q, qdot, t);
    } else {
      return detail::declared_rows<rows>(detail::of_state(a, q, qdot, t), name, t);
    }
  }
};

/// The velocity constraint a = 0, linear in q̇.
///
/// @tparam rows  their number, to be given where a returns a vector of run-time length
/// @param a      a(q, qdot) or a(q, qdot, t): one scalar, or a vector with a row for each condition
/// @throws       ConstraintError where it is evaluated and returns another number of rows
template <int rows = rows_as_returned, class F>
NonholonomicConstraint<F, rows> nonholonomic(std::string name, F a) {
  return {std::move(name), std::move(a)};
}

/// q_k = s(t), by a drive.
template <class F, int known = Dynamic>
struct PrescribedCoordinate {
  std::string name;         ///< for messages
  Eigen::Index coordinate;  ///< k, from 0
  F s;                      ///< where it is to be, of t

  template <class S, int n>
  void require_fit(const Vector<S, n>& q) const {
    static_assert(known == Dynamic || n == Dynamic || (known >= 0 && known < n),
                  "qdot: the prescribed coordinate must be one of the system's, counted from 0");
    detail::require_coordinate(detail::sentence({"the drive '", name, "'"}), coordinate, q.size());
  }

  template <class S, int n>
  S phi(const Vector<S, n>& q, const S& t) const {
    return q[coordinate] - detail::of_time(s, t);
  }
};

/// Coordinate k follows s(t); the multiplier is the generalized force of the drive on it.
///
/// @throws InvalidValue  from scene(), when the system has no such coordinate
template <class F>
PrescribedCoordinate<F> prescribed(std::string name, Eigen::Index coordinate, F s) {
  return {std::move(name), coordinate, std::move(s)};
}

/// Coordinate k follows s(t), for a k known to the compiler: prescribed<1>("motor", s). A coordinate that does not exist is a
/// compile error where n is known to the compiler. Otherwise scene() throws InvalidValue.
template <int k, class F>
PrescribedCoordinate<F, k> prescribed(std::string name, F s) {
  return {std::move(name), k, std::move(s)};
}

#if defined(__clang__) && defined(__OPTIMIZE__)
#pragma clang attribute pop
#endif

}  // namespace qdot
