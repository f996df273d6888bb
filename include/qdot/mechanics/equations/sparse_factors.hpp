#pragma once
// SPDX-License-Identifier: MIT
//
// L D Lᵀ of a symmetric matrix with few entries, whose pattern is known once and for all.
//
// Bodies in a row meet their neighbours, and rows of L kept from their first entry on have hardly more entries than the matrix. This is a skyline;
// where all rows are short, it is a band of known width: narrow_band.hpp. Elimination is a few multiplications and a division for each row. Where
// that would be wide, as in a net, the unknowns are put in an order that keeps L sparse (sparse_factors.ipp). Rows of L are then found one after
// the other along the elimination tree. Row k has entries where the tree leads to from the entries of row k of the matrix. Reference: T. A.
// Davis, Direct Methods for Sparse Linear Systems, SIAM 2006, chapter 4. All of L is stored by columns.
//
// The pattern is analysed when an object is made. A pivot is judged as a fraction of its diagonal entry.
//
// A matrix like J M⁻¹ Jᵀ whose rows depend on each other is not definite, and still has such factors. Where nothing of a row is left but
// rounding, D has a zero, and the row is no equation of its own. L D Lᵀ x = b then has solutions where y of L y = b is zero there, too;
// the others differ by L⁻ᵀ e of the zeros.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "qdot/mechanics/equations/narrow_band.hpp"

namespace qdot::detail {

template <class Number = double>
class PatternFactors {
 public:
  /// Entry k of the lower triangle is (rows[k], columns[k]); by rows, in each the columns ascending, with all diagonal entries.
  [[gnu::cold]] PatternFactors(std::size_t size, const std::vector<int>& rows, const std::vector<int>& columns) : rows_(size), place_(rows.size()) {
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
    if (entries > widest * size && size > few) {
      analyse(rows, columns);
      if (is_wide_) return;
    }
    std::size_t most_left = 0;
    for (std::size_t i = 0; i < size; ++i) most_left = std::max(most_left, i - rows_[i].first);
    if (most_left <= NarrowBand<Number>::widest) {
      band_.emplace(size, most_left);
      for (std::size_t k = 0; k < rows.size(); ++k)
        place_[k] = static_cast<std::ptrdiff_t>(band_->place(static_cast<std::size_t>(rows[k]), static_cast<std::size_t>(columns[k])));
      return;
    }
    skyline_.resize(entries);
    for (std::size_t k = 0; k < rows.size(); ++k) place_[k] = rows_[static_cast<std::size_t>(rows[k])].offset + columns[k];
    std::size_t most = 0;
    for (std::size_t i = 0; i < size; ++i) most = std::max(most, rows_[i].last > i ? rows_[i].last - i : 0);
    column_.resize(most);
  }

  std::size_t size() const { return rows_.size(); }

  /// Factors the matrix whose entry k is value(k); false where a pivot is not above `threshold` of its diagonal entry, or an entry is not finite.
  ///
  /// @param rounding  pivots that are no larger, as a fraction, are zeros; none are where it is negative
  template <class Value>
  bool compute(const Value& value, Number threshold, Number rounding = -1.0) {
    zeros_.clear();
    if (band_) {
      for (std::size_t k = 0; k < place_.size(); ++k) (*band_)[static_cast<std::size_t>(place_[k])] = value(k);
      return band_->compute(threshold, [&](std::size_t i, Number pivot, Number whole) {
        if (!is_rounding(pivot, whole, rounding)) return false;
        zeros_.push_back({i, std::sqrt(whole)});
        return true;
      });
    }
    return is_wide_ ? compute_along_tree(value, threshold, rounding) : compute_skyline(value, threshold, rounding);
  }

  /// How many zeros there are in D.
  std::size_t zeros() const { return zeros_.size(); }

  /// x ← A⁻¹ x; with zeros in D, a solution where there is one.
  ///
  /// @returns the largest y at a zero over the root of its diagonal entry: what no x has
  Number solve(Number* x) {
    if (is_wide_) return solve_by_columns(x);
    if (band_) {
      band_->solve_lower(x);
      const Number miss = missed(x);
      band_->divide(x);
      band_->solve_upper(x);
      return miss;
    }
    const Number* const skyline = skyline_.data();
    for (std::size_t i = 0; i < size(); ++i) {
      const Row& own = rows_[i];
      Number sum = x[i];
      for (std::size_t j = own.first; j < i; ++j) sum -= skyline[own.offset + static_cast<std::ptrdiff_t>(j)] * x[j];
      x[i] = sum;
    }
    const Number miss = missed(x);
    for (std::size_t i = 0; i < size(); ++i) x[i] *= rows_[i].inverse;
    transposed_solve(x);
    return miss;
  }

