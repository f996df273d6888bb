#pragma once
// SPDX-License-Identifier: MIT
//
// Linear equations J x = b with fewer rows than columns, solved for as many entries of x as J has rank:
//
//     x = N x_free + (a solution whose free entries are 0) .
//
// The free entries are coordinates themselves, chosen by pivoting so that the others depend on them in a
// well-conditioned way, and N has a unit row for each. So minimal coordinates keep the names of those that they were
// taken from.

#include <algorithm>
#include <vector>

#include <Eigen/Core>
#include <Eigen/QR>

namespace qdot::detail {

// Rows count as dependent below this fraction of their length.
inline constexpr double dependent_fraction = 1e-10;

template <class = void>  // compiled only where it is made
class TangentSpace {
 public:
  template <class Matrix>
  explicit TangentSpace(const Matrix& J) : scale_(J.rows()), columns_(J.cols()) {
    for (Eigen::Index i = 0; i < J.rows(); ++i) {
      const double length = J.row(i).norm();
      scale_[i] = length > 0.0 ? 1.0 / length : 1.0;
    }
    if (J.rows() > 0) {
      factors_.setThreshold(dependent_fraction);
      factors_.compute(scale_.asDiagonal() * J);
      rank_ = factors_.rank();
    }
    for (Eigen::Index k = rank_; k < columns_; ++k)
      free_.push_back(J.rows() > 0 ? factors_.colsPermutation().indices()[k] : k);
    std::sort(free_.begin(), free_.end());
    basis_ = Matrix::Zero(columns_, columns_ - rank_);
    Matrix image(J.rows(), columns_ - rank_);
    for (Eigen::Index k = 0; k < image.cols(); ++k) image.col(k) = -J.col(free_[static_cast<std::size_t>(k)]);
    if (J.rows() > 0) basis_ = particular(image);
    for (Eigen::Index k = 0; k < basis_.cols(); ++k) basis_(free_[static_cast<std::size_t>(k)], k) = 1.0;
  }

  Eigen::Index rank() const { return rank_; }
  const std::vector<Eigen::Index>& free() const { return free_; }
  const Eigen::MatrixXd& basis() const { return basis_; }  // N

  // The solution of J x = b with x_free = 0, column by column.
  template <class Matrix>
  Eigen::MatrixXd particular(const Matrix& b) const {
    Matrix x = Matrix::Zero(columns_, b.cols());
    if (rank_ == 0) return x;
    Matrix image = factors_.householderQ().adjoint() * (scale_.asDiagonal() * b);
    const Matrix upper = factors_.matrixR().topLeftCorner(rank_, rank_);
    const Matrix dependent = upper.template triangularView<Eigen::Upper>().solve(image.topRows(rank_));
    for (Eigen::Index k = 0; k < rank_; ++k) x.row(factors_.colsPermutation().indices()[k]) = dependent.row(k);
    return x;
  }

 private:
  Eigen::VectorXd scale_;
  Eigen::Index columns_, rank_ = 0;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factors_;
  std::vector<Eigen::Index> free_;
  Eigen::MatrixXd basis_;
};

}  // namespace qdot::detail
