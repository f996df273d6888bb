#pragma once
// SPDX-License-Identifier: MIT
//
// Is a velocity constraint holonomic?
// ===================================
//
//     A(q) q̇ = 0 is holonomic   ⟺   da_i(X, Y) = 0   for all i and all X, Y with A X = A Y = 0, at every q,
//     da_i(X, Y) = Σ_jk (∂a_ij/∂q_k − ∂a_ik/∂q_j) X_k Y_j        (Frobenius: a ∧ da = 0 of one row, a · curl a = 0 in space)
//
// A disk that rolls along a line, ẋ − R θ̇ = 0, integrates to x − R θ = const, and one coordinate can go. A skate on
// ice, −ẋ sin θ + ẏ cos θ = 0, does not: it reaches every place, and needs a multiplier. Two displacements that its
// constraint allows, made in both orders, end apart by one that it forbids. A single constraint in one or two
// coordinates always integrates. An explicit time, A(q, t) q̇ + b(q, t) = 0, is a last coordinate with b as its column.
// Derivatives of A are exact; X, Y come from an orthogonal basis B of its null space, and Bᵀ(da_i)B are evaluated at q
// and at points around it. One counterexample proves "not integrable". Agreement is evidence only, but strong: where A
// is analytic, the condition holds everywhere or fails almost everywhere.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <type_traits>

#include <Eigen/Core>
#include <Eigen/SVD>

#include "qdot/ad/derivatives.hpp"
#include "qdot/ad/vector.hpp"
#include "qdot/error.hpp"
#include "qdot/mechanics/equations/ordinary_size.hpp"

