#pragma once
// SPDX-License-Identifier: MIT
//
// How many degrees of freedom?
// ============================
//
//     n = N − rank J ,      J = ∂φ/∂x        of φ(x, t) = 0, m equations for N coordinates
//
// N counts as if bodies were free: 2 for a point and 3 for a body in the plane, 3 and 6 in space. n = N − m holds only
// for independent constraints: a door with three hinges, or a parallelogram with a third bar, has more equations than
// constraints. J comes exact, by dual numbers, so its rank shows clearly: singular values of independent rows are of
// the size of the geometry, others about 1e-16. Rows are first scaled to length 1, for φ and 1000 φ are the same
// constraint. If the gap between kept and dropped singular values is below 1000, the geometry is close to a singular
// one, and the count doubtful. At a special configuration the rank drops and the count is too high: a stretched
// four-bar linkage, or φ = (x² + y² − l²)² at any point. Counting at two configurations shows it. Velocity constraints
// A(q) q̇ = 0 that are not integrable (integrability.hpp) do not lower n; `rank_of_rows` of J and A stacked tells how
// many velocities are free.

#include <algorithm>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/QR>
#include <Eigen/SVD>

#include "qdot/ad/derivatives.hpp"
#include "qdot/error.hpp"

namespace qdot {

/// What the rows of a constraint Jacobian amount to.
struct ConstraintRank {
  Eigen::Index coordinates = 0;          ///< N, columns
  Eigen::Index equations = 0;            ///< m, rows
  Eigen::Index rank = 0;                 ///< independent ones among them
  Eigen::Index degrees_of_freedom = 0;   ///< N − rank
  std::vector<Eigen::Index> dependent;   ///< rows that add nothing to the rows before them, 0-based
  Eigen::VectorXd singular_values;       ///< of the rows scaled to length 1, largest first
  double gap = std::numeric_limits<double>::infinity();  ///< smallest kept over largest dropped singular value

  /// False when kept and dropped singular values lie so close that the count is doubtful.
  bool clear() const { return gap > 1e3; }
};

namespace detail {

// Rows that Gram and Schmidt, twice through, find in the span of the rows before them.
template <class MatrixXd = Eigen::MatrixXd, class VectorXd = Eigen::VectorXd>  // compiled only where it is called
std::vector<Eigen::Index> rows_in_span_of_earlier(const std::type_identity_t<MatrixXd>& rows, double tolerance) {
  std::vector<Eigen::Index> dependent;
  MatrixXd basis(rows.cols(), 0);
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    VectorXd rest = rows.row(i).transpose();
    for (int pass = 0; pass < 2; ++pass) rest -= basis * (basis.transpose() * rest).eval();
    const double length = rest.norm();
    if (basis.cols() == rows.cols() || length <= tolerance) {
      dependent.push_back(i);
    } else {
      basis.conservativeResize(Eigen::NoChange, basis.cols() + 1);
      basis.rightCols(1) = rest / length;
    }
  }
  return dependent;
}

}  // namespace detail

/// Rank, dependent rows and singular values of a matrix whose rows are constraints on velocities.
///
/// O(m² N). A row of zeros is dependent on nothing at all.
///
/// @param J          m×N
/// @param tolerance  singular values up to this fraction of the largest one count as zero
/// @throws           NonFinite when J is not finite, InvalidValue for a tolerance outside (0, 1)
template <class MatrixXd = Eigen::MatrixXd, class VectorXd = Eigen::VectorXd>  // compiled only where it is called
ConstraintRank rank_of_rows(const std::type_identity_t<MatrixXd>& J, double tolerance = 1e-10) {
  if (!(tolerance > 0.0 && tolerance < 1.0)) {
    throw InvalidValue("rank_of_rows: the tolerance must lie between 0 and 1, but it is " + std::to_string(tolerance) +
                       "; it is a fraction of the largest singular value");
  }
  ConstraintRank result;
  result.equations = J.rows();
  result.coordinates = J.cols();
  result.degrees_of_freedom = J.cols();
  if (J.size() == 0) return result;
  MatrixXd rows = J;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    if (!rows.row(i).allFinite()) {
      const std::string name = detail::sentence({"the gradient of constraint ", i});
      throw NonFinite(name, 0.0, detail::sentence({name, " must be finite, but it is not; choose a configuration where the constraint is smooth"}));
    }
    const double length = rows.row(i).stableNorm();
    if (length > 0.0) rows.row(i) /= length;
  }
  result.singular_values = Eigen::JacobiSVD<MatrixXd>(rows).singularValues();
  const VectorXd& sigma = result.singular_values;
  const double cut = tolerance * sigma[0];
  while (result.rank < sigma.size() && sigma[result.rank] > cut) ++result.rank;
  if (result.rank > 0 && result.rank < sigma.size() && sigma[result.rank] > 0.0) {
    result.gap = sigma[result.rank - 1] / sigma[result.rank];
  }
  result.degrees_of_freedom = result.coordinates - result.rank;
  result.dependent = detail::rows_in_span_of_earlier(rows, tolerance);
  if (result.rank + static_cast<Eigen::Index>(result.dependent.size()) != result.equations) {
    // Close to the cut the order of rows matters; let pivoting choose the rows to keep, so that the numbers agree.
    const Eigen::ColPivHouseholderQR<MatrixXd> qr(rows.transpose());
    result.dependent.clear();
    for (Eigen::Index k = result.rank; k < result.equations; ++k) {
      result.dependent.push_back(qr.colsPermutation().indices()[k]);
    }
    std::sort(result.dependent.begin(), result.dependent.end());
  }
  return result;
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template ConstraintRank rank_of_rows<Eigen::MatrixXd, Eigen::VectorXd>(const Eigen::MatrixXd&, double);
#endif

/// The constraints φ(x) = 0 at a configuration: how many there really are, and which repeat others.
///
/// @param phi  generic function of x that returns the column of m residuals
/// @param x    a configuration that satisfies the constraints, N entries
template <class Constraints, class X>
ConstraintRank constraint_rank(const Constraints& phi, const Eigen::MatrixBase<X>& x, double tolerance = 1e-10) {
  return rank_of_rows(jacobian(phi, x), tolerance);
}

/// The number of degrees of freedom N − rank ∂φ/∂x at a configuration.
///
/// For φ(x, t) fix the time: [&](const auto& x) { return phi(x, t); }; a prescribed motion forbids as much as a fixed one.
template <class Constraints, class X>
Eigen::Index degrees_of_freedom(const Constraints& phi, const Eigen::MatrixBase<X>& x, double tolerance = 1e-10) {
  return constraint_rank(phi, x, tolerance).degrees_of_freedom;
}

}  // namespace qdot