  /// x ← the null vector of zero k, with A x = 0; they are independent of each other.
  void null_vector(std::size_t k, Number* x) {
    std::fill_n(x, size(), Number(0.0));
    if (!is_wide_) {
      x[zeros_[k].place] = 1.0;
      if (band_) band_->solve_upper(x);
      else transposed_solve(x);
      return;
    }
    std::vector<Number>& b = sum_;
    b[zeros_[k].place] = 1.0;
    transposed_solve_by_columns(b.data());
    for (std::size_t i = 0; i < size(); ++i) x[i] = std::exchange(b[new_place_[i]], 0.0);
  }

 private:
  static constexpr std::size_t widest = 24, few = 48;

  // Where D is zero, in the order of elimination, and the root of the diagonal entry there.
  struct Zero {
    std::size_t place;
    Number length;
  };
  static bool is_rounding(Number pivot, Number whole, Number rounding) { return rounding >= 0.0 && std::abs(pivot) <= rounding * whole; }
  Number missed(const Number* y) const {
    Number most = 0.0;
    for (const Zero& zero : zeros_)
      if (y[zero.place] != 0.0) most = std::max(most, std::abs(y[zero.place]) / zero.length);
    return most;
  }

  // x ← L⁻ᵀ x.
  void transposed_solve(Number* x) const {
    for (std::size_t i = size(); i-- > 0;) {
      const Row& own = rows_[i];
      const Number xi = x[i];
      for (std::size_t j = own.first; j < i; ++j) x[j] -= skyline_[static_cast<std::size_t>(own.offset + static_cast<std::ptrdiff_t>(j))] * xi;
    }
  }
  void transposed_solve_by_columns(Number* b) const {
    for (std::size_t i = size(); i-- > 0;)
      for (std::size_t at = column_begin_[i]; at < column_begin_[i + 1]; ++at) b[i] -= lower_[at] * b[lower_row_[at]];
  }

  [[gnu::cold]] void analyse(const std::vector<int>& rows, const std::vector<int>& columns) {
    is_wide_ = true;
    const std::size_t n = size();
    order(rows, columns);
    // Row k of the matrix in the new order, left of the diagonal: (column, number among the entries).
    std::vector<std::size_t> begin(n + 1, 0);
    const auto ordered = [&](std::size_t k) {
      return std::minmax(new_place_[static_cast<std::size_t>(rows[k])], new_place_[static_cast<std::size_t>(columns[k])]);
    };
    for (std::size_t k = 0; k < rows.size(); ++k) ++begin[ordered(k).second + 1];
    for (std::size_t i = 0; i < n; ++i) begin[i + 1] += begin[i];
    left_.resize(rows.size());
    std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
    for (std::size_t k = 0; k < rows.size(); ++k) left_[next[ordered(k).second]++] = {ordered(k).first, k};
    left_begin_ = std::move(begin);
    // The tree, and how many entries each column of L has.
    parent_.assign(n, none);
    seen_.assign(n, none);
    std::vector<std::size_t> count(n, 0);
    for (std::size_t k = 0; k < n; ++k) {
      seen_[k] = k;
      for (std::size_t e = left_begin_[k]; e < left_begin_[k + 1]; ++e)
        for (std::size_t i = left_[e].first; seen_[i] != k; i = parent_[i]) {
          if (parent_[i] == none) parent_[i] = k;
          ++count[i];
          seen_[i] = k;
        }
    }
    if (!tree_pays(count)) {
      is_wide_ = false;
      new_place_ = left_begin_ = parent_ = seen_ = {};
      left_ = {};
      return;
    }
    column_begin_.assign(n + 1, 0);
    for (std::size_t i = 0; i < n; ++i) column_begin_[i + 1] = column_begin_[i] + count[i];
    lower_.resize(column_begin_[n]);
    lower_row_.resize(column_begin_[n]);
    column_end_.resize(n);
    pivot_.resize(n);
    sum_.assign(n, 0.0);
    path_.resize(n);
    along_.resize(n);
  }

  // Whether L with so many entries in its columns takes fewer products than rows from end to end. A full matrix has no order that helps.
  bool tree_pays(const std::vector<std::size_t>& count) const {
    constexpr double by_index = 1.1;  // times that of a product of neighbours: measured for full matrices and nets
    double along_tree = 0.0, along_rows = 0.0;
    for (const std::size_t entries : count) along_tree += static_cast<double>(entries * entries);
    for (std::size_t i = 0; i < size(); ++i) along_rows += static_cast<double>((i - rows_[i].first) * (i - rows_[i].first));
    return by_index * along_tree < along_rows;
  }

  // new_place_ ← by minimum degree.
  void order(const std::vector<int>& rows, const std::vector<int>& columns);

