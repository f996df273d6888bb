#pragma once
// SPDX-License-Identifier: MIT
//
// L D Lᵀ of a symmetric matrix with few entries, whose pattern is known once and for all.
//
// Bodies in a row meet their neighbours, and rows of L kept from their first entry on (a skyline) have hardly more entries than the matrix: elimination is a
// few multiplications and a division for each row. Where that would be wide, as in a net, Eigen's SimplicialLDLT orders the unknowns and finds its pattern.
// The pattern is analysed when an object is made, and each factorization uses it.
//
// A pivot is judged as a fraction of its diagonal entry, the smallest of them is kept.

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cstddef>
#include <memory>
#include <vector>

namespace qdot::detail {

class PatternFactors {
 public:
  /// Entry k of the lower triangle is (rows[k], columns[k]); by rows, in each the columns ascending, with all diagonal entries.
  PatternFactors(std::size_t size, const std::vector<int>& rows, const std::vector<int>& columns) : rows_(size), place_(rows.size()) {
    for (std::size_t i = 0; i < size; ++i) rows_[i].first = i;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const auto i = static_cast<std::size_t>(rows[k]), j = static_cast<std::size_t>(columns[k]);
      rows_[i].first = std::min(rows_[i].first, j);
      rows_[i].end = k + 1;  // behind the diagonal entry, the last of its row
    }
    std::size_t entries = 0;
    for (std::size_t i = 0; i < size; ++i) {
      rows_[i].offset = static_cast<std::ptrdiff_t>(entries) - static_cast<std::ptrdiff_t>(rows_[i].first);
      entries += i - rows_[i].first + 1;
      for (std::size_t j = rows_[i].first; j < i; ++j) rows_[j].last = i;
    }
    if (entries > widest * size && size > small) {
      analyse(rows, columns);
      return;
    }
    skyline_.resize(entries);
    for (std::size_t k = 0; k < rows.size(); ++k) place_[k] = rows_[static_cast<std::size_t>(rows[k])].offset + columns[k];
    std::size_t most = 0;
    for (std::size_t i = 0; i < size; ++i) most = std::max(most, rows_[i].last > i ? rows_[i].last - i : 0);
    column_.resize(most);
  }

  std::size_t size() const { return rows_.size(); }
  double smallest_pivot() const { return smallest_; }

  /// Factors the matrix whose entry k is value(k); false where a pivot is not above `threshold` of its diagonal entry, or an entry is not finite.
  template <class Value>
  bool compute(const Value& value, double threshold) { return sparse_ ? compute_sparse(value, threshold) : compute_skyline(value, threshold); }

  /// x ← A⁻¹ x.
  void solve(double* x) {
    if (sparse_) {
      Eigen::Map<Eigen::VectorXd> b(x, static_cast<Eigen::Index>(size()));
      b = sparse_->factors.solve(b).eval();
      return;
    }
    const double* const skyline = skyline_.data();
    for (std::size_t i = 0; i < size(); ++i) {
      const Row& own = rows_[i];
      double sum = x[i];
      for (std::size_t j = own.first; j < i; ++j) sum -= skyline[own.offset + static_cast<std::ptrdiff_t>(j)] * x[j];
      x[i] = sum;
    }
    for (std::size_t i = 0; i < size(); ++i) x[i] *= rows_[i].inverse;
    for (std::size_t i = size(); i-- > 0;) {
      const Row& own = rows_[i];
      const double xi = x[i];
      for (std::size_t j = own.first; j < i; ++j) x[j] -= skyline[own.offset + static_cast<std::ptrdiff_t>(j)] * xi;
    }
  }

 private:
  static constexpr std::size_t widest = 24, small = 48;

  struct Sparse {
    Eigen::SparseMatrix<double> A;
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> factors;
  };

