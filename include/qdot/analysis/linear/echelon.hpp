#pragma once
// SPDX-License-Identifier: MIT
//
// The reduced echelon form of the rows of a matrix.
//
// Rows that span a space of solutions are mixed until each has a column of its own, in which it is 1 and the others are 0. So a sum of unlike solutions
// comes apart into simple ones: an earlier column is taken before a later one.

#include <cmath>
#include <utility>

#include <Eigen/Core>

namespace qdot::detail {

// @param negligible  entries below that begin no row
template <class MatrixXd>
void reduce_rows(MatrixXd& d, double negligible) {
  const Eigen::Index n = d.cols();
  Eigen::Index done = 0;
  for (Eigen::Index column = 0; column < n && done < d.rows(); ++column) {
    Eigen::Index best = done;
    for (Eigen::Index i = done; i < d.rows(); ++i)
      if (std::abs(d(i, column)) > std::abs(d(best, column))) best = i;
    if (std::abs(d(best, column)) < negligible) continue;
    for (Eigen::Index j = 0; j < n; ++j) std::swap(d(best, j), d(done, j));
    d.row(done) /= double(d(done, column));
    for (Eigen::Index i = 0; i < d.rows(); ++i)
      if (i != done) d.row(i) -= double(d(i, column)) * d.row(done).eval();
    ++done;
  }
}

}  // namespace qdot::detail
