#pragma once
// SPDX-License-Identifier: MIT
//
// Solving with the mass matrix, and saying which direction has no inertia when that fails.
//
// A kinetic energy is positive for every motion, so M is symmetric positive definite and Cholesky's
// M = L Lᵀ solves M x = b without pivoting. Each pivot is what is left of the inertia M_kk after the coordinates before k have
// been let free. It is judged relative to M_kk itself, so that grams beside tonnes do no harm. When nothing is left, the motion
// has a direction that costs no kinetic energy. That direction falls out of the factorization. With M = L D Lᵀ and a bad pivot
// d_k, solve
//
//     Lᵀ x = e_k      then      xᵀ M x = d_k ,
//
// so x, in the user's coordinates, is the offending motion and d_k twice its kinetic energy.
//
// A Lagrangian that is no kinetic energy minus a potential may have a regular M that is not positive
// definite ([[0, 1], [1, 0]]). Such a system is declared by with_indefinite_mass_matrix() and solved with full pivoting.

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/mechanics/energy.hpp"
#include "qdot/mechanics/equations/cholesky.hpp"

namespace qdot {

namespace detail {

// Pivots below this fraction of their diagonal entry count as zero: rounding of a sum of n products.
template <class S>
double singular_pivot(Eigen::Index n) {
  using Innermost = typename innermost<S>::type;
  return 8.0 * static_cast<double>(n) * static_cast<double>(std::numeric_limits<Innermost>::epsilon());
}

inline std::string direction_text(const std::vector<double>& x, const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double weight = std::abs(x[i]);
    if (weight < 1e-9) continue;
    const char* const sign = text.empty() ? (x[i] < 0 ? "-" : "") : x[i] < 0 ? " - " : " + ";
    text += std::abs(weight - 1.0) > 1e-9 ? sentence({sign, {weight, 4}, "*", names[i]}) : sentence({sign, names[i]});
  }
  return text;
}

// Throws an error that names the first entry of M that is not finite, if there is one.
template <class = void>  // compiled only where it is called
[[gnu::cold]] void require_finite_mass(const Eigen::MatrixXd& M, double t, const std::vector<std::string>& names) {
  for (Eigen::Index j = 0; j < M.cols(); ++j)
    for (Eigen::Index i = 0; i < M.rows(); ++i)
      if (!std::isfinite(M(i, j))) {
        const std::string entry = sentence({"M(", names[static_cast<std::size_t>(i)], ", ", names[static_cast<std::size_t>(j)], ")"});
        throw NonFinite(entry, t,
                        sentence({"the mass matrix must be finite, but ", entry, " = ", {M(i, j), 6}, " at t = ", {t, 6},
                                  "; the kinetic energy has no second derivative in the velocities there: check T for a division by "
                                  "zero or a root of zero, and the state for overflow"}));
      }
}

// Throws the error for an M of n coordinates that is zero.
template <class = void>  // compiled only where it is called
[[noreturn, gnu::cold]] void throw_zero_mass_matrix(Eigen::Index n, double t, const std::vector<std::string>& names) {
  throw SingularMassMatrix(sentence({"the mass matrix must be positive definite, but at t = ", {t, 6},
                                     " all of it is zero: T has no terms of second order in the velocities of ", names.front(),
                                     n == 2 ? " and " : " to ", names.back(),
                                     ", so L determines no accelerations; add the kinetic energy, or, if L is meant to be linear in the "
                                     "velocities, write its first-order equations as a FirstOrderSystem "
                                     "(mechanics/first_order_form.hpp) and simulate that"}),
                           t, std::vector<double>(static_cast<std::size_t>(n), 1.0), 0.0);
}

// A motion, its largest weight 1, and its inertia as a fraction of that of its last coordinate.
struct MotionWithInertia {
  std::vector<double> direction;
  double relative_inertia;
};

// The motion of the smallest pivot of M = L D Lᵀ, without pivoting, column by column, up to the first bad one.
template <class = void>  // compiled only where it is called
[[gnu::cold]] MotionWithInertia motion_of_least_pivot(const Eigen::MatrixXd& M) {
  const Eigen::Index n = M.rows();
  Eigen::MatrixXd L(n, n);  // below its diagonal of ones
  Eigen::VectorXd d(n);
  Eigen::Index bad = n - 1;
  double worst = std::numeric_limits<double>::infinity();
  for (Eigen::Index k = 0; k < n; ++k) {
    d[k] = M(k, k);
    for (Eigen::Index j = 0; j < k; ++j) d[k] -= L(k, j) * L(k, j) * d[j];
    const double scale = std::abs(M(k, k)) > 0 ? std::abs(M(k, k)) : 1.0;
    const double relative = d[k] / scale;
    if (relative < worst) {
      worst = relative;
      bad = k;
    }
    if (relative <= singular_pivot<double>(n)) break;
    for (Eigen::Index i = k + 1; i < n; ++i) {
      double s = M(i, k);
      for (Eigen::Index j = 0; j < k; ++j) s -= L(i, j) * L(k, j) * d[j];
      L(i, k) = s / d[k];
    }
  }
  std::vector<double> direction(static_cast<std::size_t>(n), 0.0);
  double* const x = direction.data();
  x[bad] = 1.0;
  for (Eigen::Index i = bad - 1; i >= 0; --i)
    for (Eigen::Index k = i + 1; k <= bad; ++k) x[i] -= L(k, i) * x[k];
  double largest = 0.0;
  for (const double weight : direction) largest = std::max(largest, std::abs(weight));
  for (double& weight : direction) weight /= largest;
  return {std::move(direction), worst};
}

// Whether some motion has a negative kinetic energy, to judge by that of the least pivot.
template <class = void>  // compiled only where it is called
[[gnu::cold]] bool is_indefinite(const Eigen::MatrixXd& M, const MotionWithInertia& motion) {
  if (motion.relative_inertia < -singular_pivot<double>(M.rows())) return true;
  const double* const x = motion.direction.data();
  // A zero pivot in front of a coupled coordinate, as in [[0, 1], [1, 0]], is a sign of both signs.
  for (Eigen::Index i = 0; i < M.rows(); ++i) {
    double momentum = 0.0, scale = 0.0;
    for (Eigen::Index j = 0; j < M.cols(); ++j) {
      momentum += M(i, j) * x[j];
      scale = std::max(scale, std::abs(M(i, j)));
    }
    if (scale > 0.0 && std::abs(momentum) > 1e-6 * scale) return true;
  }
  return false;
}

// Throws the error that says which direction of a symmetric M has no (or a negative) inertia.
template <class Number = double>
[[noreturn, gnu::cold]] void throw_mass_matrix_error(Eigen::MatrixXd M, double t, const std::vector<std::string>& names) {
  require_finite_mass(M, t, names);
  if (M.rows() > 1 && M.isZero(0.0)) throw_zero_mass_matrix(M.rows(), t, names);
  const MotionWithInertia motion = motion_of_least_pivot(M);
  const bool negative = is_indefinite(M, motion);
  const std::string text = sentence({"the mass matrix must be positive definite, but at t = ", {t, 6}, " the motion with velocity along ",
                                     direction_text(motion.direction, names), negative ? " has no positive kinetic energy" : " has no kinetic energy",
                                     " (relative inertia ", {motion.relative_inertia, 6},
                                     negative ? "); check the signs in T, or, if L is meant to have such a mass matrix, say "
                                                "system.with_indefinite_mass_matrix()"
                                              : "); give that motion a mass or an inertia, remove the coordinate, or leave the point "
                                                "where the coordinates degenerate (a pole, r = 0)"});
  if (negative) throw IndefiniteMassMatrix(text, t, motion.direction, motion.relative_inertia);
  throw SingularMassMatrix(text, t, motion.direction, motion.relative_inertia);
}

template <class S, int n>
Eigen::MatrixXd innermost_values(const Matrix<S, n>& M) {
  Eigen::MatrixXd plain(M.rows(), M.cols());
  for (Eigen::Index j = 0; j < M.cols(); ++j)
    for (Eigen::Index i = 0; i < M.rows(); ++i) plain(i, j) = static_cast<double>(innermost_value(M(i, j)));
  return plain;
}

template <class Sys>
std::vector<std::string> coordinate_names(const Sys& system) {
  std::vector<std::string> names;
  for (Eigen::Index i = 0; i < system.dof(); ++i) names.push_back(system.coordinate_name(i));
  return names;
}

// A velocity on which a singular M vanishes, largest weight 1.
template <class S>
std::vector<double> direction_without_inertia(const Matrix<S, Dynamic>& M) {
  const Vector<S, Dynamic> null = Eigen::FullPivLU<Matrix<S, Dynamic>>(M).kernel().col(0);
  const Vector<S, Dynamic> scaled = null / null.cwiseAbs().maxCoeff();
  return std::vector<double>(scaled.data(), scaled.data() + scaled.size());
}

// X with M X = B, for the columns of B.
template <class Sys, class S, int n, int columns>
Matrix<S, n, columns> solved_with_mass_matrix(const Sys& system, const Matrix<S, n>& M, const Matrix<S, n, columns>& B,
                                              const S& t) {
  const auto fail = [&] {
    throw_mass_matrix_error(innermost_values(M), static_cast<double>(innermost_value(t)), coordinate_names(system));
  };
  if constexpr (Sys::inertia == Inertia::positive_definite) {
    if constexpr (n == Dynamic) {  // sizes that may be large
      const Eigen::LLT<Matrix<S, n>> cholesky(M);
      if (!succeeded(cholesky)) fail();
      for (Eigen::Index k = 0; k < M.rows(); ++k) {
        const auto pivot = innermost_value(S(cholesky.matrixLLT()(k, k) * cholesky.matrixLLT()(k, k)));
        if (!(static_cast<double>(pivot) > singular_pivot<S>(M.rows()) * static_cast<double>(innermost_value(M(k, k))))) fail();
      }
      return cholesky.solve(B);
    } else {
      Cholesky<S, n> cholesky;
      if (!cholesky.compute(M) || !(cholesky.smallest_pivot() > singular_pivot<S>(M.rows()))) fail();
      return cholesky.solve(B);
    }
  } else {
    const Eigen::FullPivLU<Matrix<S, n>> lu(M);
    if (!lu.isInvertible()) {
      const std::vector<double> direction = direction_without_inertia(innermost_values(M));
      const double at = static_cast<double>(innermost_value(t));
      throw SingularMassMatrix(sentence({"the mass matrix must be regular, but at t = ", {at, 6}, " it vanishes on velocities along ",
                                         direction_text(direction, coordinate_names(system)),
                                         "; L does not determine that acceleration: remove the coordinate or change L"}),
                               at, direction, 0.0);
    }
    return lu.solve(B);
  }
}

#ifdef QDOT_COMPILED
extern template void throw_mass_matrix_error<double>(Eigen::MatrixXd, double, const std::vector<std::string>&);
#endif

}  // namespace detail
}  // namespace qdot
