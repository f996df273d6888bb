#pragma once
// SPDX-License-Identifier: MIT
//
// M x = b for a symmetric positive M of a few rows, L D Lᵀ written out for each n.
//
// Of such a solution most of the time is waiting for divisions: each pivot is what is left of its diagonal entry after a division by the one
// before. Two at a time need not wait for each other. With a, b, c the entries of two rows and their determinant a c − b²
//
//     d₁ = a ,    d₂ = c − b²/a = (a c − b²)/a ,        1/d₁ = 1/a ,    1/d₂ = a/(a c − b²) ,
//
// both from what is known at once; the difference loses no more digits in the one form than in the other. For the last two rows there is nothing
// left to eliminate, and Cramer's rule does with one division,
//
//     x₁ = (c b₁ − b b₂)/(a c − b²) ,    x₂ = (a b₂ − b b₁)/(a c − b²) .
//
// A pivot is judged as a fraction of its diagonal entry, by comparing products. A determinant below 1e-290 has lost digits and counts as zero; an
// overflowed determinant fails the comparison too. After these, as after any pivot that is too small, the caller retries with one pivot at a time.

#include <cstddef>

#include "qdot/ad/unroll.hpp"

namespace qdot::detail {

// Index of M(i, j), i ≥ j, in the packed lower triangle.
constexpr int triangle_index(int i, int j) { return i * (i + 1) / 2 + j; }

// Largest n whose loops are unrolled.
inline constexpr int unrolled_limit = 8;

// Below this a product of two inertias has lost digits.
inline constexpr double smallest_determinant = 1e-290;

// The rows k and k + 1 of a matrix as far as it is factored, and the diagonal entries that they had.
template <int n, int k, class Number>
struct TwoPivots {
  Number a, b, c, determinant, whole;  // the last is a times the diagonal entry of the second row

  [[gnu::always_inline]] TwoPivots(const Number* M, const Number* diagonal)
      : a(M[triangle_index(k, k)]), b(M[triangle_index(k + 1, k)]), c(M[triangle_index(k + 1, k + 1)]), determinant(a * c - b * b),
        whole(a * diagonal[k + 1]) {}
  [[gnu::always_inline]] auto second_is_above(double threshold) const { return determinant > threshold * whole + smallest_determinant; }
};

// The inverses of the pivots of rows k and, in pairs from row 0 on, k + 1. False as below.
template <int n, int k, class Number>
[[gnu::always_inline]] inline auto inverted_pivots(const Number* M, const Number* diagonal, Number* inverse, double threshold) {
  using Truth = decltype(M[0] > M[0]);
  const Number pivot = M[triangle_index(k, k)];
  if constexpr (k % 2 == 0 && k + 1 < n) {
    inverse[k] = 1.0 / pivot;
    const Truth first = pivot > threshold * diagonal[k];
    const TwoPivots<n, k, Number> two(M, diagonal);
    inverse[k + 1] = pivot / two.determinant;
    return Truth(first & two.second_is_above(threshold));
  } else if constexpr (k % 2 == 0) {
    inverse[k] = 1.0 / pivot;
    return Truth(pivot > threshold * diagonal[k]);
  } else {
    return Truth(true);
  }
}

// b ← M⁻¹ b; false when a pivot is below `threshold` of its diagonal entry or NaN. M is overwritten.
// The entries of b are numbers or what can be multiplied by numbers.
template <int n, class Number, class Right>
[[gnu::always_inline]] inline auto solved_in_place(Number* M, Right* b, double threshold) {
  using Truth = decltype(M[0] > M[0]);
  constexpr int last = n > 1 ? n - 2 : 0;  // where elimination ends
  Number inverse[n];
  Truth good = true;
  Number diagonal[n];
  unroll<n>([&](auto k) __attribute__((always_inline)) { diagonal[k] = M[triangle_index(k, k)]; });
  unroll<last>([&](auto k) __attribute__((always_inline)) {
    good &= inverted_pivots<last, k>(M, diagonal, inverse, threshold);
    unroll<n - 1 - k>([&](auto below) __attribute__((always_inline)) {
      constexpr int i = k + 1 + below;
      const Number l = M[triangle_index(i, k)] * inverse[k];
      unroll<below + 1>([&](auto column) __attribute__((always_inline)) {
        constexpr int j = k + 1 + column;
        M[triangle_index(i, j)] -= l * M[triangle_index(j, k)];
      });
      b[i] -= l * b[k];
    });
  });
  const Number pivot = M[triangle_index(last, last)];
  good &= pivot > threshold * diagonal[last];
  if constexpr (n == 1) {
    b[0] = b[0] * Number(1.0 / pivot);
  } else {
    const TwoPivots<n, last, Number> two(M, diagonal);
    good &= two.second_is_above(threshold);
    const Number i = 1.0 / two.determinant;
    const Right first = b[last], second = b[n - 1];
    b[last] = (first * two.c - second * two.b) * i;
    b[n - 1] = (second * two.a - first * two.b) * i;
  }
  unroll<last>([&](auto done) __attribute__((always_inline)) {
    constexpr int k = last - 1 - done;
    Right s = b[k];
    unroll<n - 1 - k>([&](auto below) __attribute__((always_inline)) {
      constexpr int i = k + 1 + below;
      s -= M[triangle_index(i, k)] * b[i];
    });
    b[k] = s * inverse[k];
  });
  return good;
}

// A row of derivatives along q and q̇, and what else there is. Not one of Eigen's: what it makes of eight entries g++ does not always see through.
template <int columns>
struct SlopeRow {
  double entry[columns];

  [[gnu::always_inline]] double& operator[](std::ptrdiff_t j) { return entry[j]; }
  [[gnu::always_inline]] double operator[](std::ptrdiff_t j) const { return entry[j]; }
  [[gnu::always_inline]] friend SlopeRow operator*(const SlopeRow& a, double b) {
    SlopeRow product;
    unroll<columns>([&](auto j) __attribute__((always_inline)) { product.entry[j] = a.entry[j] * b; });
    return product;
  }
  [[gnu::always_inline]] friend SlopeRow operator*(double a, const SlopeRow& b) { return b * a; }
  [[gnu::always_inline]] SlopeRow& operator-=(const SlopeRow& b) {
    unroll<columns>([&](auto j) __attribute__((always_inline)) { entry[j] -= b.entry[j]; });
    return *this;
  }
  [[gnu::always_inline]] friend SlopeRow operator-(SlopeRow a, const SlopeRow& b) { return a -= b; }
};

}  // namespace qdot::detail
