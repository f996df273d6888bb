#pragma once
// SPDX-License-Identifier: MIT
//
// Solving for accelerations and multipliers together:
//
//     M q̈ − Jᵀ λ = f         Newton's law with the constraint forces Jᵀλ
//        J q̈     = γ         the constraints, differentiated
//
// Gauss's principle says what q̈ is: of all accelerations that satisfy the constraints, the one nearest to the
// free a₀ = M⁻¹ f in the metric of M. With M = L Lᵀ, B = J L⁻ᵀ and d = Lᵀ(q̈ − a₀) that is the shortest d with
//
//     B d = γ − J a₀ ,       and then  d = Bᵀ λ ,   (B Bᵀ) λ = γ − J a₀ .
//
// Rows of B are scaled to length one first, so that a constraint in millimetres counts as much as one in
// kilometres. Then:
//
//   regular     B Bᵀ (the Schur complement J M⁻¹ Jᵀ) has a Cholesky factor with sound pivots. The fast way.
//   redundant   some rows depend on others. Orthogonal decompositions give the shortest d, and the
//               multipliers of least norm; the motion is as unique as ever, only the split of the forces is not.
//   idle        a row of zeros that asks for nothing (a contact that is open) takes no part; its multiplier is zero.
//   massless    M alone is singular, but the constraints determine the coordinates without inertia. Then the
//               whole matrix is factored with full pivoting.
//
// The rank cut-off, by default 1e-5 of a row's length, is a decision and not a rounding unit: at a configuration
// where constraints become dependent a smaller one takes noise for information. Contradicting rows are an error.

#include <Eigen/LU>

#include <algorithm>
#include <limits>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "qdot/effects/constraint_rows.hpp"
#include "qdot/mechanics/mass_matrix.hpp"

