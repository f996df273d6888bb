#pragma once
// SPDX-License-Identifier: MIT
//
// Linear equations whose rows may depend on each other:
//
//     orthogonal_columns   A = Q C with orthonormal columns Q, as many as A has rank
//     least_norm           the shortest solution, and the shortest multipliers
//     pivoted_elimination  K x = r for regular K, or else a direction on which K vanishes
//
// All of it in loops on matrices of run-time size: Eigen's decompositions, and its expressions, were most of the time to compile a constrained
// system. They are asked where the fast ways of effects/rows/constrained_solve.hpp have given up.

#include <Eigen/Core>

namespace qdot::detail {

inline double dot(const double* a, const double* b, Eigen::Index count) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < count; ++i) sum += a[i] * b[i];
  return sum;
}
template <class A>
Eigen::MatrixXd of_run_time_size(const A& of) {
  Eigen::MatrixXd same(of.rows(), of.cols());
  for (Eigen::Index j = 0; j < of.cols(); ++j)
    for (Eigen::Index i = 0; i < of.rows(); ++i) same(i, j) = of(i, j);
  return same;
}
inline void add(double* to, double factor, const double* a, Eigen::Index count) {
  for (Eigen::Index i = 0; i < count; ++i) to[i] += factor * a[i];
}

// Orthonormal columns Q and coefficients C with A = Q C, up to what is smaller than the cut-off: Gram and Schmidt's
// method, largest remaining column first, each made orthogonal twice. Of columns that are equally long but for rounding the first
// is taken. What the cut-off drops of the others must not change from one evaluation to the next, or steps shrink to nothing.
struct OrthogonalColumns {
  Eigen::Index rank = 0;
  Eigen::MatrixXd Q, C;  // the first `rank` columns of Q and rows of C
};
template <class = void>
[[gnu::cold]] OrthogonalColumns orthogonal_columns(const Eigen::MatrixXd& A, double cutoff, bool pivoted);

// The shortest d with B d = g for rows B that depend on each other, and the shortest λ with d = Bᵀλ. With Bᵀ = Q C and
// Cᵀ = Z S, both with orthonormal columns and S upper triangular:  S c = Zᵀ g,  d = Q c,  Sᵀ w = c,  λ = Z w.
struct LeastNorm {
  Eigen::VectorXd d, lambda, miss;
  Eigen::Index rank;
};
template <class = void>
[[gnu::cold]] LeastNorm least_norm(const Eigen::MatrixXd& Bt, const double* g, double cutoff);

// x with K x = right by Gauss's elimination with full pivoting. Where K is singular, x ≠ 0 with K x = 0, and false.
template <class = void>
[[gnu::cold]] bool pivoted_elimination(Eigen::MatrixXd& K, double* right, double* x);

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template OrthogonalColumns orthogonal_columns<void>(const Eigen::MatrixXd&, double, bool);
extern template LeastNorm least_norm<void>(const Eigen::MatrixXd&, const double*, double);
extern template bool pivoted_elimination<void>(Eigen::MatrixXd&, double*, double*);
}  // namespace qdot::detail
#else
#include "qdot/effects/rows/dependent_rows.ipp"
#endif
