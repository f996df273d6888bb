#pragma once
// SPDX-License-Identifier: MIT
//
// Displacements onto many constraints (effects/equations/constraint_geometry.hpp), and how near to singular M and J are.
//
// Scenes with n known at run time ask the equations that a run has traced (effects/rows/traced_constraints.hpp), or sparse factors
// (effects/rows/sparse_solve.hpp). Dense ones see to what these leave: rows that depend on each other, motions without inertia, whatever must be named.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <type_traits>

#include "qdot/effects/equations/constraint_geometry.hpp"
#include "qdot/effects/equations/scene_rows_of.hpp"
#include "qdot/effects/rows/columns.hpp"
#include "qdot/effects/rows/constrained_solve.hpp"
#include "qdot/effects/rows/sparse_rows.hpp"
#include "qdot/effects/rows/sparse_solve.hpp"
#include "qdot/effects/rows/traced_constraints.hpp"
#include "qdot/mechanics/equations/banded_equations.hpp"
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
  std::unique_ptr<SparseFactors> factors = sparse_factors();

  template <class Sc, class Phases>
  bool compute(const Sc& scene, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, double t, const Phases& z, double cutoff, Eigen::VectorXd& r) {
    return with_mass_and_rhs<Dynamic>(scene.system().energies(), q, qdot, t, BandTo{M, r}) && factor(scene, q, qdot, t, z, cutoff);
  }

  // M, the rows of J and their factors, without r. When only q has changed, M of T(q̇) is kept.
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
    return write_sparse_rows(scene, q, qdot, t, z, J) && factors->compute(M, J, massless_pivot, clearly_independent * cutoff * cutoff);
  }
};

// q̈ and λ of a scene with applied forces Q (none where it is empty); false where dense factors must see to it.
template <class Sc, class Phases, int n, int m>
bool sparse_solution(const Sc& scene, const Eigen::VectorXd& q, const Eigen::VectorXd& qdot, double t, const Phases& z, const Eigen::VectorXd& Q,
                     double cutoff, ConstrainedSolution<n, m>& solution) {
  SparseSystem sparse;
  if (!sparse.compute(scene, q, qdot, t, z, cutoff, solution.qddot)) return false;
  for (Eigen::Index i = 0; i < Q.size(); ++i) solution.qddot[i] += Q[i];
  Eigen::VectorXd lambda = constraint_acceleration(scene, q, qdot, zeros<Eigen::VectorXd>(q.size()), t, z);
  for (Eigen::Index i = 0; i < lambda.size(); ++i) lambda[i] = -lambda[i];
  if (!sparse.factors->solve(sparse.J, solution.qddot, lambda)) return false;
  solution.lambda = lambda;
  solution.rank = sparse.factors->rank();
  solution.smallest_pivot = sparse.factors->smallest_pivot();
  return true;
}

/// Displacements of a scene with many coordinates; by dense factors where sparse ones fail. Refers to the scene and its rows.
template <class Sc>
class SparseGeometry final : public ConstraintGeometry {
 public:
  /// @param traced  equations that a run has traced, or nothing
  SparseGeometry(const Sc& scene, const SceneRows& rows, double t, double cutoff, TracedConstraints* traced)
      : scene_(scene), t_(t), cutoff_(cutoff), given_(traced), dense_(rows, t, cutoff) {}

  void move_to(const Column& q, const Column& qdot, const Column& z, const Column* kept = nullptr) override {
    traced_ = nullptr;
    is_dense_ = false;
    if (kept == nullptr) {
      if (given_ && given_->move_to(q.data(), qdot.data(), t_, z.data())) traced_ = given_;
      if (traced_) return;
      if (!sparse_) sparse_.emplace();
      if (sparse_->compute(scene_, q, qdot, t_, vector_at<Sc::states_at_compile_time>(z.data(), z.size()), cutoff_)) return;
    }
    sparse_.reset();
    is_dense_ = true;
    dense_.move_to(q, qdot, z, kept);
  }
  void require_finite() const override {
    if (is_dense_) dense_.require_finite();
  }

  Column displacement(const Column& r) override {
    if (is_dense_) return dense_.displacement(r);
    Eigen::VectorXd step = zeros<Eigen::VectorXd>(size()), wanted = r;
    if (traced_ ? traced_->displacement(wanted.data(), step.data()) : sparse_->factors->solve(sparse_->J, step, wanted)) return step;
    make_dense();
    return dense_.displacement(r);
  }
  Column displacement(const Column& r, const Column& size) override {
    if (!is_dense_) {
      BandedMatrix metric(size.size(), 0);
      for (Eigen::Index j = 0; j < size.size(); ++j) metric(j, j) = 1.0 / (size[j] * size[j]);
      Eigen::VectorXd step = zeros<Eigen::VectorXd>(size.size()), multipliers = r;
      const std::unique_ptr<SparseFactors> factors = sparse_factors();
      // Newton's iteration corrects what rows that depend on others leave over.
      if (factors->compute(metric, jacobian(), massless_pivot, clearly_independent * cutoff_ * cutoff_, redundant_pivot) &&
          factors->solve(jacobian(), step, multipliers, false))
        return step;
      make_dense();
    }
    return dense_.displacement(r, size);
  }

