#pragma once
// SPDX-License-Identifier: MIT
//
// Impacts: what a blow does to velocities.
//
// When a gap φ(q, t) ≥ 0 closes with u⁻ = φ̇ < 0, forces without bound act for no time. Lagrange's equations,
// integrated over that moment, leave the impulses Λ ≥ 0 of the contacts and those of all other constraints:
//
//     q̇⁺ = q̇⁻ + M⁻¹ (Jᵀ Λ + …),      u⁺ = u⁻ + A Λ,      A = J M⁻¹ Jᵀ  (on the motions that the others leave).
//
// The impulse is finite because a law says how much of the blow comes back, 0 ≤ e ≤ 1:
//
//     Newton     u⁺ ≥ −e u⁻      velocities:   0 ≤ Λ ⟂ u⁺ + e u⁻ ≥ 0
//     Poisson    Λ = Λ_C + Λ_E   impulses:     compression to u ≥ 0 by Λ_C, then expansion by at least Λ_E = e Λ_C
//
// For a single contact the two agree. Where several contacts are closed at once the rule is: those that approach
// take the blow together (one complementarity problem); if that drives others together, they take theirs
// next; until none approaches. So Newton's cradle passes the blow on from ball to ball, and a ball in a corner
// is thrown back by both walls at once. In each of these blows
//
//     ΔT = ½ Λᵀ (u⁺ + u⁻) = −½ Σ (1 − eᵢ) Λᵢ |uᵢ⁻| ≤ 0      (Newton),
//
// so energy never grows, whatever the eᵢ; where Poisson's law with different e would let it grow, the expansion is
// cut short. After a hundred blows that do not come to an end the rest is taken as inelastic, e = 0.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/effects/forces.hpp"
#include "qdot/effects/rows/bounded_minimum.hpp"
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
    throw InvalidValue("a coefficient of restitution must lie between 0 and 1, but is " + std::to_string(e) +
                       "; more than 1 would create energy");
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

// The shortest x ≥ lower with A x + b ≥ 0 and (x − lower)ᵀ(A x + b) = 0, for a symmetric positive semidefinite A.
//
// @throws NoImpulse  when there is none
template <class MatrixXd = Eigen::MatrixXd, class VectorXd = Eigen::VectorXd>  // compiled only where it is called
VectorXd complementary(const std::type_identity_t<MatrixXd>& A, const std::type_identity_t<VectorXd>& b, const std::type_identity_t<VectorXd>& lower) {
  const Eigen::Index k = b.size();
  const VectorXd q = A * lower + b;
  VectorXd length(k);
  for (Eigen::Index i = 0; i < k; ++i) length[i] = A(i, i) > 0 ? std::sqrt(A(i, i)) : 1.0;
  BoundedMinimum p;
  p.A = A;
  p.b = q;
  for (Eigen::Index i = 0; i < k; ++i) {
    p.b[i] /= length[i];
    for (Eigen::Index j = 0; j < k; ++j) p.A(i, j) /= length[i] * length[j];
  }
  p.relative = 1e-13;
  p.size = VectorXd::Constant(k, p.b.cwiseAbs().maxCoeff());
  p.lower = VectorXd::Zero(k);
  p.upper = VectorXd::Constant(k, std::numeric_limits<double>::infinity());
  for (Eigen::Index i = 0; i < k; ++i)
    if (!(A(i, i) > 0)) {
      if (p.b[i] < -p.relative * p.size[i]) throw NoImpulse{i};
      p.upper[i] = 0.0;
    }
  if (!solve(p)) throw NoImpulse{0};
  if (p.contradicting >= 0) throw NoImpulse{p.contradicting};
  std::vector<Eigen::Index> pressed;
  for (Eigen::Index i = 0; i < k; ++i)
    if (p.upper[i] > 0 && std::abs(p.w[i]) <= p.least(i)) pressed.push_back(i);
  if (VectorXd x = p.x(pressed); shorten(x, null_space(part_of(p.A, pressed)), p.lower(pressed), p.upper(pressed))) p.x(pressed) = x;
  VectorXd result = lower;
  for (Eigen::Index i = 0; i < k; ++i) result[i] += p.x[i] / length[i];
  return result;
}

