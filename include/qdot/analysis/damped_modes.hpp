#pragma once
// SPDX-License-Identifier: MIT
//
// Modes with damping, and stability
// =================================
//
// A solution x = a e^{λt} of ẋ = A x is a mode: a pair λ = −δ ± iω oscillates, a real λ = −1/τ creeps.
//
//     |λ| = ω₀ ,   ζ = δ/ω₀                natural frequency and damping ratio
//     all Re λ < 0                         asymptotically stable, whatever the terms of higher order (Lyapunov's first method)
//     some Re λ > 0                        unstable, whatever they are
//     some Re λ = 0, none is positive      stable in the linear approximation, which decides nothing
//     the same, with a Jordan block        deviations grow like a power of t: a cart that was pushed
//     G(iω) = C (iω − A)⁻¹ B + D           frequency response: ŷ = G û, what is left of y long after u = û e^{iωt} began
//
// A computed λ is known to about ε ‖A‖ times its condition number. If its real part is smaller than that, it counts as
// zero. A is balanced first, so that units do not decide what is small.

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/QR>

#include "qdot/analysis/linear/exponents.hpp"
#include "qdot/analysis/linearization.hpp"

namespace qdot {

/// What the linear approximation says about a state.
enum class Stability {
  asymptotically_stable,           ///< all deviations die out
  stable_in_linear_approximation,  ///< none grows, some last; terms of higher order decide
  drifting,                        ///< some grow like a power of t, such as a velocity that nothing brakes
  unstable                         ///< some grow exponentially
};

/// The outcome in words, "asymptotically stable".
constexpr const char* description(Stability stability) {
  return detail::name_in({"asymptotically stable", "stable in the linear approximation", "drifting", "unstable"}, stability);
}

/// One mode, x = a e^{λt}; a pair of conjugate exponents is one mode, with ω ≥ 0.
struct DampedMode {
  std::complex<double> exponent;   ///< λ = −δ + iω
  double natural_frequency = 0.0;  ///< |λ|   [rad per unit of time]
  double damping_ratio = 0.0;  ///< δ/|λ|: 0 undamped, 1 and −1 without oscillation, negative when it grows; 0 for λ = 0
  Eigen::VectorXcd shape;  ///< of q, n; its largest entry is 1; zero where only an effect's own states move