  template <class Value>
  bool compute_along_tree(const Value& value, Number threshold, Number rounding) {
    std::fill(seen_.begin(), seen_.end(), none);
    std::copy(column_begin_.begin(), column_begin_.end() - 1, column_end_.begin());
    Number zero = 0.0;
    for (std::size_t k = 0; k < size(); ++k) {
      // Row k of the matrix, and where row k of L is other than zero, from the leaves on.
      std::size_t top = size();
      Number pivot = 0.0;
      seen_[k] = k;
      for (std::size_t e = left_begin_[k]; e < left_begin_[k + 1]; ++e) {
        std::size_t i = left_[e].first, length = 0;
        const Number entry = value(left_[e].second);
        if (i == k) {
          pivot = entry;
          continue;
        }
        sum_[i] += entry;
        for (; seen_[i] != k; i = parent_[i]) {
          path_[length++] = i;
          seen_[i] = k;
        }
        while (length > 0) along_[--top] = path_[--length];
      }
      const Number whole = pivot;
      for (; top < size(); ++top) {
        const std::size_t i = along_[top];
        const Number x = std::exchange(sum_[i], 0.0), share = x / pivot_[i];
        for (std::size_t at = column_begin_[i]; at < column_end_[i]; ++at) sum_[lower_row_[at]] -= lower_[at] * x;
        pivot -= share * x;
        lower_row_[column_end_[i]] = k;
        lower_[column_end_[i]++] = share;
      }
      pivot_[k] = pivot;
      zero += pivot - pivot;
      if (pivot > threshold * whole) continue;
      if (!is_rounding(pivot, whole, rounding)) {
        std::fill(sum_.begin(), sum_.end(), 0.0);
        return false;
      }
      zeros_.push_back({k, std::sqrt(whole)});
      pivot_[k] = std::numeric_limits<Number>::infinity();  // takes no part
    }
    return zero == 0.0;
  }

  Number solve_by_columns(Number* x) {
    std::vector<Number>& b = sum_;
    for (std::size_t i = 0; i < size(); ++i) b[new_place_[i]] = x[i];
    for (std::size_t i = 0; i < size(); ++i)
      for (std::size_t at = column_begin_[i]; at < column_begin_[i + 1]; ++at) b[lower_row_[at]] -= lower_[at] * b[i];
    const Number miss = missed(b.data());
    for (std::size_t i = 0; i < size(); ++i) b[i] /= pivot_[i];
    transposed_solve_by_columns(b.data());
    for (std::size_t i = 0; i < size(); ++i) x[i] = std::exchange(b[new_place_[i]], 0.0);
    return miss;
  }

  // From left to right: when a pivot is known, its column is taken from all rows below at once. So a row waits for one division and not for sums.
  template <class Value>
  bool compute_skyline(const Value& value, Number threshold, Number rounding) {
    Number* const skyline = skyline_.data();
    Number* __restrict const column = column_.data();
    std::fill(skyline_.begin(), skyline_.end(), 0.0);
    for (std::size_t k = 0; k < place_.size(); ++k) skyline[place_[k]] = value(k);
    Number zero = 0.0;
    for (std::size_t i = 0; i < size(); ++i) {
      Row& own = rows_[i];
      const Number pivot = skyline[own.offset + static_cast<std::ptrdiff_t>(i)], whole = value(own.end - 1);
      if (pivot > threshold * whole) {
        own.inverse = 1.0 / pivot;
      } else {
        if (!is_rounding(pivot, whole, rounding)) return false;
        zeros_.push_back({i, std::sqrt(whole)});
        own.inverse = 0.0;  // takes no part
      }
      zero += own.inverse - own.inverse;
      for (std::size_t j = i + 1; j <= own.last; ++j) column[j - i - 1] = rows_[j].first <= i ? skyline[rows_[j].offset + static_cast<std::ptrdiff_t>(i)] : 0.0;
      for (std::size_t j = i + 1; j <= own.last; ++j) {
        if (rows_[j].first > i) continue;
        Number* __restrict const row = skyline + rows_[j].offset + static_cast<std::ptrdiff_t>(i);
        const Number share = column[j - i - 1] * own.inverse;
        row[0] = share;
        for (std::size_t k = 0; k < j - i; ++k) row[k + 1] -= share * column[k];
      }
    }
    return zero == 0.0;
  }

  struct Row {
    std::size_t first = 0, last = 0;  // column of the first entry; the last row that has one in column i
    std::size_t end = 0;              // behind the row's entries of the pattern
    std::ptrdiff_t offset = 0;       // of its place 0 in the skyline, whether it is there or not
    Number inverse = 0.0;            // of the pivot
  };
  std::vector<Row> rows_;
  std::vector<Number> skyline_, column_;
  std::vector<std::ptrdiff_t> place_;  // of each entry in the skyline or the band
  std::vector<Zero> zeros_;
  std::optional<NarrowBand<Number>> band_;  // of narrow patterns, in place of a skyline

  // Of wide patterns: L by columns, and what is needed to find it.
  static constexpr std::size_t none = static_cast<std::size_t>(-1);
  bool is_wide_ = false;
  std::vector<std::size_t> new_place_, left_begin_, parent_, column_begin_, column_end_, lower_row_, seen_, path_, along_;
  std::vector<std::pair<std::size_t, std::size_t>> left_;
  std::vector<Number> lower_, pivot_, sum_;
};

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template void PatternFactors<double>::order(const std::vector<int>&, const std::vector<int>&);
}  // namespace qdot::detail
#else
#include "qdot/mechanics/equations/sparse_factors.ipp"
#endif
