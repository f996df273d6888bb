#pragma once
// SPDX-License-Identifier: MIT
//
// Equilibria: where a system can rest
// ===================================
//
// Put q̇ = 0, q̈ = 0 into Lagrange's equations of an autonomous system and only
//
//     ∂L/∂q (q, 0) = 0
//
// is left: the stationary points of U(q) = −L(q, 0). For T quadratic in q̇, U is V. In a turning frame
// T keeps a part T₀(q) without q̇, and U = V − T₀ holds the centrifugal forces (a bead on a turning hoop
// rests at cos θ = g/(Ω²R), high above the bottom).
//
// Newton's method finds them with the exact Hessian of U, two evaluations of dual numbers a step. It
// goes to whichever equilibrium is near, stable or not; a step that does not lower |∂U/∂q| is halved.
// Along a coordinate that U does not mention (cyclic, such as the position of a cart) nothing is to be
// found, and q keeps the value it started with: the step is the shortest solution of the
// linear equations.

#include <algorithm>
#include <cmath>
#include <sstream>
#include <type_traits>

#include <Eigen/Core>
#include <Eigen/QR>

#include "qdot/ad/derivatives.hpp"
#include "qdot/error.hpp"
#include "qdot/mechanics/energy.hpp"
#include "qdot/mechanics/equations/limit_of_slopes.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot {

namespace detail {

struct SlopeAtRest {};  // the tag of perturbations of q at rest

// U(q) = −L(q, 0).
template <class Sys>
auto energy_at_rest(const Sys& system) {
  static_assert(Sys::autonomous,
                "qdot: an equilibrium needs energies that do not mention the time; fix t in T and V, or write them "
                "in coordinates that move along");
  return marked<SlopeAtRest>([&system](const auto& q) {
    using Position = std::decay_t<decltype(q)>;
    using S = typename Position::Scalar;
    const Vector<S, Position::RowsAtCompileTime> rest = Vector<S, Position::RowsAtCompileTime>::Zero(q.size());
    return S(-lagrangian(system, q, rest));
  });
}

// ∂²U/∂q∂q; refused by name where the force is finite and its derivatives are not.
template <class Sys, class Energy, int n>
Matrix<double, n> stiffness_at(const char* who, const Sys& system, const Energy& U, const Vector<double, n>& q, const Vector<double, n>& slope) {
  const Matrix<double, n> K = hessian_or_limit(U, q);
  if (slope.allFinite())
    for (Eigen::Index j = 0; j < K.cols(); ++j)
      for (Eigen::Index i = 0; i < K.cols(); ++i)
        if (!std::isfinite(K(i, j)))
          throw_invalid_value({who, ": the derivatives of the force at rest must be finite, but that on ", system.coordinate_name(i), " has none with ",
                               system.coordinate_name(j), " where ", system.coordinate_name(j), " = ", {q[j], 6},
                               "; look there for the root or the length of something that is zero, and round it off, as sqrt(x*x + e*e) does"});
  return K;
}

// The shortest x with K x = −slope, or with the least residual; the two arguments are of run-time size so that all
// numbers of coordinates share one instantiation.
template <class MatrixXd = Eigen::MatrixXd, class VectorXd = Eigen::VectorXd>  // compiled only where it is called
VectorXd newton_step(const std::type_identity_t<MatrixXd>& K, const std::type_identity_t<VectorXd>& slope) {
  return -Eigen::CompleteOrthogonalDecomposition<MatrixXd>(K).solve(slope);
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template Eigen::VectorXd newton_step<Eigen::MatrixXd, Eigen::VectorXd>(const Eigen::MatrixXd&, const Eigen::VectorXd&);
#endif

// The largest |step_i| / max(1, |q_i|).
template <class VectorXd = Eigen::VectorXd>
double relative_size(const std::type_identity_t<VectorXd>& step, const std::type_identity_t<VectorXd>& q) {
  return (step.array().abs() / q.array().abs().max(1.0)).maxCoeff();
}

template <class VectorXd = Eigen::VectorXd>
[[noreturn]] void report_no_equilibrium(const std::type_identity_t<VectorXd>& q, const std::type_identity_t<VectorXd>& slope) {
  std::ostringstream text;
  text << "equilibrium_near: the generalized force at rest must vanish somewhere near the start, but the search ended at q = ("
       << q.transpose() << ") with dL/dq = (" << -slope.transpose()
       << "); start closer, or ask whether this system can rest at all";
  throw InvalidValue(text.str());
}

}  // namespace detail

/// How `equilibrium_near` searches.
struct EquilibriumOptions {
  int max_iterations = 50;   ///< steps of Newton's method
  double tolerance = 1e-12;  ///< stop when a Newton step moves no coordinate by more than tolerance · max(1, |q_i|)
};

/// An equilibrium of an autonomous system close to `start`, by Newton's method on ∂L/∂q (q, 0) = 0.
///
/// @param start  where to begin, n
/// @return       q with ∂L/∂q (q, 0) = 0 to rounding, n
/// @throws       InvalidValue when none is found, with the force that is left where the search ended
template <class E, int n, Inertia inertia, class Q>
Vector<double, n> equilibrium_near(const System<E, n, inertia>& system, const Eigen::MatrixBase<Q>& start,
                                   const EquilibriumOptions& options = {}) {
  const auto U = detail::energy_at_rest(system);
  Vector<double, n> q = start;
  detail::require_sizes(system, q, q);
  Vector<double, n> slope = gradient(U, q);
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    const Matrix<double, n> K = detail::stiffness_at("equilibrium_near", system, U, q, slope);
    if (!slope.allFinite() || !K.allFinite()) break;
    const Vector<double, n> step = detail::newton_step(K, slope);
    Vector<double, n> next = q + step;
    Vector<double, n> next_slope = gradient(U, next);
    if (detail::relative_size(step, q) <= options.tolerance) {
      // A short step is not enough: on a slope without a bottom K x = −slope has no solution. Rounding has none either.
      const double noise = 1e-12 * K.cwiseAbs().maxCoeff() * std::max(1.0, q.cwiseAbs().maxCoeff());
      if ((K * step + slope).norm() > 1e-8 * slope.norm() && slope.norm() > noise) break;
      return next_slope.norm() < slope.norm() ? next : q;
    }
    double fraction = 1.0;
    while (!(next_slope.norm() < slope.norm()) && fraction > 1e-6) {
      fraction *= 0.5;
      next = q + fraction * step;
      next_slope = gradient(U, next);
    }
    if (fraction <= 1e-6) break;
    q = next;
    slope = next_slope;
  }
  detail::report_no_equilibrium(q, slope);
}

}  // namespace qdot
