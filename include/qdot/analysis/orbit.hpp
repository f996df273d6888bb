#pragma once
// SPDX-License-Identifier: MIT
//
// What is known of a periodic orbit
// =================================
//
//     x(t₀ + T) = x(t₀) ,    M = ∂x(t₀ + T)/∂x(t₀) ,    x = [q; q̇]
//     M ẋ = ẋ ,  ∇h M = ∇h      the orbit begins elsewhere on itself; one for each energy     (nothing depends on the time)
//     M z = z ,  ∇I M = ∇I      translations and rotations z; one for each of their integrals I    (Noether)
//
// A small deviation is multiplied by an eigenvalue μ of the monodromy matrix M in each period: a multiplier (Floquet). Those of
// the lines above are 1 for reasons that say nothing of stability, the *trivial* ones. Each pair makes a Jordan block, which
// rounding would split into 1 ± √ε. So they are taken out of M first. The others decide: all |μ| < 1, deviations
// die out; some |μ| > 1, unstable; none outside the circle and those on it simple, stable to first order. Each μ has a
// radius to which it is known: the condition of μ times rounding and the error of the run, which a second run with
// looser tolerances shows.

#include <complex>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "qdot/integrate/outcome.hpp"
#include "qdot/mechanics/system.hpp"
#include "qdot/error.hpp"

namespace qdot {

/// How a search for a periodic orbit ended.
enum class OrbitOutcome {
  found,        ///< it closes to the tolerance
  not_closed,   ///< no step of Newton's method closes it any further
  equilibrium,  ///< the search led to a place of rest, which has no period
  run_failed    ///< a run did not come to its end; Orbit::run_outcome says why
};

/// The outcome's name, "not_closed".
constexpr std::string_view name(OrbitOutcome outcome) noexcept {
  return detail::name_in({"found", "not_closed", "equilibrium", "run_failed"}, outcome);
}

/// What the multipliers that are not trivial say of an orbit.
enum class OrbitStability {
  asymptotically_stable,  ///< all inside the unit circle
  stable_to_first_order,  ///< none outside, those on the circle simple and away from 1 and −1; or there are none but trivial ones
  not_decided,            ///< none outside, but one on the circle is multiple, 1 or −1 as far as it is known
  unstable                ///< one outside
};

/// The stability in words, "stable to first order".
constexpr std::string_view description(OrbitStability stability) noexcept {
  return detail::name_in({"asymptotically stable", "stable to first order", "not decided to first order", "unstable"}, stability);
}

/// An eigenvalue of the monodromy matrix.
struct Multiplier {
  std::complex<double> value;  ///< eigenvalue of ∂x(T)/∂x(0)
  double radius = 0.0;         ///< it is known to that
  bool trivial = false;        ///< 1 for a reason that says nothing about stability
};

/// One step of Newton's method.
struct OrbitIteration {
  double residual = 0.0;  ///< largest entry of x(t₀ + T) − x(t₀), each beside the extent of its component
  double step = 0.0;      ///< length of the step from here, in the same measure; 0 behind the last
  double fraction = 1.0;  ///< of it that was taken
  double period = 0.0;    ///< T of the guess
};

/// A periodic orbit, or how far the search for it came. x = [q; q̇].
struct Orbit {
  OrbitOutcome outcome = OrbitOutcome::not_closed;         ///< whether it was found
  std::string message;                                     ///< what was found or missed, with the numbers
  Outcome run_outcome = Outcome::completed;                ///< of the last run, "not_differentiable" where an event is only grazed
  double t = 0.0;                                          ///< time of the start
  Eigen::VectorXd x;                                       ///< the start, 2n
  double period = 0.0;                                     ///< T
  double parameter = 0.0;                                  ///< of a family in a parameter
  double energy = 0.0;                                     ///< h = q̇·p − L at the start, whether it is conserved or not
  bool conserves_energy = false;                           ///< whether neighbours of the orbit keep theirs over a period
  Eigen::VectorXd residual;                                ///< x(t₀ + T) − x(t₀), less the advance that was asked for
  std::string worst;                                       ///< the component that closes worst, measured by its extent
  Eigen::VectorXd extent;                                  ///< largest less smallest value of each component in 24 parts of the period
  std::vector<OrbitIteration> history;                     ///< steps of Newton's method
  Eigen::MatrixXd monodromy;                               ///< M, 2n×2n
  std::vector<Multiplier> multipliers;                     ///< largest first; on constraints, of what they allow
  OrbitStability stability = OrbitStability::not_decided;  ///< by the multipliers
  std::vector<std::string> symmetries;                     ///< whose multipliers are trivial: "time and energy", "translation of x1, x2 and its momentum"
  std::vector<std::string> undetermined;                   ///< what the orbit leaves open, each by its largest component: "x" for the place of a cart

  /// Whether it closes within the tolerance.
  bool found() const noexcept { return outcome == OrbitOutcome::found; }
};

/// A periodic orbit, with its start as a state of the system.
template <int n>
struct PeriodicOrbit : Orbit {
  /// A point of it, as a time, coordinates and velocities.
  State<n> start() const { return State<n>{t, x.head(x.size() / 2), x.tail(x.size() / 2)}; }
};

}  // namespace qdot
