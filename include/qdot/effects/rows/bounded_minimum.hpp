#pragma once
// SPDX-License-Identifier: MIT
//
// Forces within bounds: λ ≥ 0 of contacts, |λ| ≤ F_s of friction.
//
//     minimize ½ λᵀA λ + bᵀλ ,    l ≤ λ ≤ u ,    A = J M⁻¹ Jᵀ
//
// With w = A λ + b, the accelerations of the rows, its solution has w = 0 where λ is between its bounds, w ≥ 0 at l and w ≤ 0 at u. So a
// contact opens or is closed, and friction slides or sticks. w is unique. Where rows depend on each other, λ is not:
//
//     solve      some λ, by free rows that are added and removed one by one, always independent ones (Lawson and Hanson)
//     shorten    of all λ with that w and within the bounds the one of least norm
//     margin     how far inside the bounds λ can be, where rows share their forces
//
// All rows are scaled to A_ii = 1 first. It is asked at events, and where active rows depend on each other.

#include <Eigen/Core>
#include <cmath>
#include <vector>

namespace qdot::detail {

// Squared sine of the angle below which a row depends on others: that of default_rank_cutoff.
inline constexpr double dependent_pivot = 1e-10;

// The problem, and its solution: λ, w, and a row that no finite λ satisfies, or −1.
struct BoundedMinimum {
  Eigen::MatrixXd A;                 // positive semidefinite, of diagonal 1
  Eigen::VectorXd b, lower, upper;   // 0 lies within the bounds
  Eigen::VectorXd size;              // of the terms in b
  double relative = 1e-9;            // part of size that counts as zero
  bool exact = false;                // whether rows are known to rounding, and not as those of constraints to default_rank_cutoff
  Eigen::VectorXd x, w;
  Eigen::Index contradicting = -1;

  double least(Eigen::Index i) const {  // |w_i| that counts as zero
    double terms = 0.0;
    for (Eigen::Index j = 0; j < x.size(); ++j) terms += std::abs(A(i, j) * x[j]);
    return relative * size[i] + 1e-13 * terms;
  }
  bool between(Eigen::Index i) const { return x[i] > lower[i] && x[i] < upper[i]; }
};

// The symmetric part of A that belongs to some rows.
template <class = void>
Eigen::MatrixXd part_of(const Eigen::MatrixXd& A, const std::vector<Eigen::Index>& rows);

// Fills in x, w and contradicting; false where it does not arrive.
template <class = void>
[[gnu::cold]] bool solve(BoundedMinimum& p);

// Orthonormal columns that A turns into zero.
template <class = void>
[[gnu::cold]] Eigen::MatrixXd null_space(const Eigen::MatrixXd& A);

// x ← the shortest x + N y within the bounds; false where there is none.
template <class = void>
[[gnu::cold]] bool shorten(Eigen::VectorXd& x, const Eigen::MatrixXd& N, const Eigen::VectorXd& lower, const Eigen::VectorXd& upper);

// Of rows that share their forces: the largest μ with l + μ ς ≤ x + N y ≤ u − μ ς for some y, at most `most`, and which bounds stop it: −1 the
// lower, 1 the upper, 0 none. A linear programme, as a sequence of nearest points, which ends at its solution.
struct Margin {
  double mu = 0.0;
  std::vector<int> stops;
};
template <class = void>
[[gnu::cold]] Margin margin(const Eigen::VectorXd& x, const Eigen::MatrixXd& N, const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                            const Eigen::VectorXd& unit, double most);

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template Eigen::MatrixXd part_of<void>(const Eigen::MatrixXd&, const std::vector<Eigen::Index>&);
extern template bool solve<void>(BoundedMinimum&);
extern template Eigen::MatrixXd null_space<void>(const Eigen::MatrixXd&);
extern template bool shorten<void>(Eigen::VectorXd&, const Eigen::MatrixXd&, const Eigen::VectorXd&, const Eigen::VectorXd&);
extern template Margin margin<void>(const Eigen::VectorXd&, const Eigen::MatrixXd&, const Eigen::VectorXd&, const Eigen::VectorXd&, const Eigen::VectorXd&,
                                    double);
}  // namespace qdot::detail
#else
#include "qdot/effects/rows/bounded_minimum.ipp"
#endif
