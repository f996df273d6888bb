#pragma once
// SPDX-License-Identifier: MIT
//
// Cholesky's factorization of small matrices, M = L Lᵀ, for any scalar.
//
//     l_kk = √(M_kk − Σ l_kj²) ,      l_ik = (M_ik − Σ l_ij l_kj)/l_kk     (j < k < i)
//
// Eigen has it too, and large matrices are left to Eigen. But Eigen's own brings its blocked matrix
// products along even for a 2×2 matrix, and they were a third of the time to compile a small program. What
// matters here besides is the pivot: what is left of M_kk after the coordinates before k are free,
// as a fraction of M_kk itself. It says how near to singular M is, whatever the units of its rows.

#include <algorithm>
#include <cmath>

#include "qdot/ad/dual_math.hpp"
#include "qdot/ad/vector.hpp"

namespace qdot {

namespace detail {

/// The factor L of a symmetric positive definite matrix of a type M, with entries S.
template <class S, class M>
class CholeskyOf {
 public:
  /// Factors M, of which the lower triangle is read; false, and of no further use, when M is not positive definite.
  ///
  /// n³/6 products.
  bool compute(const M& of) {
    using std::sqrt;
    L_.resize(of.rows(), of.cols());
    std::copy_n(of.data(), of.size(), L_.data());
    smallest_pivot_ = 1.0;
    weakest_ = 0;
    for (Eigen::Index k = 0; k < of.rows(); ++k) {
      S pivot = of(k, k);
      for (Eigen::Index j = 0; j < k; ++j) pivot -= L_(k, j) * L_(k, j);
      const double left =
          static_cast<double>(innermost_value(pivot)) / std::abs(static_cast<double>(innermost_value(of(k, k))));
      if (!(left > 0.0)) {
        smallest_pivot_ = 0.0;
        weakest_ = k;
        return false;
      }
      if (left < smallest_pivot_) {
        smallest_pivot_ = left;
        weakest_ = k;
      }
      const S root = sqrt(pivot);
      L_(k, k) = root;
      for (Eigen::Index i = k + 1; i < of.rows(); ++i) {
        S sum = of(i, k);
        for (Eigen::Index j = 0; j < k; ++j) sum -= L_(i, j) * L_(k, j);
        L_(i, k) = sum / root;
      }
    }
    return true;
  }

  /// The smallest pivot as a fraction of its diagonal entry, at most 1; 0 when the factorization failed.
  double smallest_pivot() const noexcept { return smallest_pivot_; }

  /// The row of that pivot.
  Eigen::Index weakest_row() const noexcept { return weakest_; }

  /// B ← L⁻¹ B, column by column.
  template <class Columns>
  void solve_lower(Columns& B) const {
    for (Eigen::Index c = 0; c < B.cols(); ++c)
      for (Eigen::Index i = 0; i < B.rows(); ++i) {
        S sum = B(i, c);
        for (Eigen::Index j = 0; j < i; ++j) sum -= L_(i, j) * B(j, c);
        B(i, c) = sum / L_(i, i);
      }
  }

  /// B ← L⁻ᵀ B, column by column.
  template <class Columns>
  void solve_upper(Columns& B) const {
    for (Eigen::Index c = 0; c < B.cols(); ++c)
      for (Eigen::Index i = B.rows(); i-- > 0;) {
        S sum = B(i, c);
        for (Eigen::Index j = i + 1; j < B.rows(); ++j) sum -= L_(j, i) * B(j, c);
        B(i, c) = sum / L_(i, i);
      }
  }

 private:
  M L_;
  double smallest_pivot_ = 0.0;
  Eigen::Index weakest_ = 0;
};

}  // namespace detail

/// The factor L of a symmetric positive definite matrix of fixed or run-time size.
///
/// @tparam S  any scalar with a square root
/// @tparam n  size, or Dynamic
template <class S, int n>
class Cholesky : public detail::CholeskyOf<S, Matrix<S, n>> {
  using Base = detail::CholeskyOf<S, Matrix<S, n>>;

 public:
  // compute(), smallest_pivot() and weakest_row() are those of the base.

  /// B ← L⁻¹ B, column by column.
  template <int columns>
  void solve_lower(Matrix<S, n, columns>& B) const {
    Base::solve_lower(B);
  }
  /// B ← L⁻ᵀ B, column by column.
  template <int columns>
  void solve_upper(Matrix<S, n, columns>& B) const {
    Base::solve_upper(B);
  }
  /// M⁻¹ B.
  template <int columns>
  Matrix<S, n, columns> solve(Matrix<S, n, columns> B) const {
    this->solve_lower(B);
    this->solve_upper(B);
    return B;
  }
};

}  // namespace qdot