  double frequency() const { return exponent.imag(); }  ///< ω
  /// Whether ω > 0.
  bool oscillates() const { return exponent.imag() > 0.0; }
};

/// All modes of a linearization.
struct DampedModes {
  std::vector<DampedMode> modes;                                    ///< slowest first: by |λ|
  Eigen::VectorXcd exponents;                                       ///< all λ, N; sorted by imaginary, then by real part
  Stability stability = Stability::stable_in_linear_approximation;  ///< by all of the exponents
  double growth = 0.0;                                              ///< max Re λ
};

namespace detail {

// The sizes of what x is taken from, N: 1 for an effect's own states, whose units are unknown.
template <class L>
Eigen::VectorXd extents(const L& linear) {
  Eigen::VectorXd x = Eigen::VectorXd::Ones(linear.drift.size());
  x.head(linear.positions).setConstant(linear.q.template lpNorm<Eigen::Infinity>());
  x.segment(linear.positions, linear.velocities).setConstant(linear.qdot.template lpNorm<Eigen::Infinity>());
  return x;
}

// The shortest δ with A δ = −drift, as far as there is one.
template <class L>
Eigen::VectorXd step_to_rest(const L& linear) {
  if (linear.drift.size() == 0) return linear.drift;
  return -Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>(linear.A).solve(linear.drift);
}

// Whether row i of the linear equations puts the equilibrium at q = 0. Then what is left of q is rounding, which is no size to
// compare with.
template <class L>
bool rests_at_zero(const L& linear, const Eigen::VectorXd& step, Eigen::Index i) {
  for (Eigen::Index j = 0; j < linear.positions; ++j) {
    if (!(std::abs(linear.A(i, j) * step[j]) > 1e-7 * std::abs(linear.drift[i]))) continue;
    for (std::size_t k = 0; k < linear.coordinates.size(); ++k)
      if (linear.coordinates[k] == linear.states[static_cast<std::size_t>(j)] &&
          !(std::abs(linear.q[static_cast<Eigen::Index>(k)] + step[j]) <= 0.5 * std::abs(step[j])))
        return false;
  }
  return true;
}

// Refuses a state that does not stay: only positions that A does not depend on may change.
template <class L>
void require_staying(const L& linear, const char* who) {
  if (!linear.autonomous)
    throw_invalid_value({who,
                         ": A must be the same at all times, but it changes with t; the exponents of one moment say "
                         "nothing about a motion that is excited "
                         "through its parameters, so simulate it, or fix the time"});
  const double size = std::max({1.0, linear.q.template lpNorm<Eigen::Infinity>(), linear.qdot.template lpNorm<Eigen::Infinity>()});
  const double most = linear.A.template lpNorm<Eigen::Infinity>();
  const Eigen::VectorXd terms = linear.A.cwiseAbs() * extents(linear), to_rest = step_to_rest(linear);
  for (Eigen::Index i = 0; i < linear.drift.size(); ++i) {
    const double of_it = linear.A.col(i).template lpNorm<Eigen::Infinity>(), on_it = std::max(1.0, linear.A.row(i).template lpNorm<Eigen::Infinity>());
    if (i < linear.positions && of_it <= 1e-9 * most) continue;  // cyclic
    if (std::abs(linear.drift[i]) <= 1e-7 * terms[i]) continue;
    if (std::abs(linear.drift[i]) <= 1e-7 * size * on_it && rests_at_zero(linear, to_rest, i)) continue;
    throw_invalid_value({who,
                         ": the state must be an equilibrium or a steady motion, but there ",
                         linear.states[static_cast<std::size_t>(i)],
                         " changes at the rate ",
                         {linear.drift[i], 6},
                         "; take it from equilibrium_near() or steady_motion_near()"});
  }
}

// What the exponents of a linearization say.
template <class E>
Stability stability_of_exponents(const E& all) {
  bool grows = false, lasts = false;
  for (Eigen::Index i = 0; i < all.lambda.size(); ++i) {
    grows = grows || all.grows(i);
    lasts = lasts || all.on_axis(i);
  }
  return grows             ? Stability::unstable
         : any_drifts(all) ? Stability::drifting
         : lasts           ? Stability::stable_in_linear_approximation
                           : Stability::asymptotically_stable;
}

}  // namespace detail

/// The modes about an equilibrium or a steady motion, and its stability.
///
/// O(N³).
///
/// @throws InvalidValue  when the state does not stay, with what changes there and how fast; when A depends on the time
template <class L>
  requires std::is_same_v<L, Linearization>
DampedModes damped_modes(const L& linear) {
  detail::require_staying(linear, "damped_modes");
  const detail::Exponents all = detail::exponents_of(linear.A);
  const Eigen::Index n = linear.q.size(), count = all.lambda.size();
  DampedModes result;
  result.exponents = detail::sorted_exponents(all.lambda);
  result.growth = -std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < count; ++i) {
    const std::complex<double> lambda = all.lambda[i];
    result.growth = std::max(result.growth, lambda.real());
    if (lambda.imag() < 0.0) continue;
    DampedMode mode{lambda, std::abs(lambda), 0.0, linear.W.topRows(n) * all.vectors.col(i)};
    if (mode.natural_frequency > 0.0) mode.damping_ratio = (0.0 - lambda.real()) / mode.natural_frequency;
    Eigen::Index largest = 0;
    for (Eigen::Index j = 1; j < n; ++j)
      if (std::abs(mode.shape[j]) > std::abs(mode.shape[largest])) largest = j;
    const std::complex<double> unit = n > 0 ? mode.shape[largest] : 0.0;
    if (std::abs(unit) > 1e-12 * all.vectors.col(i).cwiseAbs().maxCoeff()) mode.shape /= unit;
    else mode.shape.setZero();
    result.modes.push_back(mode);
  }
  std::stable_sort(result.modes.begin(), result.modes.end(),
                   [](const DampedMode& a, const DampedMode& b) { return a.natural_frequency < b.natural_frequency; });
  result.stability = detail::stability_of_exponents(all);
  return result;
}

/// G(iω) = C (iω − A)⁻¹ B + D, outputs×inputs.
///
/// @param omega  angular frequency   [rad per unit of time]
/// @throws InvalidValue  when ω is not finite, there are no inputs, or iω is an exponent of A: the response then grows without limit
template <class L>
  requires std::is_same_v<L, Linearization>
Eigen::MatrixXcd frequency_response(const L& linear, double omega) {
  using Matrix = Eigen::MatrixXcd;
  if (!std::isfinite(omega))
    detail::throw_invalid_value(
        {"frequency_response: the frequency must be finite, but it is ", omega, "; give an angular frequency"});
  if (linear.inputs.empty())
    throw InvalidValue(
        "frequency_response: there must be an input, but the linearization has none; give it one, as in "
        "linearization(scene, state, input(\"push\", 0))");
  detail::require_staying(linear, "frequency_response");
  const Eigen::Index n = linear.A.rows();
  const auto complex = [](const Eigen::MatrixXd& real) { return Matrix(real.cast<std::complex<double>>()); };
  Matrix shifted = complex(-linear.A);
  for (Eigen::Index i = 0; i < n; ++i) shifted(i, i) += std::complex<double>(0.0, omega);
  Eigen::FullPivLU<Matrix> factors(shifted);
  factors.setThreshold(1e-13);
  if (factors.rank() < n)
    detail::throw_invalid_value({"frequency_response: i omega must be no exponent of A, but there is one at omega = ",
                                 omega, "; add damping, or ask beside the resonance"});
  const Matrix x = factors.solve(complex(linear.B)), through = complex(linear.C) * x;
  return through + complex(linear.D);
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template DampedModes damped_modes<Linearization>(const Linearization&);
extern template Eigen::MatrixXcd frequency_response<Linearization>(const Linearization&, double);
#endif

}  // namespace qdot
