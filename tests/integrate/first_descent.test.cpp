// SPDX-License-Identifier: MIT
//
// Polynomials with known roots.
#include <algorithm>
#include <cmath>
#include <vector>

#include "../catch2_bridge.hpp"
#include "qdot/integrate/steps/first_descent.hpp"

namespace {

using qdot::detail::first_descent, qdot::detail::ShortPolynomial;

constexpr double rounding = 4e-16;  // of a root between 0 and 1 that a polynomial of degree 20 leaves with a slope of the order of one

// scale · Π (1 − x/r), times 1 + x² as often as the degree asks.
ShortPolynomial with_roots(const std::vector<double>& roots, int degree, double scale = 1.0) {
  ShortPolynomial p;
  p.c[0] = scale;
  const auto times = [&p](double a, double b) {  // p ← p · (1 + a x + b x²)
    for (int k = p.degree + 2; k >= 0; --k) {
      const auto i = static_cast<std::size_t>(k);
      p.c[i] += (k > 0 ? a * p.c[i - 1] : 0.0) + (k > 1 ? b * p.c[i - 2] : 0.0);
    }
    p.degree += b != 0.0 ? 2 : 1;
  };
  for (const double root : roots) times(-1.0 / root, 0.0);
  while (p.degree + 2 <= degree) times(0.0, 1.0);
  return p;
}

TEST_CASE("the first root behind which a polynomial is negative is found, whatever comes behind it") {
  for (const int degree : {3, 8, 20, 58}) {
    CAPTURE(degree);
    CHECK_THAT(first_descent(with_roots({0.3}, degree)), WithinAbs(0.3, rounding));
    CHECK_THAT(first_descent(with_roots({0.3, 0.7, 0.9}, degree)), WithinAbs(0.3, 20 * rounding));
    CHECK(first_descent(with_roots({1.5}, degree)) > 1.0);
    CHECK(first_descent(with_roots({-0.5, -0.1}, degree)) > 1.0);
    CHECK_THAT(first_descent(with_roots({1e-9, 0.5}, degree)), WithinAbs(1e-9, 1e-9 * rounding));
  }
}

TEST_CASE("a pair of roots is found however close, a root that touches is not") {
  for (const double apart : {1e-2, 1e-4, 1e-6})
    CHECK_THAT(first_descent(with_roots({0.4 - apart, 0.4 + apart}, 12)), WithinAbs(0.4 - apart, 1e-15 / apart));  // the slope there is as small as that
  CHECK(first_descent(with_roots({0.5, 0.5}, 2)) > 1.0);  // (1 − 2x)², in whole numbers
}

TEST_CASE("a polynomial that rests on zero is not negative, and one that begins there goes where its next coefficient says") {
  ShortPolynomial p;
  p.degree = 20;
  CHECK(first_descent(p) > 1.0);
  p.c[1] = 1.0;
  CHECK(first_descent(p) > 1.0);
  p.c[3] = -4.0;
  CHECK_THAT(first_descent(p), WithinAbs(0.5, rounding));
}

}  // namespace