  [[gnu::cold]] void analyse(const std::vector<int>& rows, const std::vector<int>& columns) {
    const auto n = static_cast<Eigen::Index>(size());
    auto made = std::make_shared<Sparse>();
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t k = 0; k < rows.size(); ++k) entries.emplace_back(rows[k], columns[k], static_cast<double>(k));
    made->A.resize(n, n);
    made->A.setFromTriplets(entries.begin(), entries.end());
    for (Eigen::Index at = 0; at < made->A.nonZeros(); ++at) place_[static_cast<std::size_t>(made->A.valuePtr()[at])] = at;
    made->factors.analyzePattern(made->A);
    sparse_ = std::move(made);
  }

  template <class Value>
  bool compute_sparse(const Value& value, double threshold) {
    Sparse& s = own();
    double zero = 0.0;
    for (std::size_t k = 0; k < place_.size(); ++k) {
      const double x = value(k);
      zero += x - x;
      s.A.valuePtr()[place_[k]] = x;
    }
    if (!(zero == 0.0)) return false;
    s.factors.factorize(s.A);
    if (s.factors.info() != Eigen::Success) return false;
    const auto D = s.factors.vectorD();
    const auto& place = s.factors.permutationP().indices();
    smallest_ = 1.0;
    for (std::size_t i = 0; i < size(); ++i) {
      const double pivot = D[place.size() > 0 ? place[static_cast<Eigen::Index>(i)] : static_cast<Eigen::Index>(i)], whole = value(rows_[i].end - 1);
      if (!(pivot > threshold * whole)) return false;
      smallest_ = std::min(smallest_, pivot / whole);
    }
    return true;
  }

  // A copy of this object shares what it has analysed until one of them factors.
  Sparse& own() {
    if (sparse_.use_count() > 1) {
      auto copy = std::make_shared<Sparse>();
      copy->A = sparse_->A;
      copy->factors.analyzePattern(copy->A);
      sparse_ = std::move(copy);
    }
    return *sparse_;
  }

  // From left to right: when a pivot is known, its column is taken from all rows below at once, so that a row waits for one division and not for sums.
  template <class Value>
  bool compute_skyline(const Value& value, double threshold) {
    double* const skyline = skyline_.data();
    double* __restrict const column = column_.data();
    std::fill(skyline_.begin(), skyline_.end(), 0.0);
    for (std::size_t k = 0; k < place_.size(); ++k) skyline[place_[k]] = value(k);
    double smallest = 1.0, zero = 0.0;
    for (std::size_t i = 0; i < size(); ++i) {
      Row& own = rows_[i];
      const double pivot = skyline[own.offset + static_cast<std::ptrdiff_t>(i)], whole = value(own.end - 1);
      if (!(pivot > threshold * whole)) return false;
      if (pivot < smallest * whole) smallest = pivot / whole;
      own.inverse = 1.0 / pivot;
      zero += own.inverse - own.inverse;
      for (std::size_t j = i + 1; j <= own.last; ++j) column[j - i - 1] = rows_[j].first <= i ? skyline[rows_[j].offset + static_cast<std::ptrdiff_t>(i)] : 0.0;
      for (std::size_t j = i + 1; j <= own.last; ++j) {
        if (rows_[j].first > i) continue;
        double* __restrict const row = skyline + rows_[j].offset + static_cast<std::ptrdiff_t>(i);
        const double share = column[j - i - 1] * own.inverse;
        row[0] = share;
        for (std::size_t k = 0; k < j - i; ++k) row[k + 1] -= share * column[k];
      }
    }
    smallest_ = smallest;
    return zero == 0.0;
  }

  struct Row {
    std::size_t first = 0, last = 0;  // column of the first entry; the last row that has one in column i
    std::size_t end = 0;              // behind the row's entries of the pattern
    std::ptrdiff_t offset = 0;       // of its place 0 in the skyline, whether it is there or not
    double inverse = 0.0;            // of the pivot
  };
  std::vector<Row> rows_;
  std::vector<double> skyline_, column_;
  std::vector<std::ptrdiff_t> place_;  // of each entry in the skyline, or in the sparse matrix
  double smallest_ = 1.0;
  std::shared_ptr<Sparse> sparse_;
};

}  // namespace qdot::detail
