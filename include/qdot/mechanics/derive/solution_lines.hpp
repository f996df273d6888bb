#pragma once
// SPDX-License-Identifier: MIT
//
// The solution of M q̈ = b as lines.
//
// Elimination is operations like those of M and r, M = L D Lᵀ as in mechanics/equations/small_solve.hpp and in the same order, so both have the same
// bits: two pivots at a time, and the last two rows by Cramer's rule. As lines they leave out what is zero in this M, and numbers need not go
// through memory between the two. Lines have no branches, so pivots are results that are looked at afterwards.

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "qdot/ad/formula/lines.hpp"

namespace qdot::detail {

/// Writes lines that eliminate the rows of M and solve for q̈.
class SolutionLines {
  using Line = formula::Line;
  using Operation = Line::Operation;

 public:
  /// @param count   how many numbers there are before
  /// @param mass    numbers of the lower triangle of M, row by row; −1 for zero
  /// @param right   numbers of r
  /// @param forces  the first of the numbers of Q, to be added to r; −1 for none
  [[gnu::cold]] SolutionLines(std::uint32_t count, const std::vector<int>& mass, const std::vector<int>& right, int forces)
      : count_(count), M_(mass), b_(right) {
    const int n = size(), last = n > 1 ? n - 2 : 0;
    for (int k = 0; k < n; ++k) {
      if (entry(k, k) == none) return;  // no inertia
      diagonal_.push_back(entry(k, k));
      if (forces != none) at(b_, k) = add(Operation::sum, at(b_, k), forces + k);
    }
    inverse_.resize(b_.size());
    for (int k = 0; k < last; ++k) {
      if (k % 2 == 0) invert(k, k + 1 < last);
      for (int i = k + 1; i < n; ++i) eliminate(i, k);
    }
    solve_last(last);
    for (int k = last - 1; k >= 0; --k) {
      for (int i = k + 1; i < n; ++i)
        if (entry(i, k) != none) at(b_, k) = less_product(at(b_, k), entry(i, k), at(b_, i));
      at(b_, k) = add(Operation::product, at(b_, k), at(inverse_, k));
    }
    accelerations = b_;
  }

  std::vector<Line> lines;                  ///< without an end
  std::vector<int> accelerations;           ///< numbers of q̈; none where an inertia is zero
  std::vector<std::pair<int, int>> pivots;  ///< numbers of which the first of each pair must be above a fraction of the second
  std::uint32_t count() const { return count_; }  ///< how many numbers there are with these lines

 private:
  static constexpr int none = -1;

  int size() const { return static_cast<int>(b_.size()); }
  static int& at(std::vector<int>& all, int k) { return all[static_cast<std::size_t>(k)]; }
  [[gnu::cold, gnu::noinline]] int& entry(int i, int j) { return at(M_, i * (i + 1) / 2 + j); }

  [[gnu::cold, gnu::noinline]] int add(Operation operation, int a, int b = 0, int d = 0, int e = 0) {
    Line line{operation, formula::Function::none, count_, static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b)};
    line.d = static_cast<std::uint32_t>(d);
    line.e = static_cast<std::uint32_t>(e);
    line.ca = -1.0;  // of −a + c, where −0 adds nothing
    line.c = -0.0;
    lines.push_back(line);
    return static_cast<int>(count_++);
  }
  int inverse_of(int pivot) { return add(Operation::inverse, pivot); }
  int less_product(int d, int a, int b) { return add(Operation::less_product, a, b, d); }
  int products_difference(int a, int b, int d, int e) { return add(Operation::products_difference, a, b, d, e); }

  // a c − b² of rows k and k + 1.
  [[gnu::cold, gnu::noinline]] int determinant(int k) {
    const int a = entry(k, k), b = entry(k + 1, k), d = products_difference(a, entry(k + 1, k + 1), b, b);
    pivots.emplace_back(d, add(Operation::product, a, at(diagonal_, k + 1)));
    return d;
  }

  // The inverses of the pivots of row k and, of two, k + 1.
  [[gnu::cold, gnu::noinline]] void invert(int k, bool two) {
    pivots.emplace_back(entry(k, k), at(diagonal_, k));
    at(inverse_, k) = inverse_of(entry(k, k));
    if (!two) return;
    if (entry(k + 1, k) != none) {
      at(inverse_, k + 1) = add(Operation::quotient, entry(k, k), determinant(k));
    } else {
      pivots.emplace_back(entry(k + 1, k + 1), at(diagonal_, k + 1));
      at(inverse_, k + 1) = inverse_of(entry(k + 1, k + 1));
    }
  }

  [[gnu::cold, gnu::noinline]] void eliminate(int i, int k) {
    if (entry(i, k) == none) return;
    const int l = add(Operation::product, entry(i, k), at(inverse_, k));
    for (int j = k + 1; j <= i; ++j) {
      if (entry(j, k) == none) continue;
      entry(i, j) = entry(i, j) != none ? less_product(entry(i, j), l, entry(j, k)) : add(Operation::scaled, add(Operation::product, l, entry(j, k)));
    }
    at(b_, i) = less_product(at(b_, i), l, at(b_, k));
  }

  [[gnu::cold, gnu::noinline]] void solve_last(int k) {
    pivots.emplace_back(entry(k, k), at(diagonal_, k));
    if (size() == 1) {
      at(b_, 0) = add(Operation::product, at(b_, 0), inverse_of(entry(0, 0)));
    } else if (entry(k + 1, k) == none) {
      pivots.emplace_back(entry(k + 1, k + 1), at(diagonal_, k + 1));
      for (const int i : {k, k + 1}) at(b_, i) = add(Operation::product, at(b_, i), inverse_of(entry(i, i)));
    } else {
      const int a = entry(k, k), b = entry(k + 1, k), c = entry(k + 1, k + 1), i = inverse_of(determinant(k)), first = at(b_, k), second = at(b_, k + 1);
      at(b_, k) = add(Operation::product, products_difference(first, c, second, b), i);
      at(b_, k + 1) = add(Operation::product, products_difference(second, a, first, b), i);
    }
  }

  std::uint32_t count_;
  std::vector<int> M_, b_, diagonal_, inverse_;
};

}  // namespace qdot::detail
