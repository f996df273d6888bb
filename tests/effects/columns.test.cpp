// SPDX-License-Identifier: MIT
//
// Vectors and matrices of run-time size that are small without an allocation: what they hold, however they are copied.

#include "qdot/effects/rows/columns.hpp"

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "../catch2_bridge.hpp"

namespace {

using qdot::detail::Column;
using qdot::detail::Table;

// 1, 2, 3, …
Column counted(Eigen::Index size) {
  Column x(size);
  for (Eigen::Index i = 0; i < size; ++i) x[i] = static_cast<double>(i + 1);
  return x;
}
bool is_counted(const Column& x, Eigen::Index size) {
  bool right = x.size() == size;
  for (Eigen::Index i = 0; right && i < size; ++i) right = x[i] == static_cast<double>(i + 1);
  return right;
}

}  // namespace

TEST_CASE("a column holds its numbers when it is copied, moved and assigned over any other") {
  const std::vector<Eigen::Index> sizes{0, 1, 23, 24, 25, 300};
  for (const Eigen::Index size : sizes) {
    const Column x = counted(size);
    CHECK(is_counted(x, size));
    Column copy(x), moved(std::move(copy));
    CHECK(is_counted(moved, size));
    for (const Eigen::Index other : sizes) {
      Column y = counted(other);
      y = x;
      CHECK(is_counted(y, size));
      y = counted(other);
      CHECK(is_counted(y, other));
    }
    Column& same = moved;
    moved = same;
    CHECK(is_counted(moved, size));
    CHECK(is_counted(x, size));
  }
}

TEST_CASE("columns and tables are those of Eigen, column by column") {
  const Eigen::Vector3d v(1.0, 2.0, 3.0);
  CHECK(is_counted(Column(v), 3));
  CHECK(Eigen::VectorXd(Column(v)) == v);
  Eigen::Matrix<double, 1, 3> row;  // Eigen keeps it in a row
  row << 1.0, 2.0, 3.0;
  CHECK(Eigen::MatrixXd(Table(row)) == row);
  for (const Eigen::Index rows : {2, 20}) {
    Eigen::MatrixXd A(rows, 11);
    for (Eigen::Index j = 0; j < A.cols(); ++j)
      for (Eigen::Index i = 0; i < rows; ++i) A(i, j) = static_cast<double>(100 * i + j);
    Table table(A), copy(1, 1);
    copy = table;
    table(0, 1) = -1.0;
    CHECK(Eigen::MatrixXd(copy) == A);
    CHECK(table(0, 1) == -1.0);
    CHECK(table.data()[rows] == -1.0);
  }
}