namespace qdot {

/// Where and how sharply `integrability` looks.
struct IntegrabilityOptions {
  int samples = 8;          ///< further points around the given one
  double radius = 0.1;      ///< each coordinate varies by up to radius · max(1, |q_i|)
  double tolerance = 1e-9;  ///< relative to the derivatives of the scaled rows of A
};

/// The answer, with the evidence.
struct Integrability {
  bool holonomic = false;        ///< all the constraints integrate
  Eigen::Index constraints = 0;  ///< independent rows of A
  /// Directions forbidden by A that motion back and forth opens, the rank of the m matrices Bᵀ(da_i)B. With 0 all constraints are holonomic. With m none is,
  /// not even in combination; in between, at most m − opened are.
  Eigen::Index opened = 0;
  double residual = 0.0;         ///< largest |da_i(X, Y)| over allowed unit X, Y, relative to the derivatives of A
  Eigen::VectorXd where;         ///< the point of the largest residual
};

namespace detail {

// One number in (−1, 1) from a counter: deterministic and the same on every machine (splitmix64).
inline double scattered(std::uint64_t k) {
  std::uint64_t z = (k + 1) * 0x9E3779B97F4A7C15ULL;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  z ^= z >> 31;
  return static_cast<double>(z >> 11) * 0x1.0p-52 - 1.0;
}

// Frobenius' condition at q, from the entries of A column by column (m·n) and their derivatives (m·n × n). No template,
// so that all constraints share it.
template <class MatrixXd = Eigen::MatrixXd, class VectorXd = Eigen::VectorXd>  // compiled only where it is called
Integrability frobenius_condition(const std::type_identity_t<VectorXd>& entries, const std::type_identity_t<MatrixXd>& derivatives,
                                  const std::type_identity_t<VectorXd>& q, double tolerance) {
  const Eigen::Index n = q.size(), m = entries.size() / n;
  if (m * n != entries.size() || m == 0) {
    throw DimensionError("each row of A(q)", static_cast<long>(n),
                         static_cast<long>(m == 0 ? entries.size() : entries.size() / m),
                         "give one row for each constraint and one column for each coordinate");
  }
  if (!entries.allFinite() || !derivatives.allFinite()) {
    throw NonFinite("A(q)", 0.0, "A(q) and its derivatives must be finite, but they are not; choose a point where the constraint is smooth");
  }
  MatrixXd rows = entries.reshaped(m, n);
  VectorXd scale = VectorXd::Zero(m);  // rows to length 1; a row of zeros stays
  for (Eigen::Index i = 0; i < m; ++i) {
    const double length = rows.row(i).norm();
    if (length > 0.0) scale[i] = 1.0 / length;
    rows.row(i) *= scale[i];
  }
  const Eigen::JacobiSVD<MatrixXd> svd(rows, Eigen::ComputeFullV);
  Integrability result;
  const VectorXd sigma = svd.singularValues();
  while (result.constraints < sigma.size() && sigma[result.constraints] > 1e-10 * sigma[0]) ++result.constraints;
  const MatrixXd B = svd.matrixV().rightCols(n - result.constraints);

  const Eigen::Index k = B.cols();
  MatrixXd twists(k * k, m);
  double size = 0.0;
  for (Eigen::Index i = 0; i < m; ++i) {
    MatrixXd D(n, n);  // ∂a_ij/∂q_k
    for (Eigen::Index j = 0; j < n; ++j) D.row(j) = scale[i] * derivatives.row(i + j * m);
    size = std::max(size, D.norm());
    const MatrixXd twist = B.transpose() * (D - D.transpose()) * B;
    twists.col(i) = twist.reshaped();
    if (k > 1) result.residual = std::max(result.residual, Eigen::JacobiSVD<MatrixXd>(twist).singularValues()[0]);
  }
  result.where = q;
  if (size > 0.0 && k > 1) {
    result.residual /= size;
    const VectorXd s = Eigen::JacobiSVD<MatrixXd>(twists / size).singularValues();
    while (result.opened < s.size() && s[result.opened] > tolerance) ++result.opened;
  }
  result.holonomic = result.residual <= tolerance;
  return result;
}

#ifdef QDOT_COMPILED_ANALYSIS
extern template Integrability frobenius_condition<Eigen::MatrixXd, Eigen::VectorXd>(const Eigen::VectorXd&, const Eigen::MatrixXd&,
                                                                                    const Eigen::VectorXd&, double);
#endif

struct SlopeOfVelocityRows {};  // the tag of its perturbations

// The condition of Frobenius for a functor A.
template <class Rows>
Integrability frobenius_condition_of(const Rows& A, const Eigen::VectorXd& q, double tolerance) {
  const auto entries = marked<SlopeOfVelocityRows>([&A](const auto& x) {
    using S = std::decay_t<decltype(x[0])>;
    const Matrix<S, Dynamic> rows = A(x);
    Vector<S, Dynamic> column(rows.size());
    std::copy_n(rows.data(), rows.size(), column.data());
    return column;
  });
  const auto both = value_and_jacobian(entries, q);
  return frobenius_condition(both.value, both.jacobian, q, tolerance);
}

}  // namespace detail

/// Whether the velocity constraints A(q) q̇ = 0 are integrable, that is holonomic.
///
/// Frobenius' condition at q and at `samples` points around it; a few evaluations of A on dual numbers each.
/// The rank of A must be the same at all points: choose q where no constraint degenerates.
///
/// @param A  generic function of q that returns an m×n matrix of its scalar (a row vector for one constraint)
/// @param q  a point of interest, n entries
/// @throws   DimensionError when A has not n columns; NonFinite; InvalidValue when the rank of A changes nearby
template <class Rows, class Q>
Integrability integrability(const Rows& A, const Eigen::MatrixBase<Q>& q, const IntegrabilityOptions& options = {}) {
  const Eigen::VectorXd centre = q;
  Integrability worst = detail::frobenius_condition_of(A, centre, options.tolerance);
  for (int sample = 0; sample < options.samples; ++sample) {
    Eigen::VectorXd point = centre;
    for (Eigen::Index i = 0; i < point.size(); ++i) {
      const auto counter = static_cast<std::uint64_t>(sample) * static_cast<std::uint64_t>(point.size()) + static_cast<std::uint64_t>(i);
      point[i] += options.radius * detail::reach_of(std::abs(centre[i])) * detail::scattered(counter);
    }
    const Integrability here = detail::frobenius_condition_of(A, point, options.tolerance);
    if (here.constraints != worst.constraints) {
      throw InvalidValue("integrability: the constraints must keep their rank around q, but it is " +
                         std::to_string(worst.constraints) + " at one point and " + std::to_string(here.constraints) +
                         " at another; choose another q or a smaller radius");
    }
    const Eigen::Index opened = std::max(worst.opened, here.opened);
    if (here.residual > worst.residual) worst = here;
    worst.opened = opened;
  }
  return worst;
}

/// Whether A(q, t) q̇ + b(q, t) = 0 is integrable: a constraint φ(q, t) = 0 in disguise.
///
/// @param A  generic function of (q, t), m×n
/// @param b  generic function of (q, t), m entries (column)
template <class Rows, class Column, class Q>
Integrability integrability(const Rows& A, const Column& b, const Eigen::MatrixBase<Q>& q, double t,
                            const IntegrabilityOptions& options = {}) {
  const auto extended = [&](const auto& x) {
    using S = std::decay_t<decltype(x[0])>;
    const Eigen::Index n = x.size() - 1;
    const Vector<S, Dynamic> position = x.head(n);
    const S time = x[n];
    const Matrix<S, Dynamic> rows = A(position, time);
    const Vector<S, Dynamic> column = b(position, time);
    Matrix<S, Dynamic> joined(rows.rows(), rows.cols() + 1);
    joined << rows, column;
    return joined;
  };
  Eigen::VectorXd x(q.size() + 1);
  x << q, t;
  return integrability(extended, x, options);
}

}  // namespace qdot
