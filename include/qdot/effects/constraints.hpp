#pragma once
// SPDX-License-Identifier: MIT
//
// Constraints, as the user writes them.
//
//     holonomic       φ(q, t) = 0            a rod of fixed length, a closed loop, a guided pin
//     prescribed      q_k − s(t) = 0         a drive: its multiplier is the force that the drive needs
//     nonholonomic    a(q, q̇, t) = 0         rolling, skates; linear in q̇, and not the rate of any φ
//
// Each may have several rows and a name, which messages use. Write a constraint so that its gradient
// does not vanish where it is satisfied: x² + y² − l² is good, (x² + y² − l²)² is not, and √(x² + y²) − l
// is as good as the first, since rows are scaled before their rank is judged.

#include <string>
#include <utility>

#include "qdot/effects/forces.hpp"

namespace qdot {

/// φ(q, t) = 0 with a name.
template <class F>
struct HolonomicConstraint {
  std::string name;
  F phi_of;

  template <class S, int n>
  auto phi(const Vector<S, n>& q, const S& t) const {
    return detail::of_position(phi_of, q, t);
  }
};

/// The holonomic constraint φ = 0.
///
/// @param phi  φ(q) or φ(q, t): one scalar, or a vector with a row for each condition
template <class F>
HolonomicConstraint<F> holonomic(std::string name, F phi) {
  return {std::move(name), std::move(phi)};
}

/// a(q, q̇, t) = 0 with a name.
template <class F>
struct NonholonomicConstraint {
  std::string name;
  F a;

  template <class S, int n>
  auto velocity_constraint(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    return detail::of_state(a, q, qdot, t);
  }
};

/// The velocity constraint a = 0, linear in q̇.
///
/// @param a  a(q, qdot) or a(q, qdot, t): one scalar, or a vector with a row for each condition
template <class F>
NonholonomicConstraint<F> nonholonomic(std::string name, F a) {
  return {std::move(name), std::move(a)};
}

/// q_k = s(t), by a drive.
template <class F>
struct PrescribedCoordinate {
  std::string name;
  Eigen::Index coordinate;
  F s;

  template <class S, int n>
  S phi(const Vector<S, n>& q, const S& t) const {
    return q[coordinate] - s(t);
  }
};

/// Coordinate k follows s(t); the multiplier is the generalized force of the drive on it.
template <class F>
PrescribedCoordinate<F> prescribed(std::string name, Eigen::Index coordinate, F s) {
  return {std::move(name), coordinate, std::move(s)};
}

}  // namespace qdot
