#pragma once
// SPDX-License-Identifier: MIT
//
// The reference for the library's own L D Lᵀ: Eigen's with pivoting, on matrices of run-time size. Of a fixed size the compiler would write it
// anew, with all of its expressions, for every number of coordinates.

#include <Eigen/Cholesky>

#include "qdot/ad/vector.hpp"

namespace qdot {

inline void solve_by_pivots(const double* M, const double* b, double* x, Eigen::Index n) {
  using Eigen::Map, Eigen::MatrixXd, Eigen::VectorXd;
  Map<VectorXd>(x, n) = Map<const MatrixXd>(M, n, n).ldlt().solve(Map<const VectorXd>(b, n));
}

/// x with M x = b, M symmetric.
template <int n>
Vector<double, n> solution_by_pivots(const Matrix<double, n>& M, const Vector<double, n>& b) {
  Vector<double, n> x(b.size());
  solve_by_pivots(M.data(), b.data(), x.data(), b.size());
  return x;
}

}  // namespace qdot
