#pragma once
// SPDX-License-Identifier: MIT
//
// J, φ̇, φ̈ and their slopes by dual numbers of two kinds.
//
// φ, φ̇ and J take one direction at a time, Dual<double, 1>. The rest takes the numbers that T and V are run on, Dual<Dual<Dual<double, 1>, 1>, k>, with
// outer parts ε_i, a middle part η and an inner part δ. What is asked for is a matter of what these parts are at first:
//
//     φ̈       q + q̇ δ + (q̇ + q̈ δ) η ,  t + δ + η            the ηδ part of φ
//     ȧ       q + q̇ δ ,  q̇ + q̈ δ ,  t + δ                   the δ part of a
//     ∂φ̈/∂y   the same with ε_i on q_i, or on both q̇_i       the ε_i ηδ part
//     ∂J/∂y   q + ε_i, and δ on one component of y           the ε_i δ part
//
// So a functor is compiled twice for all of it. More is computed than each question needs; runs ask for lines (mechanics/derive/kept_rates.hpp) first.

#include <Eigen/Core>

#include "qdot/effects/equations/scene_rows.hpp"
#include "qdot/effects/rows/columns.hpp"
#include "qdot/mechanics/equations/lagrange_terms.hpp"
#include "qdot/mechanics/equations/small_solve.hpp"

namespace qdot::detail {

// The sizes for which rows are compiled; Dynamic stands for those beyond.
template <int n>
inline constexpr int size_of_rows = n >= 1 && n <= unrolled_limit ? n : Dynamic;

/// Rows of a scene with n coordinates.
template <int n>
class RowsByDuals : public virtual SceneRows {
 public:
  void write_jacobian(double t, const double* q, const double* qdot, const double* z, double* J) const override;
  void write_residual(double t, const double* q, const double* z, double* phi) const override;
  void write_velocity(double t, const double* q, const double* qdot, const double* z, double* velocity) const override;
  Column row_accelerations(double t, const Column& q, const Column& qdot, const Column& a, const Column& z) const override;
  /// dc ← −∂φ̈/∂y and −∂ȧ/∂y at fixed q̈ = a, for y = [q; q̇] in the first 2n columns.
  void write_slopes_of_accelerations(double t, const Column& q, const Column& qdot, const Column& a, const Column& z, Table& dc) const;
  /// dr ← dr + Σ λ_i ∂J_i/∂y, n rows.
  void add_slopes_of_reactions(double t, const Column& q, const Column& qdot, const Column& lambda, const Column& z, Table& dr) const;

 protected:
  using Number = TermDual<Spare, n>;

  /// φ of rows that restrict positions, and a of the others; rows of parts that are not active are zero.
  virtual void write_rows(const Number* q, const Number* qdot, const Number& t, const double* z, Number* out) const = 0;
  /// A state as values and slopes along one direction; null stands for a direction of zeros.
  struct Along {
    const double *q = nullptr, *qdot = nullptr;
    double t = 0.0;
  };
  virtual void write_rows(double t, const double* q, const double* qdot, const double* z, const Along& along, double* values, double* slopes) const = 0;
};

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template class RowsByDuals<1>;
extern template class RowsByDuals<2>;
extern template class RowsByDuals<3>;
extern template class RowsByDuals<4>;
extern template class RowsByDuals<5>;
extern template class RowsByDuals<6>;
extern template class RowsByDuals<7>;
extern template class RowsByDuals<8>;
extern template class RowsByDuals<Dynamic>;
}  // namespace qdot::detail
#else
#include "qdot/effects/equations/rows_by_duals.ipp"
#endif