namespace qdot {

/// Accelerations and multipliers, M q̈ = f + Jᵀλ.
template <int n, int m>
struct ConstrainedSolution {
  Vector<double, n> qddot;
  Vector<double, m> lambda;       ///< Jᵀλ is the force of the constraints on the system
  Eigen::Index rank = 0;          ///< of the constraints; below their number when some are redundant
  double smallest_pivot = 1.0;    ///< of the scaled J M⁻¹ Jᵀ, squared sine of the worst row's angle to those before it; by sparse factors about that
};

/// Relative size below which a row of J counts as dependent on the others.
inline constexpr double default_rank_cutoff = 1e-5;

namespace detail {

// Orthonormal columns Q and coefficients C with A = Q C, up to what is smaller than the cut-off: Gram and Schmidt's
// method, largest remaining column first, each made orthogonal twice. Of columns that are equally long but for rounding the
// first is taken: what the cut-off drops of the others must not change from one evaluation to the next, or steps shrink to nothing.
struct OrthogonalColumns {
  Eigen::MatrixXd Q, C;
};
inline constexpr double clearly_longer = 1.02;  // squared
template <class = void>  // compiled only where it is called
OrthogonalColumns orthogonal_columns(const Eigen::MatrixXd& A, double cutoff, bool pivoted) {
  Eigen::MatrixXd left = A, Q(A.rows(), A.cols());
  Eigen::Index rank = 0;
  double largest = 0.0;
  while (rank < std::min(A.rows(), A.cols())) {
    Eigen::Index next = rank;
    if (pivoted) {
      for (Eigen::Index j = next = 0; j < A.cols(); ++j)
        if (left.col(j).squaredNorm() > clearly_longer * left.col(next).squaredNorm()) next = j;
    }
    Eigen::VectorXd q = left.col(next);
    const double length = q.norm();
    if (rank == 0) largest = length;
    if (length <= cutoff * largest) break;  // NaN goes on, and is found in the result
    for (Eigen::Index k = 0; k < rank; ++k) q -= Q.col(k).dot(q) * Q.col(k);
    Q.col(rank) = q / q.norm();
    for (Eigen::Index j = 0; j < A.cols(); ++j) left.col(j) -= Q.col(rank).dot(left.col(j)) * Q.col(rank);
    left.col(next).setZero();
    ++rank;
  }
  OrthogonalColumns result{Q.leftCols(rank), Eigen::MatrixXd(rank, A.cols())};
  for (Eigen::Index j = 0; j < A.cols(); ++j)
    for (Eigen::Index k = 0; k < rank; ++k) result.C(k, j) = Q.col(k).dot(A.col(j));
  return result;
}

// The shortest d with B d = g for rows B that depend on each other, and the shortest λ with d = Bᵀλ. With Bᵀ = Q C and
// Cᵀ = Z S, both with orthonormal columns and S upper triangular:  S c = Zᵀ g,  d = Q c,  Sᵀ w = c,  λ = Z w.
//
// Written out, since Eigen's complete orthogonal decomposition was most of the time to compile a constrained system.
struct LeastNorm {
  Eigen::VectorXd d, lambda, miss;
  Eigen::Index rank;
};
template <class = void>
LeastNorm least_norm(const Eigen::MatrixXd& Bt, const Eigen::VectorXd& g, double cutoff) {
  const OrthogonalColumns columns = orthogonal_columns(Bt, cutoff, true);
  const Eigen::Index rank = columns.Q.cols();
  const OrthogonalColumns rows = orthogonal_columns(columns.C.transpose(), 0.0, false);
  const Eigen::MatrixXd& S = rows.C;
  Eigen::VectorXd c(rank), w(rank), d = Eigen::VectorXd::Zero(Bt.rows()), lambda = Eigen::VectorXd::Zero(Bt.cols());
  for (Eigen::Index i = rank; i-- > 0;) {
    double sum = rows.Q.col(i).dot(g);
    for (Eigen::Index j = i + 1; j < rank; ++j) sum -= S(i, j) * c[j];
    c[i] = sum / S(i, i);
  }
  for (Eigen::Index i = 0; i < rank; ++i) {
    double sum = c[i];
    for (Eigen::Index j = 0; j < i; ++j) sum -= S(j, i) * w[j];
    w[i] = sum / S(i, i);
    d += c[i] * columns.Q.col(i);
  }
  for (Eigen::Index i = 0; i < rank; ++i) lambda += w[i] * rows.Q.col(i);
  Eigen::VectorXd miss(g.size());
  for (Eigen::Index i = 0; i < g.size(); ++i) miss[i] = Bt.col(i).dot(d) - g[i];
  return {std::move(d), std::move(lambda), std::move(miss), rank};
}

[[noreturn]] inline void throw_contradiction(const std::vector<std::string>& names, const Eigen::VectorXd& miss, Eigen::Index rank,
                                             double t) {
  Eigen::Index worst = 0;
  const double most = miss.cwiseAbs().maxCoeff(&worst);
  const std::string& name = names[static_cast<std::size_t>(worst)];
  throw ConstraintError(name, t, most,
                        "constraints must not contradict each other, but at t = " + std::to_string(t) + " only " +
                            std::to_string(rank) + " of " + std::to_string(miss.size()) + " are independent and '" + name +
                            "' asks for an acceleration that the others exclude (by " + std::to_string(most) +
                            "); remove one of the dependent constraints, or make their explicit times agree");
}

// Accelerations (first) and multipliers from the whole matrix, for an M that is singular by itself.
template <class = void>  // compiled only where it is called
Eigen::VectorXd pivoted_solution(const Eigen::MatrixXd& M, const Eigen::MatrixXd& J, const Eigen::VectorXd& f,
                                        const Eigen::VectorXd& gamma, double t, const std::vector<std::string>& constraints,
                                        const std::vector<std::string>& coordinates) {
  const Eigen::Index size = M.rows();
  const Eigen::Index rows = J.rows();
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(size + rows, size + rows);
  Eigen::VectorXd right(size + rows);
  K.topLeftCorner(size, size) = M;
  K.topRightCorner(size, rows) = -J.transpose();
  K.bottomLeftCorner(rows, size) = J;
  right << f, gamma;
  for (Eigen::Index i = 0; i < rows; ++i)
    if (gamma[i] == 0.0 && J.row(i).isZero(0.0)) K(size + i, size + i) = 1.0;  // an idle row: λ = 0
  // Equilibrate: rows, then columns, to largest entry one.
  Eigen::VectorXd column_scale = Eigen::VectorXd::Ones(size + rows);
  for (Eigen::Index i = 0; i < K.rows(); ++i) {
    const double largest = K.row(i).cwiseAbs().maxCoeff();
    if (largest > 0) {
      K.row(i) /= largest;
      right[i] /= largest;
    }
  }
  for (Eigen::Index j = 0; j < K.cols(); ++j) {
    const double largest = K.col(j).cwiseAbs().maxCoeff();
    if (largest > 0) {
      K.col(j) /= largest;
      column_scale[j] = largest;
    }
  }
  const Eigen::FullPivLU<Eigen::MatrixXd> lu(K);
  if (!lu.isInvertible()) {
    std::ostringstream out;
    Eigen::VectorXd null = lu.kernel().col(0).cwiseQuotient(column_scale);
    null /= null.cwiseAbs().maxCoeff();
    if (null.head(size).cwiseAbs().maxCoeff() > 1e-9) {
      const std::vector<double> direction(null.data(), null.data() + size);
      out << "every motion must have inertia or be determined by a constraint, but at t = " << t
          << " the motion with velocity along " << direction_text(direction, coordinates)
          << " has neither; give it a mass or a constraint";
      throw SingularMassMatrix(out.str(), t, direction, 0.0);
    }
    Eigen::Index worst = 0;
    null.tail(rows).cwiseAbs().maxCoeff(&worst);
    out << "constraints on massless coordinates must be independent, but at t = " << t << " '"
        << constraints[static_cast<std::size_t>(worst)] << "' depends on the others; remove it";
    throw ConstraintError(constraints[static_cast<std::size_t>(worst)], t, 0.0, out.str());
  }
  return lu.solve(right).cwiseQuotient(column_scale);
}

// Pivots of M below this fraction are left to the constraints. Not a rounding unit: the last pivot of a singular M is the
// rounding of the ones before, divided by the smallest of them (a unit quaternion near the identity leaves 1e-13).
inline constexpr double massless_pivot = 1e-8;

// A row whose pivot is within this factor of the dependent ones is judged by the factors below, too, whoever finds it elsewhere: they take another
// order and another sum.
inline constexpr double clearly_independent = 100.0;

// Factors of one configuration, used for accelerations and for both projections.
template <int n, int m>
class ConstrainedFactors {
 public:
  ConstrainedFactors(const Matrix<double, n>& M, const Matrix<double, m, n>& J, double cutoff) : M_(M), J_(J), cutoff_(cutoff) {
    definite_ = cholesky_.compute(M) && cholesky_.smallest_pivot() > massless_pivot;
    if (!definite_) return;
    // Bᵀ = L⁻¹ Jᵀ with columns scaled to length one.
    Bt_ = J.transpose();
    cholesky_.solve_lower(Bt_);
    scale_.resize(J.rows());
    for (Eigen::Index i = 0; i < J.rows(); ++i) {
      const double length = Bt_.col(i).norm();
      scale_[i] = length > 0 ? length : 1.0;
      Bt_.col(i) /= scale_[i];
      if (length == 0) ++idle_;
    }
    Matrix<double, m> schur(J.rows(), J.rows());
    for (Eigen::Index j = 0; j < J.rows(); ++j)
      for (Eigen::Index i = j; i < J.rows(); ++i) schur(i, j) = Bt_.col(i).dot(Bt_.col(j));
    if (idle_ > 0)
      for (Eigen::Index i = 0; i < J.rows(); ++i)
        if (schur(i, i) == 0.0) schur(i, i) = 1.0;
    regular_ = schur_.compute(schur) && schur_.smallest_pivot() > cutoff * cutoff;
    smallest_pivot_ = schur_.smallest_pivot();
    rank_ = J.rows() - idle_;
    if (!regular_) rank_ = least_norm(Bt_, Eigen::VectorXd::Zero(J.rows()), cutoff).rank;
  }

