#pragma once
// SPDX-License-Identifier: MIT
//
// Equilibria: where a system can rest
// ===================================
//
//     ∂L/∂q (q, 0) = 0        Lagrange's equations of an autonomous system with q̇ = 0, q̈ = 0
//
// These are the stationary points of U(q) = −L(q, 0). For T quadratic in q̇, U is V. In a turning frame T keeps a part
// T₀(q) without q̇, and U = V − T₀ holds the centrifugal forces: a bead on a turning hoop rests at cos θ = g/(Ω²R), high
// above the bottom.
//
// Newton's method with the exact Hessian of U, two evaluations of dual numbers a step, goes to whichever equilibrium is
// near, stable or not. A step that does not lower |∂U/∂q|, each force beside its own terms, is halved. The step is the
// shortest solution of the linear equations. So a coordinate that U does not depend on, such as the position of a cart,
// keeps its initial value.

#include <algorithm>
#include <cmath>
#include <limits>
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

// The shortest x with K x = −slope, or with the least residual, without directions of a stiffness below that part of the
// largest. Units in which the stiffnesses of coordinates are far apart are taken out first.
template <class MatrixXd = Eigen::MatrixXd, class VectorXd = Eigen::VectorXd>  // compiled only where it is called
VectorXd newton_step(const std::type_identity_t<MatrixXd>& K, const std::type_identity_t<VectorXd>& slope, double negligible = 0.0) {
  constexpr double far_apart = 1e6;
  VectorXd unit = VectorXd::Ones(K.rows());
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (Eigen::Index i = 0; i < K.rows(); ++i)
    if (const double size = std::abs(K(i, i)); size > 0.0) unit[i] = 1.0 / std::sqrt(size), least = std::min(least, size), most = std::max(most, size);
  if (!(most > far_apart * least)) unit.setOnes();
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> factors;
  if (negligible > 0.0) factors.setThreshold(negligible);
  factors.compute(unit.asDiagonal() * K * unit.asDiagonal());
  return -unit.cwiseProduct(factors.solve(unit.cwiseProduct(slope)));
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template Eigen::VectorXd newton_step<Eigen::MatrixXd, Eigen::VectorXd>(const Eigen::MatrixXd&, const Eigen::VectorXd&, double);
#endif

// Whether the steps of Newton's method still get shorter: rounding does not.
struct Progress {
  double longest = 0.0, shortest = std::numeric_limits<double>::infinity();
  int idle = 0;

  bool stands_still(double step) {
    constexpr double far_below = 1e-9;
    constexpr int many = 8;
    longest = std::max(longest, step);
    idle = step < 0.5 * shortest ? 0 : idle + 1;
    shortest = std::min(shortest, step);
    return (idle > 0 && step <= far_below * longest) || idle >= many;
  }
};

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
  double tolerance = 1e-12;  ///< stop when a step takes no more than that part from the terms Σ |K_ij| |q_j| of any force
};

namespace detail {

// Newton's method on slope(q) = 0 with the slopes K(q) of that. A force is measured by its own terms, Σ |K_ij| (|q_j| + the distance that q_j has come), so
// that units do not matter. Where these are zero but for rounding, the search ends when steps are below 1e-12 and do not get shorter.
template <class VectorXd = Eigen::VectorXd, class Slope, class Stiffness>
VectorXd searched_equilibrium(const Slope& slope_of, const Stiffness& stiffness_of, VectorXd q, const EquilibriumOptions& options) {
  constexpr double soft = 1e-10;  // beside the largest stiffness
  VectorXd slope = slope_of(q), way = VectorXd::Zero(q.size());
  const double largest = slope.cwiseAbs().maxCoeff();
  Progress progress;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    const Eigen::MatrixXd K = stiffness_of(q);
    if (!slope.allFinite() || !K.allFinite()) break;
    VectorXd step = newton_step(K, slope);
    const VectorXd terms = K.cwiseAbs() * (q.cwiseAbs() + way), taken = K.cwiseAbs() * step.cwiseAbs();
    VectorXd next = q + step;
    VectorXd next_slope = slope_of(next);
    const double size = relative_size(step, q);
    const bool is_met = (taken - options.tolerance * terms).maxCoeff() <= 0.0, is_rounding = progress.stands_still(size) && size <= options.tolerance;
    // A short step is not enough: on a slope without a bottom K x = −slope has no solution. Rounding has none either.
    bool is_left = false;
    for (Eigen::Index i = 0; i < q.size(); ++i)
      is_left = is_left || std::abs(slope[i]) > (terms[i] > 0.0 ? 1e-12 * terms[i] : 1e-13 * largest);
    const bool is_solved = !is_left || (K * step + slope).norm() <= 1e-8 * slope.norm();
    if (is_met || is_rounding) {
      if (!is_solved) break;
      return next_slope.norm() < slope.norm() ? next : q;
    }
    const auto shortens = [&] {  // each force beside its own terms
      double before = 0.0, after = 0.0;
      for (Eigen::Index i = 0; i < q.size(); ++i) {
        const double all = terms[i] + taken[i];
        if (!(all > 0.0)) continue;
        before += (slope[i] / all) * (slope[i] / all);
        after += (next_slope[i] / all) * (next_slope[i] / all);
      }
      return after < before;
    };
    if (!shortens()) {  // where next to nothing pulls, rounding of the force may be all that does
      const VectorXd stiff = newton_step(K, slope, soft), before = next;
      next = q + stiff;
      next_slope = slope_of(next);
      if (shortens()) step = stiff;
      else next = before, next_slope = slope_of(next);
    }
    double fraction = 1.0;
    while (!shortens() && fraction > 1e-6) {
      fraction *= 0.5;
      next = q + fraction * step;
      next_slope = slope_of(next);
    }
    if (fraction <= 1e-6) {
      if (is_left && (!is_solved || size > options.tolerance)) break;
      return q;  // the step leads down, but for rounding
    }
    way += fraction * step.cwiseAbs();
    q = next;
    slope = next_slope;
  }
  report_no_equilibrium(q, slope);
}

}  // namespace detail

/// An equilibrium of an autonomous system close to `start`, by Newton's method on ∂L/∂q (q, 0) = 0.
///
/// @param start  where to begin, n
/// @return       q with ∂L/∂q (q, 0) = 0 to rounding, n, in whatever units
/// @throws       InvalidValue when none is found, with the force that is left where the search ended
template <class E, int n, Inertia inertia, class Q>
Vector<double, n> equilibrium_near(const System<E, n, inertia>& system, const Eigen::MatrixBase<Q>& start,
                                   const EquilibriumOptions& options = {}) {
  const auto U = detail::energy_at_rest(system);
  const Vector<double, n> begin = start;
  detail::require_sizes(system, begin, begin);
  const auto slope = [&](const Eigen::VectorXd& q) -> Eigen::VectorXd { return gradient(U, Vector<double, n>(q)); };
  const auto stiffness = [&](const Eigen::VectorXd& q) -> Eigen::MatrixXd {
    const Vector<double, n> at = q;
    return detail::stiffness_at("equilibrium_near", system, U, at, Vector<double, n>(gradient(U, at)));
  };
  return detail::searched_equilibrium(slope, stiffness, Eigen::VectorXd(begin), options);
}

}  // namespace qdot
