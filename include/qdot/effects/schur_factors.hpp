#pragma once
// SPDX-License-Identifier: MIT
//
// M q̈ − Jᵀλ = f, J q̈ = γ for a diagonal M, as that of point masses and of bodies in a plane in Cartesian coordinates.
//
//     (J M⁻¹ Jᵀ) λ = γ − J M⁻¹ f ,     q̈ = M⁻¹ (f + Jᵀλ)
//
// An entry of J M⁻¹ Jᵀ is other than zero where two rows meet in a coordinate. With a matrix of only so many rows as there are constraints, a chain
// has three entries in each. Rows of L are kept from their first entry on (an envelope). Constraints are taken as they are numbered or, where that
// makes it wide, in the order of the last coordinate that each touches.
//
// A pivot, as a fraction of the diagonal entry, is the square of the sine between a row and those before it, in the metric of M.

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

#include "qdot/effects/sparse_rows.hpp"
#include "qdot/mechanics/banded_equations.hpp"

namespace qdot::detail {

class SchurFactors {
 public:
  /// False where neither order keeps rows that meet near each other.
  bool arrange(std::size_t coordinates, const SparseRows& J) {
    order_.resize(J.size());
    std::iota(order_.begin(), order_.end(), std::size_t(0));
    if (is_narrow(coordinates, J)) return true;
    std::vector<int> last(J.size(), 0);
    for (std::size_t row = 0; row < J.size(); ++row)
      for (const auto* e = J.begin(row); e != J.end(row); ++e) last[row] = std::max(last[row], e->column);
    std::stable_sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) { return last[a] < last[b]; });
    return is_narrow(coordinates, J);
  }

  /// After arrange(). False when an inertia is not positive, or a pivot is below `dependent` of its diagonal entry.
  bool compute(const BandedMatrix& M, const SparseRows& J, double dependent) {
    const auto n = static_cast<std::size_t>(M.size());
    mobility_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const double inertia = M(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i));
      if (!(inertia > 0.0)) return false;
      mobility_[i] = 1.0 / inertia;
    }
    std::vector<double> moved(n, 0.0);  // M⁻¹ times a row of J
    rank = static_cast<Eigen::Index>(J.size());
    smallest_pivot = 1.0;
    entries_.resize(offset_.empty() ? 0 : static_cast<std::size_t>(offset_.back()) + offset_.size());
    inverse_.resize(J.size());
    for (std::size_t p = 0; p < J.size(); ++p) {
      double* const row = at(p);
      const std::size_t own = order_[p], first = first_[p];
      double length = 0.0;
      for (const auto* e = J.begin(own); e != J.end(own); ++e) {
        const double x = e->value * mobility_[static_cast<std::size_t>(e->column)];
        moved[static_cast<std::size_t>(e->column)] = x;
        length += x * e->value;
      }
      double pivot = length;
      for (std::size_t j = first; j < p; ++j) {
        double sum = 0.0;
        for (const auto* e = J.begin(order_[j]); e != J.end(order_[j]); ++e) sum += moved[static_cast<std::size_t>(e->column)] * e->value;
        const double* const other = at(j);
        for (std::size_t k = std::max(first, first_[j]); k < j; ++k) sum -= row[k] * other[k];
        row[j] = sum;
      }
      for (std::size_t j = first; j < p; ++j) {
        const double share = row[j] * inverse_[j];
        pivot -= row[j] * share;
        row[j] = share;
      }
      for (const auto* e = J.begin(own); e != J.end(own); ++e) moved[static_cast<std::size_t>(e->column)] = 0.0;
      if (length == 0.0) {  // a row of zeros
        --rank;
        inverse_[p] = 0.0;
        continue;
      }
      if (!(pivot > dependent * length)) return false;
      smallest_pivot = std::min(smallest_pivot, pivot / length);
      inverse_[p] = 1.0 / pivot;
    }
    return true;
  }

  /// f ← q̈ and γ ← λ; false when a row of zeros asks for something, or the result is not finite.
  template <class Rows>
  bool solve(const SparseRows& J, Eigen::VectorXd& f, Rows& gamma) const {
    for (std::size_t i = 0; i < mobility_.size(); ++i) f[static_cast<Eigen::Index>(i)] *= mobility_[i];
    const std::size_t size = J.size();
    for (std::size_t p = 0; p < size; ++p) {
      double sum = gamma[at_row(p)];
      for (const auto* e = J.begin(order_[p]); e != J.end(order_[p]); ++e) sum -= e->value * f[e->column];
      const double* const row = at(p);
      for (std::size_t j = first_[p]; j < p; ++j) sum -= row[j] * gamma[at_row(j)];
      if (inverse_[p] == 0.0 && sum != 0.0) return false;
      gamma[at_row(p)] = sum;
    }
    for (std::size_t p = 0; p < size; ++p) gamma[at_row(p)] *= inverse_[p];
    double zero = 0.0;
    for (std::size_t p = size; p-- > 0;) {
      const double lambda = gamma[at_row(p)];
      const double* const row = at(p);
      for (std::size_t j = first_[p]; j < p; ++j) gamma[at_row(j)] -= row[j] * lambda;
      for (const auto* e = J.begin(order_[p]); e != J.end(order_[p]); ++e) f[e->column] += e->value * lambda * mobility_[static_cast<std::size_t>(e->column)];
      zero += lambda - lambda;
    }
    for (const double x : f) zero += x - x;
    return zero == 0.0;
  }

  Eigen::Index rank = 0;
  double smallest_pivot = 1.0;

 private:
  static constexpr std::ptrdiff_t narrow = 16;  // entries of a row

  Eigen::Index at_row(std::size_t p) const { return static_cast<Eigen::Index>(order_[p]); }
  double* at(std::size_t p) { return entries_.data() + offset_[p]; }
  const double* at(std::size_t p) const { return entries_.data() + offset_[p]; }

  // Where rows begin, in the present order.
  bool is_narrow(std::size_t coordinates, const SparseRows& J) {
    const std::size_t m = J.size();
    std::vector<int> met(coordinates, static_cast<int>(m));  // the first row that touches a coordinate
    first_.resize(m);
    offset_.resize(m);
    std::ptrdiff_t end = 0;
    for (std::size_t p = 0; p < m; ++p) {
      int first = static_cast<int>(p);
      for (const auto* e = J.begin(order_[p]); e != J.end(order_[p]); ++e) {
        int& earlier = met[static_cast<std::size_t>(e->column)];
        earlier = std::min(earlier, static_cast<int>(p));
        first = std::min(first, earlier);
      }
      first_[p] = static_cast<std::size_t>(first);
      offset_[p] = end - first;
      end += static_cast<std::ptrdiff_t>(p) - first + 1;
    }
    return end <= narrow * static_cast<std::ptrdiff_t>(m);
  }

  std::vector<std::size_t> order_;      // the row at each place
  std::vector<std::size_t> first_;      // place of the first entry of a row of L
  std::vector<std::ptrdiff_t> offset_;  // of a row's place 0 among the entries, whether it is there or not
  std::vector<double> entries_, inverse_, mobility_;
};

}  // namespace qdot::detail
