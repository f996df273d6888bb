// SPDX-License-Identifier: MIT
#include "qdot/ad/formula/interval.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "catch2_bridge.hpp"
#include "qdot/ad/dual_eigen.hpp"
#include "qdot/ad/vector.hpp"

using qdot::Interval;

namespace {

// What long double gives at points of an interval must lie in the bounds that f gives for the interval.
template <class F>
void check_contains(const char* name, const F& f, double from, double to) {
  INFO(name);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(from, to), part(0.0, 1.0);
  for (int k = 0; k < 400; ++k) {
    const double a = place(random), b = std::min(to, a + std::pow(10.0, -8.0 * part(random)) * (to - a));
    const Interval bounds = f(Interval::between(a, b));
    for (int j = 0; j <= 10; ++j) {
      const long double x = a + (static_cast<long double>(b) - a) * j / 10;
      const long double y = f(x);
      if (!(y >= bounds.lower() && y <= bounds.upper())) FAIL("at " << static_cast<double>(x) << ": " << static_cast<double>(y));
    }
  }
}

#define QDOT_CHECK_CONTAINS(name, from, to)                            \
  check_contains(                                                     \
      #name,                                                          \
      [](const auto& x) {                                             \
        using namespace std;                                          \
        return name(x);                                               \
      },                                                              \
      from, to)

constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

TEST_CASE("the bounds of a function over an interval contain its values inside") {
  QDOT_CHECK_CONTAINS(sqrt, 0.0, 9.0);
  QDOT_CHECK_CONTAINS(cbrt, -8.0, 9.0);
  QDOT_CHECK_CONTAINS(exp, -30.0, 30.0);
  QDOT_CHECK_CONTAINS(exp2, -30.0, 30.0);
  QDOT_CHECK_CONTAINS(expm1, -3.0, 3.0);
  QDOT_CHECK_CONTAINS(log, 1e-9, 30.0);
  QDOT_CHECK_CONTAINS(log2, 1e-9, 30.0);
  QDOT_CHECK_CONTAINS(log10, 1e-9, 30.0);
  QDOT_CHECK_CONTAINS(log1p, -0.999, 3.0);
  QDOT_CHECK_CONTAINS(erf, -4.0, 4.0);
  QDOT_CHECK_CONTAINS(erfc, -4.0, 4.0);
  QDOT_CHECK_CONTAINS(sin, -20.0, 20.0);
  QDOT_CHECK_CONTAINS(cos, -20.0, 20.0);
  QDOT_CHECK_CONTAINS(tan, -20.0, 20.0);
  QDOT_CHECK_CONTAINS(asin, -1.0, 1.0);
  QDOT_CHECK_CONTAINS(acos, -1.0, 1.0);
  QDOT_CHECK_CONTAINS(atan, -20.0, 20.0);
  QDOT_CHECK_CONTAINS(sinh, -20.0, 20.0);
  QDOT_CHECK_CONTAINS(cosh, -20.0, 20.0);
  QDOT_CHECK_CONTAINS(tanh, -3.0, 3.0);
  QDOT_CHECK_CONTAINS(asinh, -20.0, 20.0);
  QDOT_CHECK_CONTAINS(acosh, 1.0, 20.0);
  QDOT_CHECK_CONTAINS(atanh, -1.0, 1.0);
  QDOT_CHECK_CONTAINS(abs, -1.0, 1.0);
  QDOT_CHECK_CONTAINS(floor, -5.0, 5.0);
  QDOT_CHECK_CONTAINS(ceil, -5.0, 5.0);
  for (const double e : {2.0, 3.0, -1.0, -2.0, 0.0}) check_contains("pow", [e](const auto& x) { using std::pow; return pow(x, e); }, -2.0, 3.0);
  for (const double e : {0.5, 1.5, -2.5}) check_contains("pow", [e](const auto& x) { using std::pow; return pow(x, e); }, 0.0, 3.0);
  check_contains("a formula", [](const auto& x) { return (x * x - 3.0) / (x + 4.0) - x * (1.0 - 2.0 * x); }, -3.0, 3.0);
  check_contains("of two", [](const auto& x) {
    using std::atan2, std::copysign, std::hypot, std::max, std::min, std::sin;
    using X = std::remove_cvref_t<decltype(x)>;
    return X(atan2(X(x - 1.0), X(2.0 - x)) + hypot(x, X(x * x)) + max(x, X(1.0)) * min(x, X(-1.0)) + copysign(x, X(x - 0.5)) + sin(x));
  }, -3.0, 3.0);
}

TEST_CASE("bounds are as narrow as a formula with one argument allows") {
  using std::numbers::pi;
  const auto check = [](const Interval& found, double lower, double upper) {
    CHECK_THAT(found.lower(), WithinRel(lower, 1e-15) || WithinAbs(lower, 1e-300));
    CHECK_THAT(found.upper(), WithinRel(upper, 1e-15) || WithinAbs(upper, 1e-300));
  };
  check(sin(Interval::between(0.5, 0.7)), std::sin(0.5), std::sin(0.7));
  check(sin(Interval::between(0.5, 2.0)), std::sin(0.5), 1.0);
  check(cos(Interval::between(3.0, 4.0)), -1.0, std::cos(4.0));
  check(sin(Interval::between(0.5, 7.0)), -1.0, 1.0);
  check(pow(Interval::between(-1.0, 3.0), 2), 0.0, 9.0);
  const Interval x = Interval::between(-1.0, 3.0);
  check(x * x, 0.0, 9.0);
  check(sqrt(Interval::between(-1.0, 4.0)), 0.0, 2.0);
  check(atan2(Interval::between(1.0, 2.0), Interval::between(-1.0, 1.0)), 0.25 * pi, 0.75 * pi);
  CHECK(log(Interval::between(-1.0, 1.0)).lower() == -infinity);
}

TEST_CASE("where a formula has no bounds they are infinite, and never NaN") {
  const Interval zero = Interval::between(-1.0, 1.0), all = Interval::everything();
  for (const Interval& x : {1.0 / zero, tan(Interval::between(1.0, 2.0)), log(Interval(-1.0)), 0.0 * all, all - all, pow(zero, -1), sqrt(Interval(-2.0)),
                            Interval::between(std::nan(""), 1.0), exp(Interval(1e4)) - exp(Interval(1e4))}) {
    CHECK(x.lower() == -infinity);
    CHECK(x.upper() == infinity);
  }
  CHECK(exp(Interval(1e4)).lower() == std::numeric_limits<double>::max());
  CHECK((Interval(1e-200) * Interval(1e-200)).upper() > 0.0);
}

TEST_CASE("a comparison is answered only where all numbers inside agree") {
  const Interval x = Interval::between(0.0, 1.0);
  CHECK(x < Interval(2.0));
  CHECK(x >= 0.0);
  CHECK_FALSE(x > 1.0);
  CHECK(x != 3.0);
  CHECK_THROWS_AS(x < 0.5, qdot::Undecided);
  CHECK_THROWS_AS(x == 0.5, qdot::Undecided);
}

TEST_CASE("duals and vectors of intervals bound derivatives and sums") {
  // d/dt sin(3t + x²) = cos(…) (3 + 2 x ẋ), with x = t on t ∈ [0.1, 0.2].
  using D = qdot::Dual<Interval, 1>;
  const D t = D::variable(Interval::between(0.1, 0.2), 0);
  const D f = sin(3.0 * t + t * t);
  for (const double at : {0.1, 0.13, 0.2}) {
    CHECK(f.value.contains(std::sin(3 * at + at * at)));
    CHECK(f.tangent[0].contains(std::cos(3 * at + at * at) * (3 + 2 * at)));
  }
  CHECK(f.tangent[0].width() < 0.7);  // cos 0.31 · 3.4 − cos 0.64 · 3.2 = 0.67
  const qdot::Vector<D, 2> v(t, t * 2.0);
  CHECK(v.dot(v).value.contains(5 * 0.15 * 0.15));
  CHECK((0.5 * v.squaredNorm()).tangent[0].contains(5 * 0.15));
}
