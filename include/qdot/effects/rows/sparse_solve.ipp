#pragma once
// SPDX-License-Identifier: MIT
//
// The factors of sparse_solve.hpp. A program that links qdot::compiled has them from there.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <vector>

#include "qdot/effects/rows/schur_factors.hpp"
#include "qdot/effects/rows/sparse_rows.hpp"
#include "qdot/effects/rows/sparse_solve.hpp"
#include "qdot/mechanics/equations/banded_equations.hpp"

namespace qdot::detail {

// Which coordinates meet, in a row of J or in M.
template <class = void>  // compiled only where it is called
class Neighbours {
 public:
  Neighbours(const BandedMatrix& M, const SparseRows& J) : M_(M), J_(J), first_(static_cast<std::size_t>(M.size()) + 1, 0) {
    for (const auto& e : J.entries) ++first_[static_cast<std::size_t>(e.column) + 1];
    for (std::size_t j = 1; j < first_.size(); ++j) first_[j] += first_[j - 1];
    rows_.resize(J.entries.size());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t row = 0; row < J.size(); ++row)
      for (const auto* e = J.begin(row); e != J.end(row); ++e) rows_[next[static_cast<std::size_t>(e->column)]++] = row;
  }

  // All coordinates, neighbours near neighbours: breadth first from one end of each part to the other, and reversed.
  std::vector<int> order() const {
    const auto n = static_cast<std::size_t>(M_.size());
    std::vector<int> all;
    std::vector<bool> done(n, false);
    for (std::size_t k = 0; k < n; ++k) {
      if (done[k]) continue;
      std::vector<bool> seen = done;
      const std::vector<int> there = breadth_first(static_cast<int>(k), seen);
      const std::vector<int> back = breadth_first(there.back(), done);
      all.insert(all.end(), back.begin(), back.end());
    }
    std::reverse(all.begin(), all.end());
    return all;
  }

 private:
  std::vector<int> breadth_first(int from, std::vector<bool>& seen) const {
    std::vector<bool> row_seen(J_.size(), false);
    std::vector<int> found{from};
    seen[static_cast<std::size_t>(from)] = true;
    const auto meet = [&](Eigen::Index j) {
      if (seen[static_cast<std::size_t>(j)]) return;
      seen[static_cast<std::size_t>(j)] = true;
      found.push_back(static_cast<int>(j));
    };
    for (std::size_t k = 0; k < found.size(); ++k) {
      const Eigen::Index i = found[k];
      for (std::size_t at = first_[static_cast<std::size_t>(i)]; at < first_[static_cast<std::size_t>(i) + 1]; ++at) {
        if (row_seen[rows_[at]]) continue;
        row_seen[rows_[at]] = true;
        for (const auto* e = J_.begin(rows_[at]); e != J_.end(rows_[at]); ++e) meet(e->column);
      }
      for (Eigen::Index j = std::max<Eigen::Index>(0, i - M_.reach()); j < i; ++j)
        if (M_(i, j) != 0.0) meet(j);
      for (Eigen::Index j = i + 1; j < std::min(M_.size(), i + M_.reach() + 1); ++j)
        if (M_(j, i) != 0.0) meet(j);
    }
    return found;
  }

  const BandedMatrix& M_;
  const SparseRows& J_;
  std::vector<std::size_t> first_, rows_;  // rows of a coordinate
};

/// L D Lᵀ of M and J together, or of J M⁻¹ Jᵀ where M is diagonal and constraints that meet are near each other.
template <class = void>  // compiled only where it is called
class EnvelopeFactors final : public SparseFactors {
 public:
  bool compute(const BandedMatrix& M, const SparseRows& J, double massless, double dependent, double rounding = -1.0) override {
    const auto n = static_cast<std::size_t>(M.size());
    of_rows_ = M.reach() == 0 && rows_.arrange(n, J);
    if (of_rows_) return rows_.compute(M, J, dependent, rounding);
    std::vector<int> order(n);
    for (std::size_t k = 0; k < n; ++k) order[k] = static_cast<int>(k);
    arrange(M, J, order);
    if (envelope() > narrow * first_.size()) {
      const std::size_t as_numbered = envelope();
      const std::vector<int> nearby = Neighbours<>(M, J).order();
      arrange(M, J, nearby);
      if (envelope() >= as_numbered) arrange(M, J, order);
    }
    write(M, J);
    return factor(J, massless, dependent, rounding);
  }