  Eigen::Index rank() const override { return is_dense_ ? dense_.rank() : traced_ ? static_cast<Eigen::Index>(traced_->rank()) : sparse_->factors->rank(); }
  bool has_dependent_rows() const override {
    if (is_dense_) return dense_.has_dependent_rows();
    Eigen::Index asked = 0;
    for (std::size_t i = 0; i < jacobian().size(); ++i) asked += length(static_cast<Eigen::Index>(i)) > 0.0 ? 1 : 0;
    return rank() < asked;
  }
  double reach(Eigen::Index row, const Column& x) const override {
    if (is_dense_) return dense_.reach(row, x);
    double sum = 0.0;
    const auto i = static_cast<std::size_t>(row);
    for (const auto* e = jacobian().begin(i); e != jacobian().end(i); ++e) sum += std::abs(e->value) * x[e->column];
    return sum;
  }
  double length(Eigen::Index row) const override {
    if (is_dense_) return dense_.length(row);
    double sum = 0.0;
    const auto i = static_cast<std::size_t>(row);
    for (const auto* e = jacobian().begin(i); e != jacobian().end(i); ++e) sum += e->value * e->value;
    return std::sqrt(sum);
  }

 private:
  const SparseRows& jacobian() const { return traced_ ? traced_->jacobian() : sparse_->J; }
  Eigen::Index size() const { return traced_ ? static_cast<Eigen::Index>(traced_->n()) : sparse_->M.size(); }

  [[gnu::cold]] void make_dense() {
    const SparseRows& rows = jacobian();
    Table J(static_cast<Eigen::Index>(rows.size()), size(), 0.0);
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (const auto* e = rows.begin(i); e != rows.end(i); ++e) J(static_cast<Eigen::Index>(i), e->column) = e->value;
    dense_.factor(Table((traced_ ? traced_->mass() : sparse_->M).dense()), J);
    is_dense_ = true;
    sparse_.reset();
    traced_ = nullptr;
  }

  const Sc& scene_;
  double t_, cutoff_;
  TracedConstraints* given_;
  TracedConstraints* traced_ = nullptr;  // is_dense_, or else traced_, or else sparse_ says where the geometry is
  std::optional<SparseSystem> sparse_;
  DenseGeometry<> dense_;
  bool is_dense_ = false;
};

// Which geometry a scene has.
template <class Sc>
using GeometryOf = std::conditional_t<may_be_sparse<Sc>, SparseGeometry<Sc>, DenseGeometry<>>;

/// Displacements of a scene, which the geometry refers to as to its rows; `traced` as above.
template <class Sc>
GeometryOf<Sc> constraint_geometry([[maybe_unused]] const Sc& scene, const SceneRows& rows, double t, double cutoff,
                                   [[maybe_unused]] TracedConstraints* traced = nullptr) {
  if constexpr (may_be_sparse<Sc>) return SparseGeometry<Sc>(scene, rows, t, cutoff, traced);
  else return DenseGeometry<>(rows, t, cutoff);
}

}  // namespace qdot::detail

namespace qdot {

/// How near to singular M and J are at y = [q; q̇; z]; of more than 128 coordinates by sparse factors, where these are sound, without that of M.
template <class Sys, class... Effects>
Conditioning conditioning(const Scene<Sys, Effects...>& scene, const Eigen::VectorXd& y, double t) {
  using Sc = Scene<Sys, Effects...>;
  const Eigen::Index dof = scene.dof();
  const double* const first = y.data();
  const EffectStates<Sc> z = detail::vector_at<Sc::states_at_compile_time>(first + 2 * dof, y.size() - 2 * dof);
  if constexpr (detail::may_be_sparse<Sc>) {
    constexpr Eigen::Index most_dense = 128;
    constexpr double dependent = detail::clearly_independent * default_rank_cutoff * default_rank_cutoff;
    detail::SparseSystem sparse;
    const auto of = [&](const double* numbers) { return detail::vector_at<Dynamic>(numbers, dof); };
    if (dof > most_dense &&
        (sparse.compute(scene, of(first), of(first + dof), t, z, default_rank_cutoff) || sparse.factors->smallest_pivot() <= dependent))
      return {.mass = 1.0, .constraints = std::max(0.0, sparse.factors->smallest_pivot()), .weakest_constraint = sparse.factors->weakest_constraint()};
  }
  constexpr int n = Sc::dof_at_compile_time, m = Sc::constraints_at_compile_time;
  using Sizes = std::conditional_t<detail::are_few<n, m>, detail::KnownSizes<n, m>, detail::AnySizes>;
  return detail::dense_conditioning<Sizes>(detail::SceneRowsOf<Sc>(scene), t, first, first + dof, first + 2 * dof, detail::is_free(scene, z));
}

}  // namespace qdot
