#pragma once
// SPDX-License-Identifier: MIT
//
// Where a polynomial becomes negative first.
//
// On [0, 1] a polynomial lies within the hull of its Bernstein coefficients, so where none of them is negative it is not either. Otherwise the interval is
// halved, left half first: a root is isolated where the coefficients change their sign once, and bisected. No pair of roots is missed, however close they
// are, as far as rounding lets them be told from one that touches.
//
// Reference: G. Farin, Curves and Surfaces for CAGD, 5th ed., Academic Press 2002, chapter 6.

#include <array>
#include <cstddef>

namespace qdot::detail {

/// A polynomial of degree 60 at most on [0, 1].
struct ShortPolynomial {
  static constexpr int highest = 60;
  std::array<double, highest + 1> c{};
  int degree = 0;

  double operator()(double x) const {
    double sum = c[static_cast<std::size_t>(degree)];
    for (int k = degree - 1; k >= 0; --k) sum = sum * x + c[static_cast<std::size_t>(k)];
    return sum;
  }
  double slope(double x) const {
    double sum = 0.0;
    for (int k = degree; k >= 1; --k) sum = sum * x + k * c[static_cast<std::size_t>(k)];
    return sum;
  }
};

// The first x in [from, to] behind which Bernstein coefficients b say that p is negative; 2 where it nowhere is.
inline double first_descent(const ShortPolynomial& p, const ShortPolynomial& b, double from, double to) {
  constexpr double nowhere = 2.0, narrowest = 0x1p-50;
  const auto n = static_cast<std::size_t>(p.degree);
  int changes = 0;
  bool negative = b.c[0] < 0.0;
  for (std::size_t i = 1; i <= n; ++i) {
    changes += (b.c[i] < 0.0) != (b.c[i - 1] < 0.0) ? 1 : 0;
    negative = negative || b.c[i] < 0.0;
  }
  if (!negative) return nowhere;
  if (b.c[0] < 0.0 && from > 0.0) return from;
  if (to - from <= narrowest) return b.c[n] < 0.0 ? to : nowhere;
  if (changes == 1 && b.c[n] < 0.0) {
    double holds = from, beyond = to;
    for (int k = 0; k < 200; ++k) {
      const double middle = 0.5 * (holds + beyond);
      if (middle == holds || middle == beyond) break;
      (p(middle) < 0.0 ? beyond : holds) = middle;
    }
    return beyond;
  }
  ShortPolynomial left = b, right = b;  // de Casteljau: left_i is the first of round i, right_{n−i} the last
  for (std::size_t round = 1; round <= n; ++round) {
    for (std::size_t i = 0; i + round <= n; ++i) right.c[i] = 0.5 * (right.c[i] + right.c[i + 1]);
    left.c[round] = right.c[0];
  }
  const double middle = 0.5 * (from + to), found = first_descent(p, left, from, middle);
  return found != nowhere ? found : first_descent(p, right, middle, to);
}

/// The first x in [0, 1] behind which p, which is not negative at 0, is negative; 2 where it nowhere is.
inline double first_descent(const ShortPolynomial& p) {
  const auto n = static_cast<std::size_t>(p.degree);
  double others = 0.0;
  for (std::size_t k = 1; k <= n; ++k) others += p.c[k] < 0.0 ? -p.c[k] : 0.0;
  if (p.c[0] >= others) return 2.0;
  ShortPolynomial b = p;
  double choose = 1.0;  // n over k
  for (std::size_t k = 1; k <= n; ++k) {
    choose *= static_cast<double>(n + 1 - k) / static_cast<double>(k);
    b.c[k] /= choose;
  }
  for (std::size_t k = 1; k <= n; ++k)
    for (std::size_t i = n; i >= k; --i) b.c[i] += b.c[i - 1];
  return first_descent(p, b, 0.0, 1.0);
}

}  // namespace qdot::detail
