#pragma once
// SPDX-License-Identifier: MIT
//
// M and J at a state, factored for questions about displacements: which is the smallest that takes a residual away?
//
//     minimize δᵀM δ   subject to   J δ = r
//
// Scenes with n known to the compiler ask dense factors (effects/rows/constrained_solve.hpp). Those with n known at run time, which may be
// large, ask the equations that a run has traced (effects/rows/traced_constraints.hpp), or sparse factors (effects/rows/sparse_solve.hpp),
// and the dense ones where the sparse ones have none: rows that depend on each other, motions without inertia, and whatever must be named.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/effects/rows/sparse_solve.hpp"
#include "qdot/effects/rows/traced_constraints.hpp"
#include "qdot/mechanics/mass_and_rhs.hpp"

namespace qdot::detail {

// Which scenes may have many coordinates and constraints.
template <class Sc>
inline constexpr bool may_be_sparse =
    Sc::dof_at_compile_time == Dynamic && Sc::has_constraints && Sc::SystemType::inertia == Inertia::positive_definite;

// M within its band, the rows of J, and their factors.
struct SparseSystem {
  BandedMatrix M{0, 0};
  SparseRows J;
  SparseFactors factors;

  template <class Sc, class Phases>
  bool compute(const Sc& scene, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, double t, const Phases& z, double cutoff, Eigen::VectorXd& r) {
    return with_mass_and_rhs<Dynamic>(scene.system().energies(), q, qdot, t, BandTo{M, r}) && factor(scene, q, qdot, t, z, cutoff);
  }

  // The same without r; and when only q has changed, M of T(q̇) has not.
  template <class Sc, class Phases>
  bool compute(const Sc& scene, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, double t, const Phases& z, double cutoff) {
    if constexpr (Sc::SystemType::kinetic_signature == KineticSignature::velocity) {
      if (M.size() == 0) M = mass_matrix_of_velocities(scene.system().energies(), qdot);
      return factor(scene, q, qdot, t, z, cutoff);
    } else {
      Eigen::VectorXd r;
      return compute(scene, q, qdot, t, z, cutoff, r);
    }
  }

 private:
  template <class Sc, class Phases>
  bool factor(const Sc& scene, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, double t, const Phases& z, double cutoff) {
    return write_sparse_rows(scene, q, qdot, t, z, J) && factors.compute(M, J, massless_pivot, clearly_independent * cutoff * cutoff);
  }
};

// q̈ and λ of a scene with applied forces Q (none where it is empty); false where dense factors must see to it.
template <class Sc, class Phases, int n, int m>
bool sparse_solution(const Sc& scene, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, double t, const Phases& z, const Eigen::VectorXd& Q,
                     double cutoff, ConstrainedSolution<n, m>& solution) {
  SparseSystem sparse;
  if (!sparse.compute(scene, q, qdot, t, z, cutoff, solution.qddot)) return false;
  if (Q.size() > 0) solution.qddot += Q;
  solution.lambda = -constraint_acceleration(scene, q, qdot, Eigen::VectorXd(Eigen::VectorXd::Zero(q.size())), t, z);
  if (!sparse.factors.solve(sparse.J, solution.qddot, solution.lambda)) return false;
  solution.rank = sparse.factors.rank();
  solution.smallest_pivot = sparse.factors.smallest_pivot();
  return true;
}

// M and J of a scene at one place after another, with the same velocities.
template <class Sc>
class ConstraintGeometry {
  static constexpr int n = Sc::dof_at_compile_time, m = Sc::constraints_at_compile_time;

 public:
  /// @param traced  equations that a run has traced, or nothing
  ConstraintGeometry(const Sc& scene, double t, double cutoff, TracedConstraints<>* traced = nullptr) : names_{scene}, t_(t), cutoff_(cutoff), given_(traced) {}

  /// @param kept  1 for rows that count, 0 for those that do not; nothing: all
  template <class Phases>
  void move_to(const Vector<double, n>& q, const Vector<double, n>& qdot, const Phases& z, const Vector<double, m>* kept = nullptr) {
    if (kept != nullptr) {
      traced_ = nullptr;
      sparse_.reset();
    } else if constexpr (may_be_sparse<Sc>) {
      if constexpr (requires { z.data(); }) traced_ = given_ && given_->move_to(q.data(), qdot.data(), t_, z.data()) ? given_ : nullptr;
      if (traced_) return;
      if (!sparse_) sparse_.emplace();
      if (sparse_->compute(names_.scene, q, qdot, t_, z, cutoff_)) return;
      sparse_.reset();
    }
    J_ = constraint_jacobian(names_.scene, q, qdot, t_, z);
    if (kept != nullptr) J_ = Matrix<double, m, n>(kept->asDiagonal() * J_);
    dense_.emplace(mass_matrix(names_.scene.system(), q, qdot, t_), J_, cutoff_);
  }

  // Names the constraint whose rows are not finite, if there is one.
  void require_finite() const {
    if (!sparse_ && !traced_) require_finite_rows(names_.scene, t_, J_);
  }

  // The smallest δ with J δ = r in the metric of M.
  Vector<double, n> displacement(const Vector<double, m>& r) {
    if constexpr (may_be_sparse<Sc>) {
      if (traced_) {
        Vector<double, n> step(static_cast<Eigen::Index>(traced_->n()));
        Vector<double, m> wanted = r;
        if (traced_->displacement(wanted.data(), step.data())) return step;
        make_dense();
      } else if (sparse_) {
        Vector<double, n> step = zeros<Vector<double, n>>(sparse_->M.size());
        Vector<double, m> multipliers = r;
        if (sparse_->factors.solve(sparse_->J, step, multipliers)) return step;
        make_dense();
      }
    }
    return dense_->displacement(r, t_, names_);
  }