  Eigen::Index rank() const noexcept override { return of_rows_ ? rows_.rank : rank_; }
  double smallest_pivot() const noexcept override { return of_rows_ ? rows_.smallest_pivot : smallest_pivot_; }
  Eigen::Index weakest_constraint() const noexcept override { return of_rows_ ? rows_.weakest : weakest_; }

  bool solve(const SparseRows& J, Eigen::VectorXd& f, Eigen::VectorXd& gamma, bool matters = true) override {
    if (of_rows_) return rows_.solve(J, f, gamma, matters);
    const std::size_t size = unknown_.size();
    for (std::size_t p = 0; p < size; ++p) {
      double sum = unknown_[p] >= 0 ? f[unknown_[p]] : gamma[~unknown_[p]];
      const double* const row = at(p);
      for (std::size_t k = first_[p]; k < p; ++k) sum -= row[k] * x_[k];
      if (inverse_[p] == 0.0 && sum != 0.0 && matters) return false;
      x_[p] = sum;
    }
    for (std::size_t p = 0; p < size; ++p) x_[p] *= inverse_[p];
    double zero = 0.0;
    for (std::size_t p = size; p-- > 0;) {
      const double* const row = at(p);
      for (std::size_t k = first_[p]; k < p; ++k) x_[k] -= row[k] * x_[p];
      zero += x_[p] - x_[p];
      if (unknown_[p] >= 0) {
        f[unknown_[p]] = x_[p];
      } else {
        gamma[~unknown_[p]] = -x_[p];
      }
    }
    return zero == 0.0;
  }

 private:
  static constexpr std::size_t narrow = 16;  // entries of a row

  double* at(std::size_t p) { return entries_.data() + offset_[p]; }
  const double* at(std::size_t p) const { return entries_.data() + offset_[p]; }
  std::size_t envelope() const { return offset_.empty() ? 0 : static_cast<std::size_t>(offset_.back()) + offset_.size(); }

  // Places for all unknowns, and where their rows begin.
  void arrange(const BandedMatrix& M, const SparseRows& J, const std::vector<int>& order) {
    const std::size_t n = order.size(), m = J.size();
    std::vector<std::size_t> rank(n), next(n + 1, 0), rows(m), last(m);
    for (std::size_t k = 0; k < n; ++k) rank[static_cast<std::size_t>(order[k])] = k;
    for (std::size_t row = 0; row < m; ++row) {
      last[row] = 0;
      for (const auto* e = J.begin(row); e != J.end(row); ++e) last[row] = std::max(last[row], rank[static_cast<std::size_t>(e->column)]);
      ++next[last[row] + 1];
    }
    for (std::size_t k = 1; k <= n; ++k) next[k] += next[k - 1];
    for (std::size_t row = 0; row < m; ++row) rows[next[last[row]]++] = row;  // by their last coordinates; next[k] is now where those of k end
    place_.resize(n);
    unknown_.clear();
    for (std::size_t k = 0, row = 0; k < n; ++k) {
      place_[static_cast<std::size_t>(order[k])] = unknown_.size();
      unknown_.push_back(order[k]);
      for (; row < next[k]; ++row) unknown_.push_back(~static_cast<int>(rows[row]));
    }
    first_.resize(n + m);
    offset_.resize(n + m);
    std::ptrdiff_t end = 0;
    for (std::size_t p = 0; p < n + m; ++p) {
      std::size_t first = p;
      if (unknown_[p] < 0) {
        const auto row = static_cast<std::size_t>(~unknown_[p]);
        for (const auto* e = J.begin(row); e != J.end(row); ++e) first = std::min(first, place_[static_cast<std::size_t>(e->column)]);
      } else {
        for_each_in_row(M, unknown_[p], [&](Eigen::Index j, double) { first = std::min(first, place_[static_cast<std::size_t>(j)]); });
      }
      first_[p] = first;
      offset_[p] = end - static_cast<std::ptrdiff_t>(first);
      end += static_cast<std::ptrdiff_t>(p - first) + 1;
    }
  }

