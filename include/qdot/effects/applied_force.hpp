#pragma once
// SPDX-License-Identifier: MIT
//
// Accelerations under a generalized force, at the speed of those without.
//
// At one state a force Q is n numbers, and numbers are forces of a potential: −Q·q with constant Q has the gradient −Q, whatever
// made the force. So M q̈ = rhs + Q is solved by the evaluations that solve M q̈ = rhs (mechanics/straight_line.hpp,
// graded_evaluation.hpp), given V − Q·q in place of V. The value of that potential means nothing; nobody reads it.

#include <type_traits>

#include "qdot/effects/scene.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"

namespace qdot::detail {

// The energies of a system with −Q·q added to V, in the system's own signatures. Flattened: the compiler must see through to the
// user's functors.
template <class E, int n>
struct EnergiesUnderForce {
  const E& energies;
  const double* Q;

  template <class S>
    requires(kinetic_signature<E, n>() == KineticSignature::velocity)
  [[gnu::flatten]] S T(const Vector<S, n>& qdot) const {
    return energies.T(qdot);
  }
  template <class S>
    requires(kinetic_signature<E, n>() == KineticSignature::state)
  [[gnu::flatten]] S T(const Vector<S, n>& q, const Vector<S, n>& qdot) const {
    return energies.T(q, qdot);
  }
  template <class S>
    requires(kinetic_signature<E, n>() == KineticSignature::state_and_time)
  [[gnu::flatten]] S T(const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) const {
    return energies.T(q, qdot, t);
  }
  template <class S>
    requires(potential_signature<E, n>() == PotentialSignature::position)
  [[gnu::flatten]] S V(const Vector<S, n>& q) const {
    return energies.V(q) - work(q);
  }
  template <class S>
    requires(potential_signature<E, n>() == PotentialSignature::position_and_time)
  [[gnu::flatten]] S V(const Vector<S, n>& q, const S& t) const {
    return energies.V(q, t) - work(q);
  }

  bool replays() const
    requires GoesByList<E>
  {
    return energies.replays();
  }

 private:
  template <class S>
  S work(const Vector<S, n>& q) const {
    if constexpr (n != Dynamic && n <= straight_line_limit) {
      S sum(0.0);
      unroll<n>([&](auto i) __attribute__((always_inline)) { sum += Q[i] * q[i]; });
      return sum;
    } else {
      S sum(0.0);
      for (Eigen::Index i = 0; i < q.size(); ++i) sum += Q[i] * q[i];
      return sum;
    }
  }
};

// q̈ from M q̈ = rhs + Q. Where Q is not finite, `blame()` is called first, and may throw.
template <class E, int n, Inertia I, class Blame>
Vector<double, n> acceleration_under_force(const System<E, n, I>& system, const Vector<double, n>& q, const Vector<double, n>& qdot,
                                           double t, const Vector<double, n>& Q, const Blame& blame) {
  if constexpr (I == Inertia::positive_definite && !HasShorterWay<E>) {
    const EnergiesUnderForce<E, n> forced{system.energies(), Q.data()};
    Vector<double, n> a = Vector<double, n>::Zero(q.size());
    if constexpr (HasClosedForm<E> && straight_line_pays) {
      if (system.energies().acceleration_in_closed_form_under_force(q.data(), qdot.data(), t, Q.data(), a.data())) return a;
    } else if constexpr (straight_line_pays && n >= 1 && n <= straight_line_limit) {
      if (straight_line_acceleration<n>(forced, q.data(), qdot.data(), t, a.data())) return a;
    }
    if constexpr (graded_pays<n>) {
      if (q.size() <= graded_limit<n> && graded_acceleration<n>(forced, q, qdot, t, singular_pivot<double>(q.size()), a)) return a;
    }
  }
  if (!Q.allFinite()) blame();
  const Vector<double, n> force = lagrange_rhs<n>(system.energies(), q, qdot, t) + Q;
  const Vector<double, n> a = solved_with_mass_matrix(system, kinetic_hessian<n>(system.energies(), q, qdot, t), force, t);
  require_finite_acceleration(system, a, q, qdot, t);
  return a;
}

}  // namespace qdot::detail
