#pragma once
// SPDX-License-Identifier: MIT
//
// Vectors and matrices of run-time size for code that no scene's type enters: those of small scenes need no allocation.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "qdot/ad/vector.hpp"

namespace qdot::detail {

/// Numbers one after the other, up to `inside` of them in the object itself.
template <class Number, std::size_t inside>
class SmallStore {
 public:
  SmallStore() = default;
  SmallStore(const SmallStore& other) { *this = other; }
  SmallStore& operator=(const SmallStore& other) {  // of what is there: the rest has no values
    if (this == &other) return *this;
    resize(other.count_);
    std::copy_n(other.data_, count_, data_);
    return *this;
  }

  /// Without values.
  void resize(std::size_t count) {
    if (count > inside) {
      outside_.resize(count);
      data_ = outside_.data();
    }
    count_ = count;
  }
  Number* data() { return data_; }
  const Number* data() const { return data_; }
  std::size_t count() const { return count_; }
  Number& operator[](std::size_t i) { return data_[i]; }
  const Number& operator[](std::size_t i) const { return data_[i]; }

 private:
  std::array<Number, inside> inside_;
  std::vector<Number> outside_;
  Number* data_ = inside_.data();  // once outside, it stays there
  std::size_t count_ = 0;
};

/// A vector; no allocation for up to 24 numbers.
class Column {
 public:
  Column() = default;
  explicit Column(Eigen::Index size) { resize(size); }
  Column(Eigen::Index size, double value) : Column(size) { std::fill_n(data(), size, value); }
  Column(const double* first, Eigen::Index size) : Column(size) { std::copy_n(first, size, data()); }
  /// A copy of a vector of Eigen's.
  template <int n>
  Column(const Eigen::Matrix<double, n, 1, 0, n, 1>& x) : Column(x.data(), x.size()) {}
  operator Eigen::VectorXd() const { return Eigen::Map<const Eigen::VectorXd>(data(), size()); }

  void resize(Eigen::Index size) { store_.resize(static_cast<std::size_t>(size)); }
  Eigen::Index size() const { return static_cast<Eigen::Index>(store_.count()); }
  Eigen::Index rows() const { return size(); }
  Eigen::Index cols() const { return 1; }
  double* data() { return store_.data(); }
  const double* data() const { return store_.data(); }
  double& operator[](Eigen::Index i) { return data()[i]; }
  double operator[](Eigen::Index i) const { return data()[i]; }
  double& operator()(Eigen::Index i, Eigen::Index) { return data()[i]; }
  double operator()(Eigen::Index i, Eigen::Index) const { return data()[i]; }

 private:
  SmallStore<double, 24> store_;
};

/// A matrix, column by column; no allocation for up to 128 numbers.
class Table {
 public:
  Table() = default;
  Table(Eigen::Index rows, Eigen::Index columns) { resize(rows, columns); }
  Table(Eigen::Index rows, Eigen::Index columns, double value) : Table(rows, columns) { std::fill_n(data(), size(), value); }
  /// A copy of a matrix of Eigen's.
  template <int rows, int columns, int options>
  Table(const Eigen::Matrix<double, rows, columns, options, rows, columns>& x) : Table(x.rows(), x.cols()) {
    for (Eigen::Index j = 0; j < columns_; ++j)
      for (Eigen::Index i = 0; i < rows_; ++i) (*this)(i, j) = x(i, j);
  }
  operator Eigen::MatrixXd() const { return Eigen::Map<const Eigen::MatrixXd>(data(), rows_, columns_); }

  void resize(Eigen::Index rows, Eigen::Index columns) {
    rows_ = rows;
    columns_ = columns;
    store_.resize(static_cast<std::size_t>(rows * columns));
  }
  Eigen::Index rows() const { return rows_; }
  Eigen::Index cols() const { return columns_; }
  Eigen::Index size() const { return rows_ * columns_; }
  double* data() { return store_.data(); }
  const double* data() const { return store_.data(); }
  double& operator()(Eigen::Index i, Eigen::Index j) { return data()[i + j * rows_]; }
  double operator()(Eigen::Index i, Eigen::Index j) const { return data()[i + j * rows_]; }

 private:
  SmallStore<double, 128> store_;
  Eigen::Index rows_ = 0, columns_ = 0;
};

// |xᵢ| and −xᵢ of a column, or of a vector of Eigen's.
template <class V>
V magnitudes(const V& x) {
  V sizes(x);
  for (Eigen::Index i = 0; i < x.size(); ++i) sizes[i] = std::abs(x[i]);
  return sizes;
}
template <class V>
V negated(const V& x) {
  V other(x);
  for (Eigen::Index i = 0; i < x.size(); ++i) other[i] = -x[i];
  return other;
}
inline double largest(const Column& x) { return largest(x.data(), x.size()); }

}  // namespace qdot::detail
