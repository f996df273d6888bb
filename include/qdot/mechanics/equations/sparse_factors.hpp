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
  PatternFactors(std::size_t size, const std::vector<int>& rows, const std::vector<int>& columns)
      : first_(size), diagonal_(size), offset_(size), inverse_(size), place_(rows.size()) {
    for (std::size_t i = 0; i < size; ++i) first_[i] = i;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const auto i = static_cast<std::size_t>(rows[k]), j = static_cast<std::size_t>(columns[k]);
      first_[i] = std::min(first_[i], j);
      if (i == j) diagonal_[i] = k;
    }
    std::size_t entries = 0;
    for (std::size_t i = 0; i < size; ++i) {
      offset_[i] = static_cast<std::ptrdiff_t>(entries) - static_cast<std::ptrdiff_t>(first_[i]);
      entries += i - first_[i];
    }
    if (entries > widest * size && size > small) {
      analyse(rows, columns);
      return;
    }
    skyline_.resize(entries);
    for (std::size_t k = 0; k < rows.size(); ++k)
      place_[k] = rows[k] == columns[k] ? -1 : offset_[static_cast<std::size_t>(rows[k])] + columns[k];
  }

  std::size_t size() const { return inverse_.size(); }
  double smallest_pivot() const { return smallest_; }

  /// False where a pivot is not above `threshold` of its diagonal entry.
  bool compute(const double* values, double threshold) { return sparse_ ? compute_sparse(values, threshold) : compute_skyline(values, threshold); }

  /// x ← A⁻¹ x.
  void solve(double* x) {
    if (sparse_) {
      Eigen::Map<Eigen::VectorXd> b(x, static_cast<Eigen::Index>(size()));
      b = sparse_->factors.solve(b).eval();
      return;
    }
    const std::size_t n = size();
    for (std::size_t i = 0; i < n; ++i) {
      const double* const row = skyline_.data() + offset_[i];
      double sum = x[i];
      for (std::size_t j = first_[i]; j < i; ++j) sum -= row[j] * x[j];
      x[i] = sum;
    }
    for (std::size_t i = 0; i < n; ++i) x[i] *= inverse_[i];
    for (std::size_t i = n; i-- > 0;) {
      const double* const row = skyline_.data() + offset_[i];
      const double xi = x[i];
      for (std::size_t j = first_[i]; j < i; ++j) x[j] -= row[j] * xi;
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

  bool compute_sparse(const double* values, double threshold) {
    Sparse& s = own();
    for (std::size_t k = 0; k < place_.size(); ++k) s.A.valuePtr()[place_[k]] = values[k];
    s.factors.factorize(s.A);
    if (s.factors.info() != Eigen::Success) return false;
    const auto D = s.factors.vectorD();
    const auto& place = s.factors.permutationP().indices();
    smallest_ = 1.0;
    for (std::size_t i = 0; i < size(); ++i) {
      const double pivot = D[place.size() > 0 ? place[static_cast<Eigen::Index>(i)] : static_cast<Eigen::Index>(i)], whole = values[diagonal_[i]];
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

  bool compute_skyline(const double* values, double threshold) {
    std::fill(skyline_.begin(), skyline_.end(), 0.0);
    for (std::size_t k = 0; k < place_.size(); ++k)
      if (place_[k] >= 0) skyline_[static_cast<std::size_t>(place_[k])] = values[k];
    smallest_ = 1.0;
    for (std::size_t i = 0; i < size(); ++i) {
      double* const row = skyline_.data() + offset_[i];
      const std::size_t first = first_[i];
      const double whole = values[diagonal_[i]];
      double pivot = whole;
      for (std::size_t j = first; j < i; ++j) {
        const double* const other = skyline_.data() + offset_[j];
        double sum = row[j];
        for (std::size_t k = std::max(first, first_[j]); k < j; ++k) sum -= row[k] * other[k];
        row[j] = sum;
      }
      for (std::size_t j = first; j < i; ++j) {
        const double share = row[j] * inverse_[j];
        pivot -= row[j] * share;
        row[j] = share;
      }
      if (!(pivot > threshold * whole)) return false;
      if (pivot < smallest_ * whole) smallest_ = pivot / whole;
      inverse_[i] = 1.0 / pivot;
    }
    return true;
  }

  std::vector<std::size_t> first_, diagonal_;
  std::vector<std::ptrdiff_t> offset_;
  std::vector<double> skyline_, inverse_;
  std::vector<std::ptrdiff_t> place_;  // of each entry in the skyline, −1 on the diagonal; or in the sparse matrix
  double smallest_ = 1.0;
  std::shared_ptr<Sparse> sparse_;
};

}  // namespace qdot::detail
