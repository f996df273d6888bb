#pragma once
// SPDX-License-Identifier: MIT
//
// M q̈ − Jᵀλ = f, J q̈ = γ for a diagonal M, as that of point masses and of bodies in a plane in Cartesian coordinates.
//
//     (J M⁻¹ Jᵀ) λ = γ − J M⁻¹ f ,     q̈ = M⁻¹ (f + Jᵀλ)
//
// An entry of J M⁻¹ Jᵀ is other than zero where two rows meet in a coordinate. With a matrix of only so many rows as there are constraints, a chain
// has three entries in each. Rows of L are kept from their first entry on (an envelope). Constraints are taken as they are numbered or, where that
// makes it wide, in the order of the last coordinate that each touches. A bare constrained_acceleration() of chains and ladders of rods
// takes 13 to 18 % less than with the factors of M and J together (effects/rows/sparse_solve.hpp).
//
// A pivot, as a fraction of the diagonal entry, is the square of the sine between a row and those before it, in the metric of M.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "qdot/effects/rows/sparse_rows.hpp"
#include "qdot/mechanics/equations/banded_equations.hpp"

namespace qdot::detail {

class SchurFactors {
 public:
  /// False where neither order keeps rows that meet near each other.
  bool arrange(std::size_t coordinates, const SparseRows& J) {
    places_.resize(J.size());
    for (std::size_t p = 0; p < J.size(); ++p) places_[p].row = p;
    if (is_narrow(coordinates, J)) return true;
    std::vector<int> last(J.size(), 0);
    for (std::size_t row = 0; row < J.size(); ++row)
      for (const auto* e = J.begin(row); e != J.end(row); ++e) last[row] = std::max(last[row], e->column);
    std::stable_sort(places_.begin(), places_.end(), [&](const Place& a, const Place& b) { return last[a.row] < last[b.row]; });
    return is_narrow(coordinates, J);
  }

  /// After arrange(). False when an inertia is not positive, or a pivot is below `dependent` of its diagonal entry and above `rounding`.
  bool compute(const BandedMatrix& M, const SparseRows& J, double dependent, double rounding) {
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
    entries_.resize(size_);
    for (std::size_t p = 0; p < places_.size(); ++p) {
      Place& own = places_[p];
      double* const row = at(own);
      const auto *const begin = J.begin(own.row), *const end = J.end(own.row);
      double length = 0.0;
      for (const auto* e = begin; e != end; ++e) {
        const double x = e->value * mobility_[static_cast<std::size_t>(e->column)];
        moved[static_cast<std::size_t>(e->column)] = x;
        length += x * e->value;
      }
      for (std::size_t j = own.first; j < p; ++j) {
        const Place& other = places_[j];
        double sum = 0.0;
        for (const auto *e = J.begin(other.row), *last = J.end(other.row); e != last; ++e) sum += moved[static_cast<std::size_t>(e->column)] * e->value;
        const double* const beside = at(other);
        for (std::size_t k = std::max(own.first, other.first); k < j; ++k) sum -= row[k] * beside[k];
        row[j] = sum;
      }
      for (const auto* e = begin; e != end; ++e) moved[static_cast<std::size_t>(e->column)] = 0.0;
      double pivot = length;
      for (std::size_t j = own.first; j < p; ++j) {
        const double share = row[j] * places_[j].inverse;
        pivot -= row[j] * share;
        row[j] = share;
      }
      if (length == 0.0 || std::abs(pivot) <= rounding * length) {  // nothing, or nothing of its own
        --rank;
        own.inverse = 0.0;
        continue;
      }
      const bool is_dependent = !(pivot > dependent * length);
      if (pivot < smallest_pivot * length) {
        smallest_pivot = pivot / length;
        weakest = static_cast<Eigen::Index>(own.row);
      }
      if (is_dependent) return false;
      own.inverse = 1.0 / pivot;
    }
    return true;
  }

  /// f ← q̈ and γ ← λ; false when a row without a pivot asks for something and that matters, or the result is not finite.
  template <class Rows>
  bool solve(const SparseRows& J, Eigen::VectorXd& f, Rows& gamma, bool matters) const {
    double *const a = f.data(), *const lambda = gamma.data();
    for (std::size_t i = 0; i < mobility_.size(); ++i) a[i] *= mobility_[i];
    for (std::size_t p = 0; p < places_.size(); ++p) {
      const Place& own = places_[p];
      double sum = lambda[own.row];
      for (const auto *e = J.begin(own.row), *end = J.end(own.row); e != end; ++e) sum -= e->value * a[e->column];
      const double* const row = at(own);
      for (std::size_t j = own.first; j < p; ++j) sum -= row[j] * lambda[places_[j].row];
      if (own.inverse == 0.0 && sum != 0.0 && matters) return false;
      lambda[own.row] = sum;
    }
    for (const Place& own : places_) lambda[own.row] *= own.inverse;
    double zero = 0.0;
    for (std::size_t p = places_.size(); p-- > 0;) {
      const Place& own = places_[p];
      const double x = lambda[own.row];
      const double* const row = at(own);
      for (std::size_t j = own.first; j < p; ++j) lambda[places_[j].row] -= row[j] * x;
      for (const auto *e = J.begin(own.row), *end = J.end(own.row); e != end; ++e)
        a[e->column] += e->value * x * mobility_[static_cast<std::size_t>(e->column)];
      zero += x - x;
    }
    for (std::size_t i = 0; i < mobility_.size(); ++i) zero += a[i] - a[i];
    return zero == 0.0;
  }

  Eigen::Index rank = 0;
  double smallest_pivot = 1.0;
  Eigen::Index weakest = 0;  // the row of that pivot

 private:
  static constexpr std::size_t narrow = 16;  // entries of a row

  struct Place {
    std::size_t row, first;  // of J, and the place of the first entry of that of L
    std::ptrdiff_t offset;   // of its entry at place 0 among all, whether it is there or not
    double inverse;          // of the pivot
  };
  double* at(const Place& p) { return entries_.data() + p.offset; }
  const double* at(const Place& p) const { return entries_.data() + p.offset; }

  // Where rows begin, in the present order.
  bool is_narrow(std::size_t coordinates, const SparseRows& J) {
    std::vector<std::size_t> met(coordinates, places_.size());  // the first place that touches a coordinate
    size_ = 0;
    for (std::size_t p = 0; p < places_.size(); ++p) {
      Place& own = places_[p];
      own.first = p;
      for (const auto *e = J.begin(own.row), *end = J.end(own.row); e != end; ++e) {
        std::size_t& earlier = met[static_cast<std::size_t>(e->column)];
        if (earlier > p) earlier = p;
        if (earlier < own.first) own.first = earlier;
      }
      own.offset = static_cast<std::ptrdiff_t>(size_) - static_cast<std::ptrdiff_t>(own.first);
      size_ += p - own.first + 1;
    }
    return size_ <= narrow * places_.size();
  }

  std::vector<Place> places_;
  std::size_t size_ = 0;  // of all entries
  std::vector<double> entries_, mobility_;
};

}  // namespace qdot::detail
