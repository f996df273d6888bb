#pragma once
// SPDX-License-Identifier: MIT
//
// Impacts: what a blow does to velocities.
//
// When a gap φ(q, t) ≥ 0 closes with u⁻ = φ̇ < 0, forces without bound act for no time. Lagrange's equations, integrated over that
// moment, leave the impulses Λ ≥ 0 of the contacts and those of all other constraints. A law gives how much comes back, 0 ≤ e ≤ 1:
//
//     q̇⁺ = q̇⁻ + M⁻¹ (Jᵀ Λ + …),      u⁺ = u⁻ + A Λ,      A = J M⁻¹ Jᵀ  (on the motions that the others leave)
//     Newton     u⁺ ≥ −e u⁻      velocities:   0 ≤ Λ ⟂ u⁺ + e u⁻ ≥ 0
//     Poisson    Λ = Λ_C + Λ_E   impulses:     compression to u ≥ 0 by Λ_C, then expansion by at least Λ_E = e Λ_C
//
// For a single contact the two agree. Closed contacts that approach take the blow together (one complementarity problem), then those
// that this makes approach, until none does. So Newton's cradle passes the blow from ball to ball. In each of these blows
//
//     ΔT = ½ Λᵀ (u⁺ + u⁻) = −½ Σ (1 − eᵢ) Λᵢ |uᵢ⁻| ≤ 0      (Newton).
// Where Poisson's law with different e would let energy grow, the expansion is cut short. After a hundred blows, the rest has e = 0.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/effects/forces.hpp"
#include "qdot/error.hpp"
#include "qdot/mechanics/mass_matrix.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot {

/// How much of a blow comes back.
struct ImpactLaw {
  double e = 0.0;        ///< coefficient of restitution, from 0 (none) to 1 (all)
  bool poisson = false;  ///< of impulses, instead of Newton's of velocities
};

namespace detail {

inline ImpactLaw checked_law(double e, bool poisson) {
  if (!(e >= 0 && e <= 1))
    throw_invalid_value({"a coefficient of restitution must lie between 0 and 1, but is ", std::to_string(e), "; more than 1 would create energy"});
  return {e, poisson};
}

}  // namespace detail

/// Newton's law: the velocity of separation is e times that of approach.
inline ImpactLaw restitution(double e) { return detail::checked_law(e, false); }

/// Poisson's law: the impulse of expansion is e times that of compression.
inline ImpactLaw poisson_restitution(double e) { return detail::checked_law(e, true); }

namespace detail {

// No finite impulse keeps this contact from closing further.
struct NoImpulse {
  Eigen::Index contact;
};

// All blows of contacts with closed gaps: their impulses in total. u is changed to the velocities afterwards; what is
// slower than `still` does not approach.
//
// @throws NoImpulse  where contacts close against each other, as two walls do on what is between them
template <class = void>
Eigen::VectorXd impulses(const Eigen::MatrixXd& A, Eigen::VectorXd& u, const std::vector<ImpactLaw>& laws, const Eigen::VectorXd& still);

}  // namespace detail

/// The change of state of a system without constraints that hits one gap; for event(…).action(…).
template <class Sys, class Gap>
struct Impact {
  static constexpr bool is_barrier = true;  ///< the velocity turns: the motion does not pass g = 0
  Sys system;                               ///< the system that hits
  Gap gap;                                  ///< φ, of q or (q, t)
  ImpactLaw law;                            ///< what becomes of the velocity

  /// Velocities after the blow; nothing where the gap is opening.
  template <int n>
  void operator()(State<n>& s) const {
    const double approach =
        velocity_of([&](const auto& q, const auto& t) { return detail::of_position(gap, q, t); }, s.q, s.qdot, s.t);
    if (approach >= 0) return;
    const Vector<double, n> J = gradient(detail::at_time(gap, s.t), s.q);
    const Vector<double, n> W = detail::solved_with_mass_matrix(system, mass_matrix(system, s.q, s.qdot, s.t), J, s.t);
    s.qdot -= (1 + law.e) * approach / J.dot(W) * W;
  }
};

/// The impact law of one gap φ(q) or φ(q, t) ≥ 0 of a system, by itself: events(event("hit", gap).falling().action(impact(system, gap, law))).
///
/// It keeps bouncing until the impacts accumulate; a contact() in a scene comes to rest, and knows about other constraints.
template <class Sys, class Gap>
Impact<Sys, Gap> impact(Sys system, Gap gap, ImpactLaw law) {
  return {std::move(system), std::move(gap), law};
}

}  // namespace qdot

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template Eigen::VectorXd impulses<void>(const Eigen::MatrixXd&, Eigen::VectorXd&, const std::vector<ImpactLaw>&, const Eigen::VectorXd&);
}  // namespace qdot::detail
#else
#include "qdot/effects/impact.ipp"
#endif