// The impulses of one blow on contacts that all approach, u < 0.
template <class MatrixXd = Eigen::MatrixXd, class VectorXd = Eigen::VectorXd>
VectorXd blow(const std::type_identity_t<MatrixXd>& A, const std::type_identity_t<VectorXd>& u, const std::vector<ImpactLaw>& laws) {
  const Eigen::Index k = u.size();
  const VectorXd none = VectorXd::Zero(k);
  VectorXd lower = none, target = u, compression = none;
  if (std::any_of(laws.begin(), laws.end(), [](const ImpactLaw& law) { return law.poisson; }))
    compression = complementary(A, u, none);
  for (Eigen::Index i = 0; i < k; ++i) {
    const ImpactLaw& law = laws[static_cast<std::size_t>(i)];
    if (law.poisson) {
      lower[i] = (1 + law.e) * compression[i];
    } else {
      target[i] = (1 + law.e) * u[i];
    }
  }
  VectorXd impulse = complementary(A, target, lower);
  // ΔT along the way from compression to the end is a parabola that begins at or below zero.
  const auto gain = [&](const VectorXd& L) { return L.dot(u) + 0.5 * L.dot(A * L); };
  if (!compression.isZero(0.0) && gain(impulse) > 0) {
    double low = 0.0, high = 1.0;
    const VectorXd expansion = impulse - compression;
    for (int i = 0; i < 60; ++i) (gain(compression + 0.5 * (low + high) * expansion) > 0 ? high : low) = 0.5 * (low + high);
    impulse = compression + low * expansion;
  }
  return impulse;
}

// All blows of contacts with closed gaps: their impulses in total. u is changed to the velocities afterwards; what is
// slower than `still` does not approach.
//
// @throws NoImpulse  where contacts close against each other, as two walls do on what is between them
template <class MatrixXd = Eigen::MatrixXd, class VectorXd = Eigen::VectorXd>
VectorXd impulses(const std::type_identity_t<MatrixXd>& A, std::type_identity_t<VectorXd>& u, const std::vector<ImpactLaw>& laws,
                  const std::type_identity_t<VectorXd>& still) {
  constexpr int most_blows = 100;
  const Eigen::Index k = u.size();
  VectorXd total = VectorXd::Zero(k);
  for (int round = 0; round < most_blows; ++round) {
    std::vector<Eigen::Index> struck;
    for (Eigen::Index i = 0; i < k; ++i)
      if (u[i] < -still[i]) struck.push_back(i);
    if (struck.empty()) return total;
    std::vector<ImpactLaw> their_laws;
    for (const Eigen::Index i : struck) their_laws.push_back(laws[static_cast<std::size_t>(i)]);
    VectorXd impulse;
    try {
      impulse = blow(A(struck, struck), u(struck), their_laws);
    } catch (const NoImpulse& of) {
      throw NoImpulse{struck[static_cast<std::size_t>(of.contact)]};
    }
    total(struck) += impulse;
    u += A(Eigen::indexing::all, struck) * impulse;
  }
  const VectorXd rest = complementary(A, u, VectorXd::Zero(k));
  u += A * rest;
  return total + rest;
}

#ifdef QDOT_COMPILED
extern template Eigen::VectorXd impulses<Eigen::MatrixXd, Eigen::VectorXd>(const Eigen::MatrixXd&, Eigen::VectorXd&,
                                                                           const std::vector<ImpactLaw>&, const Eigen::VectorXd&);
#endif

}  // namespace detail

/// The change of state of a system without constraints that hits one gap; for event(…).then(…).
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

/// The impact law of one gap φ(q) or φ(q, t) ≥ 0 of a system, by itself: events(event("hit", gap).falling().then(impact(system, gap, law))).
///
/// It keeps bouncing until the impacts accumulate; a contact() in a scene comes to rest, and knows about other constraints.
template <class Sys, class Gap>
Impact<Sys, Gap> impact(Sys system, Gap gap, ImpactLaw law) {
  return {std::move(system), std::move(gap), law};
}

}  // namespace qdot