  // Pivots of M and of the scaled J M⁻¹ Jᵀ, and the row of the latter's smallest. 1 for the constraints where M is singular by itself.
  double mass_pivot() const noexcept { return cholesky_.smallest_pivot(); }
  double constraint_pivot() const noexcept { return smallest_pivot_; }
  Eigen::Index weakest_constraint() const noexcept { return schur_.weakest_row(); }

  // Independent constraints; all of them where M alone is singular and the rank is not judged here.
  Eigen::Index rank() const noexcept { return definite_ ? rank_ : J_.rows(); }

  // q̈ and λ for a force f and γ; names and time are for messages only.
  template <class Names>
  ConstrainedSolution<n, m> solution(const Vector<double, n>& f, const Vector<double, m>& gamma, double t, const Names& names) const {
    ConstrainedSolution<n, m> s;
    if (!definite_) {
      const Eigen::VectorXd both = pivoted_solution(M_, J_, f, gamma, t, names(), names.coordinates());
      s.qddot = both.head(M_.rows());
      s.lambda = both.tail(J_.rows());
      s.rank = J_.rows();
      return s;
    }
    s.rank = rank_;
    s.smallest_pivot = smallest_pivot_;
    const Vector<double, n> a0 = cholesky_.solve(f);
    const Vector<double, m> g = (gamma - J_ * a0).cwiseQuotient(scale_);
    Vector<double, n> d;
    const double size = (gamma.cwiseAbs() + J_.cwiseAbs() * a0.cwiseAbs()).cwiseQuotient(scale_).maxCoeff();
    nearest(g, size, d, s.lambda, t, names);
    s.lambda = s.lambda.cwiseQuotient(scale_).eval();
    cholesky_.solve_upper(d);
    s.qddot = a0 + d;
    return s;
  }