  // Entries of row i of M beside its diagonal.
  template <class Visit>
  static void for_each_in_row(const BandedMatrix& M, Eigen::Index i, Visit&& visit) {
    for (Eigen::Index j = std::max<Eigen::Index>(0, i - M.reach()); j < i; ++j)
      if (M(i, j) != 0.0) visit(j, M(i, j));
    for (Eigen::Index j = i + 1; j < std::min(M.size(), i + M.reach() + 1); ++j)
      if (M(j, i) != 0.0) visit(j, M(j, i));
  }

  void write(const BandedMatrix& M, const SparseRows& J) {
    const std::size_t size = unknown_.size();
    entries_.assign(size == 0 ? 0 : static_cast<std::size_t>(offset_.back()) + size, 0.0);
    inverse_.resize(size);
    x_.resize(size);
    for (std::size_t p = 0; p < size; ++p) {
      double* const row = at(p);
      if (unknown_[p] < 0) {
        const auto k = static_cast<std::size_t>(~unknown_[p]);
        for (const auto* e = J.begin(k); e != J.end(k); ++e) row[place_[static_cast<std::size_t>(e->column)]] = e->value;
      } else {
        row[p] = M(unknown_[p], unknown_[p]);
        for_each_in_row(M, unknown_[p], [&](Eigen::Index j, double m) {
          if (place_[static_cast<std::size_t>(j)] < p) row[place_[static_cast<std::size_t>(j)]] = m;
        });
      }
    }
  }

  bool factor(const SparseRows& J, double massless, double dependent, double rounding) {
    rank_ = static_cast<Eigen::Index>(J.size());
    smallest_pivot_ = 1.0;
    for (std::size_t p = 0; p < unknown_.size(); ++p) {
      double* const row = at(p);
      for (std::size_t j = first_[p]; j < p; ++j) {
        const double* const other = at(j);
        for (std::size_t k = std::max(first_[p], first_[j]); k < j; ++k) row[j] -= row[k] * other[k];
      }
      double pivot = row[p], length = 0.0;
      for (std::size_t j = first_[p]; j < p; ++j) {
        const double share = row[j] * row[j] * inverse_[j];
        pivot -= share;
        if (unknown_[j] >= 0) length += share;
        row[j] *= inverse_[j];
      }
      if (unknown_[p] >= 0) {
        if (!(pivot > massless * row[p])) return false;
      } else if (length == 0.0 || std::abs(pivot) <= rounding * length) {  // nothing, or nothing of its own
        --rank_;
        inverse_[p] = 0.0;
        continue;
      } else {
        if (-pivot < smallest_pivot_ * length) {
          smallest_pivot_ = -pivot / length;
          weakest_ = ~unknown_[p];
        }
        if (!(-pivot > dependent * length)) return false;
      }
      inverse_[p] = 1.0 / pivot;
    }
    return true;
  }

  std::vector<int> unknown_;           // at each place: coordinate i, or ~i for row i
  std::vector<std::size_t> place_;     // of a coordinate
  std::vector<std::size_t> first_;     // place of the first entry of a row
  std::vector<std::ptrdiff_t> offset_; // of a row's place 0 among the entries, whether it is there or not
  std::vector<double> entries_, inverse_, x_;
  Eigen::Index rank_ = 0, weakest_ = 0;
  double smallest_pivot_ = 1.0;
  bool of_rows_ = false;  // then these are the factors
  SchurFactors rows_;
};

template <class>
std::unique_ptr<SparseFactors> sparse_factors() {
  return std::make_unique<EnvelopeFactors<>>();
}

}  // namespace qdot::detail