  // The smallest δ with J δ = r in the metric of Σ (δⱼ/sizeⱼ)².
  Vector<double, n> displacement(const Vector<double, m>& r, const Vector<double, n>& size) {
    Vector<double, n> weight(size.size());
    for (Eigen::Index j = 0; j < size.size(); ++j) weight[j] = 1.0 / (size[j] * size[j]);
    if constexpr (may_be_sparse<Sc>) {
      if (sparse_ || traced_) {
        BandedMatrix metric(size.size(), 0);
        for (Eigen::Index j = 0; j < size.size(); ++j) metric(j, j) = weight[j];
        Vector<double, n> step = zeros<Vector<double, n>>(size.size());
        Vector<double, m> multipliers = r;
        SparseFactors factors;
        // Newton's iteration corrects what rows that depend on others leave over.
        if (factors.compute(metric, rows(), massless_pivot, clearly_independent * cutoff_ * cutoff_, redundant_pivot) &&
            factors.solve(rows(), step, multipliers, false))
          return step;
        make_dense();
      }
    }
    Matrix<double, n> metric = zeros<Matrix<double, n>>(size.size(), size.size());
    for (Eigen::Index i = 0; i < size.size(); ++i) metric(i, i) = weight[i];
    return ConstrainedFactors<n, m>(metric, J_, cutoff_).displacement(r, t_, names_);
  }

  bool has_dependent_rows() const {
    Eigen::Index rows = 0, all = sparse_ || traced_ ? static_cast<Eigen::Index>(this->rows().size()) : J_.rows();
    for (Eigen::Index i = 0; i < all; ++i) rows += length(i) > 0.0 ? 1 : 0;
    return rank() < rows;
  }
  Eigen::Index rank() const { return traced_ ? static_cast<Eigen::Index>(traced_->rank()) : sparse_ ? sparse_->factors.rank() : dense_->rank(); }

  // Σⱼ |Jᵢⱼ| xⱼ for x ≥ 0, and the length of row i.
  double reach(Eigen::Index i, const Vector<double, n>& x) const {
    double sum = 0.0;
    for_each_in_row(i, [&](Eigen::Index j, double entry) { sum += std::abs(entry) * x[j]; });
    return sum;
  }
  double length(Eigen::Index i) const {
    double sum = 0.0;
    for_each_in_row(i, [&](Eigen::Index, double entry) { sum += entry * entry; });
    return std::sqrt(sum);
  }

 private:
  template <class Visit>
  void for_each_in_row(Eigen::Index i, Visit&& visit) const {
    if (sparse_ || traced_) {
      const auto row = static_cast<std::size_t>(i);
      for (const auto* e = rows().begin(row); e != rows().end(row); ++e) visit(e->column, e->value);
    } else {
      for (Eigen::Index j = 0; j < J_.cols(); ++j) visit(j, J_(i, j));
    }
  }

  const SparseRows& rows() const { return traced_ ? traced_->jacobian() : sparse_->J; }

  void make_dense() {
    const SparseRows& J = rows();
    const Eigen::MatrixXd M = (traced_ ? traced_->mass() : sparse_->M).dense();
    J_ = Matrix<double, m, n>::Zero(static_cast<Eigen::Index>(J.size()), M.rows());
    for (std::size_t i = 0; i < J.size(); ++i)
      for (const auto* e = J.begin(i); e != J.end(i); ++e) J_(static_cast<Eigen::Index>(i), e->column) = e->value;
    dense_.emplace(Matrix<double, n>(M), J_, cutoff_);
    sparse_.reset();
    traced_ = nullptr;
  }

  SceneNames<Sc> names_;
  double t_, cutoff_;
  TracedConstraints<>* given_;
  TracedConstraints<>* traced_ = nullptr;
  std::optional<SparseSystem> sparse_;  // or else J_ and dense_
  Matrix<double, m, n> J_;
  std::optional<ConstrainedFactors<n, m>> dense_;
};

}  // namespace qdot::detail

namespace qdot {

/// How near to singular the matrices of a scene with constraints are.
struct Conditioning {
  double mass = 1.0;         ///< smallest pivot of M, scaled to unit diagonal
  double constraints = 1.0;  ///< the same of J M⁻¹ Jᵀ; 1 where no constraint holds, or M is singular by itself
  Eigen::Index weakest_constraint = 0;  ///< the row of that pivot
};

/// The same at y = [q; q̇; z]; of more than 128 coordinates by sparse factors, where these are sound, without that of M.
template <class Sys, class... Effects>
Conditioning conditioning(const Scene<Sys, Effects...>& scene, const Eigen::VectorXd& y, double t) {
  using Sc = Scene<Sys, Effects...>;
  constexpr int n = Sc::dof_at_compile_time;
  const Eigen::Index dof = scene.dof();
  using Q = Vector<double, n>;
  const Q q = detail::vector_at<n>(y.data(), dof), qdot = detail::vector_at<n>(y.data() + dof, dof);
  const EffectStates<Sc> z = Eigen::Map<const EffectStates<Sc>>(y.data() + 2 * dof, Sc::states_at_compile_time);
  if constexpr (detail::may_be_sparse<Sc>) {
    constexpr Eigen::Index most_dense = 128;
    constexpr double dependent = detail::clearly_independent * default_rank_cutoff * default_rank_cutoff;
    detail::SparseSystem sparse;
    if (dof > most_dense && (sparse.compute(scene, q, qdot, t, z, default_rank_cutoff) || sparse.factors.smallest_pivot() <= dependent))
      return {.mass = 1.0, .constraints = std::max(0.0, sparse.factors.smallest_pivot()), .weakest_constraint = sparse.factors.weakest_constraint()};
  }
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
