#pragma once
// SPDX-License-Identifier: MIT
//
// L D Lᵀ of a symmetric matrix that has up to four entries beside the diagonal, as bodies in a row have that meet their neighbours.
//
// Row i of L follows from the rows before it, with p_j = l_ij d_j,
//
//     p_j = A_ij − Σ p_k l_jk ,    l_ij = p_j/d_j ,    d_i = A_ii − Σ p_j l_ij          (k < j < i) .
//
// With a width that the compiler knows these are some thirty operations without loops, and what is left of the time is waiting for divisions. So rows
// are taken two at a time. With s = A_ii without the last product, d_i = s − p²/d_{i−1} has the inverse d_{i−1}/(s d_{i−1} − p²). It waits for no
// other division than the row before does (as in small_solve.hpp).
//
// Places outside of the matrix are zeros before its first row and behind its last one.

#include <cstddef>
#include <type_traits>
#include <vector>

#include "qdot/ad/unroll.hpp"
#include "qdot/mechanics/equations/small_solve.hpp"

namespace qdot::detail {

template <class Number = double>
class NarrowBand {
 public:
  static constexpr std::size_t widest = 4;

  NarrowBand(std::size_t size, std::size_t width)
      : size_(size), width_(width < 1 ? 1 : width), matrix_(size * (width_ + 1), 0.0), L_((size + 2 * width_) * width_, 0.0), inverse_(size + width_, 0.0) {}

  std::size_t size() const { return size_; }

  /// Where entry (i, j) is among those of the matrix, i − width ≤ j ≤ i.
  std::size_t place(std::size_t i, std::size_t j) const { return i * (width_ + 1) + (i - j); }
  Number& operator[](std::size_t place) { return matrix_[place]; }

  /// Factors the matrix. `is_zero(i, pivot, whole)` decides whether a pivot that is not above `threshold` of its diagonal entry is a zero in D. The result
  /// is false where it is not, or a number is not finite.
  template <class IsZero>
  bool compute(Number threshold, const IsZero& is_zero) {
    return with_width([&](auto width) { return factored<width>(threshold, is_zero); });
  }

  /// x ← L⁻¹ x, x ← D⁻¹ x where D has no zero and 0 where it has, and x ← L⁻ᵀ x.
  void solve_lower(Number* x) const {
    with_width([&](auto width) { lower<width>(x); });
  }
  void divide(Number* x) const {
    for (std::size_t i = 0; i < size_; ++i) x[i] *= inverse_[i + width_];
  }
  void solve_upper(Number* x) const {
    with_width([&](auto width) { upper<width>(x); });
  }

 private:
  template <class F>
  auto with_width(const F& f) const {
    switch (width_) {
      case 1: return f(std::integral_constant<std::size_t, 1>());
      case 2: return f(std::integral_constant<std::size_t, 2>());
      case 3: return f(std::integral_constant<std::size_t, 3>());
      default: return f(std::integral_constant<std::size_t, 4>());
    }
  }

  // One row: p and l but for the last of l, and what is left of the diagonal entry without it. p[d − 1] belongs to the entry d to the left.
  template <std::size_t w>
  struct Row {
    Number p[w], left;

    [[gnu::always_inline]] Row(const Number* A, Number* l, const Number* inverse) : left(A[0]) {
      constexpr int width = static_cast<int>(w);
      unroll<width>([&](auto k) __attribute__((always_inline)) {
        constexpr int d = width - k;
        Number sum = A[d];
        unroll<width - d>([&](auto distant) __attribute__((always_inline)) {  // the row d above: its entry e to the left is in our column d + e
          constexpr int e = width - d - distant;
          sum -= p[d + e - 1] * l[-d * width + e - 1];
        });
        p[d - 1] = sum;
        if constexpr (d > 1) {
          l[d - 1] = sum * inverse[-d];
          left -= sum * l[d - 1];
        }
      });
    }
  };

  template <std::size_t w, class IsZero>
  bool factored(Number threshold, const IsZero& is_zero) {
    const Number* A = matrix_.data();
    Number *l = L_.data() + w * w, *inverse = inverse_.data() + w;
    Number zero = 0.0;
    const auto finish = [&](std::size_t i, const Row<w>& row, Number whole, Number* own, Number* inverted, Number& pivot) __attribute__((always_inline)) {
      own[0] = row.p[0] * inverted[-1];
      pivot = row.left - row.p[0] * own[0];
      const bool is_pivot = pivot > threshold * whole;
      if (!is_pivot && !is_zero(i, pivot, whole)) return false;
      *inverted = is_pivot ? 1.0 / pivot : 0.0;  // a zero takes no part
      zero += *inverted - *inverted;
      return true;
    };
    for (std::size_t i = 0; i < size_; i += 2, A += 2 * (w + 1), l += 2 * w, inverse += 2) {
      Number pivot, other;
      if (!finish(i, Row<w>(A, l, inverse), A[0], l, inverse, pivot)) return false;
      if (i + 1 == size_) break;
      const Number* const below = A + w + 1;
      const Row<w> row(below, l + w, inverse + 1);
      const Number determinant = row.left * pivot - row.p[0] * row.p[0];
      if (*inverse != 0.0 && determinant > threshold * (below[0] * pivot) + smallest_determinant) {
        l[w] = row.p[0] * inverse[0];
        inverse[1] = pivot / determinant;
        zero += inverse[1] - inverse[1];
      } else if (!finish(i + 1, row, below[0], l + w, inverse + 1, other)) {
        return false;
      }
    }
    return zero == 0.0;
  }

  template <std::size_t w>
  void lower(Number* x) const {
    Number before[w] = {};  // the nearest first
    const Number* l = L_.data() + w * w;
    for (std::size_t i = 0; i < size_; ++i, l += w) {
      Number sum = x[i];
      for (std::size_t d = w; d > 0; --d) sum -= l[d - 1] * before[d - 1];
      for (std::size_t d = w - 1; d > 0; --d) before[d] = before[d - 1];
      x[i] = before[0] = sum;
    }
  }
  template <std::size_t w>
  void upper(Number* x) const {
    Number behind[w] = {};
    for (std::size_t i = size_; i-- > 0;) {
      const Number* const l = L_.data() + (i + w) * w;
      Number sum = x[i];
      for (std::size_t d = w; d > 0; --d) sum -= l[d * w + d - 1] * behind[d - 1];
      for (std::size_t d = w - 1; d > 0; --d) behind[d] = behind[d - 1];
      x[i] = behind[0] = sum;
    }
  }

  std::size_t size_, width_;
  std::vector<Number> matrix_, L_, inverse_;  // by rows, those of L without its diagonal of ones
};

}  // namespace qdot::detail