  // The smallest displacement in the metric of M with J x = r.
  template <class Names>
  Vector<double, n> displacement(const Vector<double, m>& r, double t, const Names& names) const {
    if (!definite_) return least_norm(J_.transpose(), r, cutoff_).d;
    const Vector<double, m> g = r.cwiseQuotient(scale_);
    Vector<double, n> d;
    Vector<double, m> lambda;
    // Newton's iteration corrects what dependent rows leave over; contradictions show in its residual.
    nearest(g, std::numeric_limits<double>::infinity(), d, lambda, t, names);
    cholesky_.solve_upper(d);
    return d;
  }

 private:
  // The shortest d with B d = g, and λ with d = Bᵀλ (both in scaled rows).
  template <class Names>
  void nearest(const Vector<double, m>& g, double size, Vector<double, n>& d, Vector<double, m>& lambda, double t,
               const Names& names) const {
    if (regular_ && (idle_ == 0 || asks_nothing_of_idle_rows(g))) {
      lambda = schur_.solve(g);
      d = Bt_ * lambda;
      return;
    }
    const LeastNorm shortest = least_norm(Bt_, g, cutoff_);
    d = shortest.d;
    lambda = shortest.lambda;
    // What rounding and the cut-off may leave over, relative to the terms that cancel.
    if (shortest.miss.cwiseAbs().maxCoeff() > 1e2 * cutoff_ * (size + g.cwiseAbs().maxCoeff()))
      throw_contradiction(names(), shortest.miss, rank_, t);
  }

  bool asks_nothing_of_idle_rows(const Vector<double, m>& g) const {
    for (Eigen::Index i = 0; i < g.size(); ++i)
      if (g[i] != 0.0 && Bt_.col(i).isZero(0.0)) return false;
    return true;
  }

  Matrix<double, n> M_;
  Matrix<double, m, n> J_;
  double cutoff_;
  Cholesky<double, n> cholesky_;
  Matrix<double, n, m> Bt_;
  Vector<double, m> scale_;
  Cholesky<double, m> schur_;
  bool definite_ = false;
  bool regular_ = false;
  Eigen::Index rank_ = 0;
  Eigen::Index idle_ = 0;  // rows of zeros
  double smallest_pivot_ = 1.0;
};

// The names that a message may need, made only when it does.
template <class Sc>
struct SceneNames {
  const Sc& scene;
  std::vector<std::string> operator()() const { return constraint_names(scene); }
  std::vector<std::string> coordinates() const { return coordinate_names(scene); }
};

}  // namespace detail

/// How near to singular the matrices of a scene with constraints are.
struct Conditioning {
  double mass = 1.0;         ///< smallest pivot of M, scaled to unit diagonal
  double constraints = 1.0;  ///< the same of J M⁻¹ Jᵀ; 1 where no constraint holds, or M is singular by itself
  Eigen::Index weakest_constraint = 0;  ///< the row of that pivot
};

/// The same at y = [q; q̇; z].
template <class Sys, class... Effects>
Conditioning conditioning(const Scene<Sys, Effects...>& scene, const Eigen::VectorXd& y, double t) {
  using Sc = Scene<Sys, Effects...>;
  constexpr int n = Sc::dof_at_compile_time;
  const Eigen::Index dof = scene.dof();
  const Vector<double, n> q = y.head(dof), qdot = y.segment(dof, dof);
  const EffectStates<Sc> z = y.tail(Sc::states_at_compile_time);
  const Matrix<double, n> M = mass_matrix(scene.system(), q, qdot, t);
  if (detail::is_free(scene, z)) {
    Cholesky<double, n> cholesky;
    cholesky.compute(M);
    return {.mass = cholesky.smallest_pivot()};
  }
  const detail::ConstrainedFactors<n, Sc::constraints_at_compile_time> factors(M, constraint_jacobian(scene, q, qdot, t, z), default_rank_cutoff);
  return {factors.mass_pivot(), factors.constraint_pivot(), factors.weakest_constraint()};
}

}  // namespace qdot
