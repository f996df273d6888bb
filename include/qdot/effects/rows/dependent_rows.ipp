#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of dependent_rows.hpp. A program that links qdot::compiled has them from there.

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "qdot/effects/rows/dependent_rows.hpp"

namespace qdot::detail {

inline constexpr double clearly_longer = 1.02;  // squared

template <class>
OrthogonalColumns orthogonal_columns(const Eigen::MatrixXd& A, double cutoff, bool pivoted) {
  const Eigen::Index size = A.rows(), columns = A.cols();
  OrthogonalColumns result{0, Eigen::MatrixXd(size, columns), Eigen::MatrixXd(columns, columns)};
  Eigen::MatrixXd left(A);
  Eigen::Index& rank = result.rank;
  const auto column = [size](Eigen::MatrixXd& M, Eigen::Index j) { return M.data() + j * size; };
  double longest = 0.0;
  while (rank < std::min(size, columns)) {
    Eigen::Index next = rank;
    if (pivoted) {
      for (Eigen::Index j = next = 0; j < columns; ++j)
        if (dot(column(left, j), column(left, j), size) > clearly_longer * dot(column(left, next), column(left, next), size)) next = j;
    }
    double* const q = std::copy_n(column(left, next), size, column(result.Q, rank)) - size;
    const double length = std::sqrt(dot(q, q, size));
    if (rank == 0) longest = length;
    if (length <= cutoff * longest) break;  // NaN goes on, and is found in the result
    for (Eigen::Index k = 0; k < rank; ++k) add(q, -dot(column(result.Q, k), q, size), column(result.Q, k), size);
    const double rest = std::sqrt(dot(q, q, size));
    for (Eigen::Index i = 0; i < size; ++i) q[i] /= rest;
    for (Eigen::Index j = 0; j < columns; ++j) add(column(left, j), -dot(q, column(left, j), size), q, size);
    std::fill_n(column(left, next), size, 0.0);
    ++rank;
  }
  for (Eigen::Index j = 0; j < columns; ++j)
    for (Eigen::Index k = 0; k < rank; ++k) result.C(k, j) = dot(column(result.Q, k), A.data() + j * size, size);
  return result;
}

template <class>
LeastNorm least_norm(const Eigen::MatrixXd& Bt, const double* g, double cutoff) {
  const Eigen::Index size = Bt.rows(), count = Bt.cols();
  const OrthogonalColumns columns = orthogonal_columns(Bt, cutoff, true);
  const Eigen::Index rank = columns.rank;
  Eigen::MatrixXd Ct(count, rank);
  for (Eigen::Index k = 0; k < rank; ++k)
    for (Eigen::Index j = 0; j < count; ++j) Ct(j, k) = columns.C(k, j);
  const OrthogonalColumns rows = orthogonal_columns(Ct, 0.0, false);
  const Eigen::MatrixXd& S = rows.C;
  LeastNorm shortest{Eigen::VectorXd::Zero(size), Eigen::VectorXd::Zero(count), Eigen::VectorXd::Zero(count), rank};
  std::vector<double> c(static_cast<std::size_t>(rank)), w(c);
  const auto at = [](Eigen::Index i) { return static_cast<std::size_t>(i); };
  for (Eigen::Index i = rank; i-- > 0;) {
    double sum = dot(rows.Q.data() + i * count, g, count);
    for (Eigen::Index j = i + 1; j < rank; ++j) sum -= S(i, j) * c[at(j)];
    c[at(i)] = sum / S(i, i);
  }
  for (Eigen::Index i = 0; i < rank; ++i) {
    double sum = c[at(i)];
    for (Eigen::Index j = 0; j < i; ++j) sum -= S(j, i) * w[at(j)];
    w[at(i)] = sum / S(i, i);
    add(shortest.d.data(), c[at(i)], columns.Q.data() + i * size, size);
    add(shortest.lambda.data(), w[at(i)], rows.Q.data() + i * count, count);
  }
  for (Eigen::Index i = 0; i < count; ++i) shortest.miss[i] = dot(Bt.data() + i * size, shortest.d.data(), size) - g[i];
  return shortest;
}

template <class>
bool pivoted_elimination(Eigen::MatrixXd& K, double* right, double* x) {
  const Eigen::Index size = K.rows();
  std::vector<Eigen::Index> place(static_cast<std::size_t>(size));  // of each column
  for (Eigen::Index j = 0; j < size; ++j) place[static_cast<std::size_t>(j)] = j;
  Eigen::Index rank = 0;
  for (double first = 0.0; rank < size; ++rank) {
    Eigen::Index row = rank, column = rank;
    for (Eigen::Index j = rank; j < size; ++j)
      for (Eigen::Index i = rank; i < size; ++i)
        if (std::abs(K(i, j)) > std::abs(K(row, column))) row = i, column = j;
    const double largest_left = std::abs(K(row, column));
    if (rank == 0) first = largest_left;
    for (Eigen::Index i = 0; i < size; ++i) std::swap(K(i, rank), K(i, column));
    std::swap(place[static_cast<std::size_t>(rank)], place[static_cast<std::size_t>(column)]);
    if (largest_left <= std::numeric_limits<double>::epsilon() * static_cast<double>(size) * first) break;
    for (Eigen::Index j = 0; j < size; ++j) std::swap(K(rank, j), K(row, j));
    std::swap(right[rank], right[row]);
    for (Eigen::Index i = rank + 1; i < size; ++i) {
      const double factor = K(i, rank) / K(rank, rank);
      for (Eigen::Index j = rank + 1; j < size; ++j) K(i, j) -= factor * K(rank, j);
      right[i] -= factor * right[rank];
    }
  }
  for (Eigen::Index i = 0; i < size; ++i) x[i] = 0.0;
  const auto entry = [&](Eigen::Index j) -> double& { return x[place[static_cast<std::size_t>(j)]]; };
  const bool regular = rank == size;
  if (!regular) entry(rank) = 1.0;
  for (Eigen::Index i = rank; i-- > 0;) {
    double sum = regular ? right[i] : -K(i, rank);
    for (Eigen::Index j = i + 1; j < rank; ++j) sum -= K(i, j) * entry(j);
    entry(i) = sum / K(i, i);
  }
  return regular;
}

}  // namespace qdot::detail
