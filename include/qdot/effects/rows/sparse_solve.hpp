#pragma once
// SPDX-License-Identifier: MIT
//
// M q̈ − Jᵀλ = f, J q̈ = γ where each constraint touches few coordinates.
//
//     [ M  Jᵀ ] [  q̈ ]   [ f ]
//     [ J  0  ] [ −λ ] = [ γ ]
//
// has L D Lᵀ without pivoting if each multiplier comes when the last coordinate that its row touches has come. Then the pivot of a
// multiplier is minus what its row has left of its own length, in the metric of M, when the rows before it are kept. The pivot of a
// coordinate is its inertia and never less. Bodies in a row give a narrow matrix, x₁ y₁ λ₁ x₂ y₂ λ₂ …: a rod costs what a rod costs.
// Rows of L are kept from their first entry on (an envelope). Coordinates are taken as numbered or, where that makes a wide envelope,
// in the reverse order of Cuthill and McKee.
//
// A run comes here from its traced equations (effects/rows/traced_constraints.hpp) where M is not diagonal. Where it is, the multipliers
// alone are fewer unknowns (effects/rows/schur_factors.hpp). A row's pivot, as a fraction of its length squared, is the square of its
// sine to those before it. Where one is too small, and for all else irregular, effects/rows/constrained_solve.hpp takes over.

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
