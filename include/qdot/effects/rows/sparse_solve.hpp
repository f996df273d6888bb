#pragma once
// SPDX-License-Identifier: MIT
//
// M q̈ − Jᵀλ = f, J q̈ = γ where each constraint touches few coordinates.
//
// The symmetric matrix of both kinds of unknowns,
//
//     [ M  Jᵀ ] [  q̈ ]   [ f ]
//     [ J  0  ] [ −λ ] = [ γ ] ,
//
// is L D Lᵀ without pivoting when the unknowns come in the right order. Coordinates come one after the other, and each multiplier when the last
// coordinate that its row touches has come. Then the pivot of a multiplier is minus what its row has left of its own length, in the metric of M, when
// the rows before it are kept. The pivot of a coordinate is its inertia and never less. Bodies in a row, joined one to the next, make a narrow matrix
// of this: x₁ y₁ λ₁ x₂ y₂ λ₂ …, and a rod costs what a rod costs.
//
// Rows of L are kept from their first entry on (an envelope), in which all that arises has room. Coordinates are taken as they are numbered, or,
// where that makes a wide envelope, in the reverse order of Cuthill and McKee, neighbours near neighbours.
//
// A run asks its traced equations first (effects/rows/traced_constraints.hpp), which come here where M is not diagonal.
//
// Where M is diagonal and constraints that meet are near each other, the multipliers alone are fewer unknowns (effects/rows/schur_factors.hpp).
//
// The square of the sine between a row and those before it is its pivot, as a fraction of its length squared. Where one is too small the rows depend on
// each other, or nearly. That, and whatever else is irregular, is left to effects/rows/constrained_solve.hpp, which handles and names it.

#include <Eigen/Core>
#include <memory>

#include "qdot/effects/rows/sparse_rows.hpp"
#include "qdot/mechanics/equations/banded_equations.hpp"

namespace qdot::detail {

/// L D Lᵀ of M and J together, or of J M⁻¹ Jᵀ where M is diagonal and constraints that meet are near each other.
struct SparseFactors {
  virtual ~SparseFactors() = default;
  /// False when a pivot is too small: of M, below `massless` of its diagonal entry, of a row, below `dependent`.
  ///
  /// @param rounding  a row whose pivot is no larger, as a fraction, says what others say; with a negative one there are no such rows
  virtual bool compute(const BandedMatrix& M, const SparseRows& J, double massless, double dependent, double rounding = -1.0) = 0;
  /// Rows that ask for something, and the square of the sine of the worst one's angle to those before it, also where that is why compute() was false.
  virtual Eigen::Index rank() const noexcept = 0;
  virtual double smallest_pivot() const noexcept = 0;
  virtual Eigen::Index weakest_constraint() const noexcept = 0;
  /// f ← q̈ and γ ← λ; false when a row without a pivot asks for something and that matters, or the result is not finite.
  virtual bool solve(const SparseRows& J, Eigen::VectorXd& f, Eigen::VectorXd& gamma, bool matters = true) = 0;
};
template <class = void>
std::unique_ptr<SparseFactors> sparse_factors();

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template std::unique_ptr<SparseFactors> sparse_factors<void>();
}  // namespace qdot::detail
#else
#include "qdot/effects/rows/sparse_solve.ipp"
#endif
