// SPDX-License-Identifier: MIT
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "../catch2_bridge.hpp"
#include "qdot/ad/dual_math.hpp"

namespace {

using qdot::Dual;
using D = Dual<double, 1>;
using DD = Dual<D, 1>;

// An eighth-order central difference in 64-bit mantissas: independent of the rules under test.
long double difference(const std::function<long double(long double)>& f, long double x) {
  const long double h = 0.004L;
  const long double weights[] = {4.0L / 5, -1.0L / 5, 4.0L / 105, -1.0L / 280};
  long double slope = 0;
  for (int k = 1; k <= 4; ++k) {
    const long double kh = static_cast<long double>(k) * h;
    slope += weights[k - 1] * (f(x + kh) - f(x - kh));
  }
  return slope / h;
}

// Rounding of the difference (2⁻⁶⁴/h) and its truncation (h⁸ f⁽⁹⁾/630), with a margin for steep functions.
constexpr double slope_tolerance = 1e-11;

struct Function {
  std::string name;
  std::function<long double(long double)> plain;
  std::function<DD(DD)> nested;
  std::vector<double> points;
};

#define QDOT_TEST_FUNCTION(expression, ...)                                                       \
  Function {                                                                                      \
    #expression, [](long double x) -> long double { using namespace std; return expression; },    \
        [](const DD& x) -> DD { return expression; }, std::vector<double> __VA_ARGS__             \
  }

TEST_CASE("every elementary function equals its difference quotient to second order") {
  const std::vector<Function> functions = {
      QDOT_TEST_FUNCTION(sqrt(x), {0.3, 2.0, 50.0}),
      QDOT_TEST_FUNCTION(cbrt(x), {0.3, -2.0, 50.0}),
      QDOT_TEST_FUNCTION(pow(x, 3), {0.3, -2.0}),
      QDOT_TEST_FUNCTION(pow(x, -2), {0.8, -2.0}),
      QDOT_TEST_FUNCTION(pow(x, 2.5), {0.3, 2.0}),
      QDOT_TEST_FUNCTION(pow(2.5, x), {0.3, -2.0}),
      QDOT_TEST_FUNCTION(pow(x, x), {0.7, 2.0}),
      QDOT_TEST_FUNCTION(exp(x), {0.3, -2.0}),
      QDOT_TEST_FUNCTION(exp2(x), {0.3, -2.0}),
      QDOT_TEST_FUNCTION(expm1(x), {1e-8, -2.0}),
      QDOT_TEST_FUNCTION(log(x), {0.5, 20.0}),
      QDOT_TEST_FUNCTION(log2(x), {0.5, 20.0}),
      QDOT_TEST_FUNCTION(log10(x), {0.5, 20.0}),
      QDOT_TEST_FUNCTION(log1p(x), {1e-8, 3.0}),
      QDOT_TEST_FUNCTION(sin(x), {0.0, 0.3, -4.0}),
      QDOT_TEST_FUNCTION(cos(x), {0.0, 0.3, -4.0}),
      QDOT_TEST_FUNCTION(tan(x), {0.0, 0.3, 1.2}),
      QDOT_TEST_FUNCTION(asin(x), {0.0, 0.3, -0.8}),
      QDOT_TEST_FUNCTION(acos(x), {0.0, 0.3, -0.8}),
      QDOT_TEST_FUNCTION(atan(x), {0.0, 0.3, -4.0}),
      QDOT_TEST_FUNCTION(sinh(x), {0.0, 0.3, -2.0}),
      QDOT_TEST_FUNCTION(cosh(x), {0.0, 0.3, -2.0}),
      QDOT_TEST_FUNCTION(tanh(x), {0.0, 0.3, -2.0}),
      QDOT_TEST_FUNCTION(asinh(x), {0.0, 0.3, -4.0}),
      QDOT_TEST_FUNCTION(acosh(x), {1.5, 4.0}),
      QDOT_TEST_FUNCTION(atanh(x), {0.0, 0.3, -0.8}),
      QDOT_TEST_FUNCTION(erf(x), {0.0, 0.3, -1.0}),
      QDOT_TEST_FUNCTION(erfc(x), {0.0, 0.3, 2.0}),
      QDOT_TEST_FUNCTION(fabs(x), {0.3, -2.0}),
      QDOT_TEST_FUNCTION(atan2(x, 1.0 + x * x), {0.3, -2.0}),
      QDOT_TEST_FUNCTION(atan2(1.0, x), {0.3, -2.0}),
      QDOT_TEST_FUNCTION(hypot(x, 2.0), {0.0, -2.0}),
      QDOT_TEST_FUNCTION(hypot(x, x * x), {0.3, -2.0}),
      QDOT_TEST_FUNCTION(hypot(x, 1.0 - x, x * x), {0.3, -2.0}),
      QDOT_TEST_FUNCTION(fma(x, x, sin(x)), {0.3, -2.0}),
  };
  for (const Function& function : functions)
    for (const double at : function.points) {
      INFO(function.name << " at " << at);
      const DD x = DD::variable(D::variable(at, 0), 0);
      const DD y = function.nested(x);
      const long double at_l = at;
      const auto slope = [&](long double s) { return difference(function.plain, s); };
      const double scale = std::max(1.0, std::abs(static_cast<double>(slope(at_l))));
      CHECK_THAT(y.value.value, WithinRel(static_cast<double>(function.plain(at_l)), 1e-15) ||
                                    WithinAbs(static_cast<double>(function.plain(at_l)), 1e-16));
      CHECK_THAT(y.value.tangent[0], WithinAbs(static_cast<double>(slope(at_l)), slope_tolerance * scale));
      CHECK_THAT(y.tangent[0].value, WithinAbs(static_cast<double>(slope(at_l)), slope_tolerance * scale));
      const double curvature = static_cast<double>(difference(slope, at_l));
      // A difference of differences loses another factor 1/h.
      CHECK_THAT(y.tangent[0].tangent[0], WithinAbs(curvature, 1e-8 * std::max(1.0, std::abs(curvature))));
    }
}

TEST_CASE("the sine and cosine of one argument come together") {
  const DD x = DD::variable(D::variable(0.4, 0), 0);
  const auto both = sincos(x);
  CHECK(both.sin.value.value == std::sin(0.4));
  CHECK(both.sin.tangent[0].tangent[0] == -std::sin(0.4));
  CHECK(both.cos.tangent[0].value == -std::sin(0.4));
  CHECK(both.cos.tangent[0].tangent[0] == -std::cos(0.4));
}

TEST_CASE("powers with whole exponents are differentiable twice at zero") {
  const DD x = DD::variable(D::variable(0.0, 0), 0);
  const auto check = [](const DD& y, double f, double df, double d2f) {
    CHECK(y.value.value == f);
    CHECK(y.value.tangent[0] == df);
    CHECK(y.tangent[0].value == df);
    CHECK(y.tangent[0].tangent[0] == d2f);
  };
  check(pow(x, 0), 1, 0, 0);
  check(pow(x, 1), 0, 1, 0);
  check(pow(x, 2), 0, 0, 2);
  check(pow(x, 3), 0, 0, 0);
  check(pow(x, 4), 0, 0, 0);
  check(pow(x, 2.0), 0, 0, 2);
  check(pow(x, 2U), 0, 0, 2);
  check(pow(x, 1.0), 0, 1, 0);
  check(pow(x, 0.0), 1, 0, 0);
  check(pow(x, DD(2.0)), 0, 0, 2);
}

TEST_CASE("a power's second derivatives count an exponent whose value or slope is zero") {
  using T = Dual<double, 2>;
  using TT = Dual<T, 2>;
  const auto at = [](double x, int i) { return TT::variable(T::variable(x, i), i); };
  const auto second = [](const TT& f, int i, int j) { return f.tangent[static_cast<std::size_t>(i)].tangent[static_cast<std::size_t>(j)]; };
  const TT x = at(2.0, 0), y = at(0.0, 1);
  constexpr double rounded = 1e-15;  // of numbers of order one
  CHECK_THAT(second(pow(x, y), 0, 1), WithinAbs(0.5, rounded));                         // ∂²xʸ/∂x∂y = 1/x at y = 0
  CHECK_THAT(second(pow(x, y * y), 1, 1), WithinAbs(2 * std::log(2.0), rounded));       // ∂²x^(y²)/∂y² = 2 ln x at y = 0
  CHECK_THAT(second(pow(2.0, cos(y)), 1, 1), WithinAbs(-2 * std::log(2.0), 2 * rounded));
}

TEST_CASE("negative bases have whole powers") {
  const D x = D::variable(-2.0, 0);
  CHECK(pow(x, 3).value == -8.0);
  CHECK(pow(x, 3).tangent[0] == 12.0);
  CHECK(pow(x, 3.0).tangent[0] == 12.0);
  CHECK(pow(x, -1).value == -0.5);
  CHECK(pow(x, -1).tangent[0] == -0.25);
  CHECK(pow(x, D(3.0)).tangent[0] == 12.0);
}

TEST_CASE("a constant under a root has no derivative, not an undefined one") {
  const D zero(0.0);
  CHECK(sqrt(zero).tangent[0] == 0.0);
  CHECK(cbrt(zero).tangent[0] == 0.0);
  CHECK(pow(zero, 0.5).tangent[0] == 0.0);
  CHECK(std::isinf(sqrt(D::variable(0.0, 0)).tangent[0]));
}

TEST_CASE("magnitude, larger and smaller take the slope of the side they select") {
  const D x = D::variable(-2.0, 0);
  CHECK(abs(x).tangent[0] == -1.0);
  CHECK(max(x, 0.0).tangent[0] == 0.0);
  CHECK(min(x, 0).tangent[0] == 1.0);
  CHECK(max(1, x).value == 1.0);
  CHECK(fmax(x, std::numeric_limits<double>::quiet_NaN()).value == -2.0);
  CHECK(fmin(D(std::numeric_limits<double>::quiet_NaN()), x).value == -2.0);
  CHECK(copysign(x, 1.0).value == 2.0);
  CHECK(copysign(x, 1.0).tangent[0] == -1.0);
  CHECK(floor(D::variable(1.5, 0)).value == 1.0);
  CHECK(ceil(D::variable(1.5, 0)).tangent[0] == 0.0);
}

TEST_CASE("the angle and distance of the origin have no slope") {
  const D zero(0.0);
  CHECK(atan2(zero, zero).tangent[0] == 0.0);
  CHECK(hypot(D::variable(0.0, 0), zero).tangent[0] == 0.0);
}

TEST_CASE("non-finite derivatives are seen") {
  CHECK(isfinite(D::variable(1.0, 0)));
  CHECK_FALSE(isfinite(sqrt(D::variable(0.0, 0))));
  CHECK(isnan(D(std::numeric_limits<double>::quiet_NaN())));
  CHECK(isinf(D(std::numeric_limits<double>::infinity())));
}

TEST_CASE("near the edge of their domains inverse functions keep their digits") {
  // 1/√(1 − x²) at x = 1 − 2⁻⁴⁰: (1 − x)(1 + x) = 2⁻⁴⁰ (2 − 2⁻⁴⁰)
  const double delta = std::ldexp(1.0, -40);
  const double expected = 1.0 / std::sqrt(delta * (2.0 - delta));
  CHECK_THAT(asin(D::variable(1.0 - delta, 0)).tangent[0], WithinRel(expected, 1e-15));
  CHECK_THAT(acosh(D::variable(1.0 + delta, 0)).tangent[0], WithinRel(1.0 / std::sqrt(delta * (2.0 + delta)), 1e-15));
  // sech² 20 = 4/(e²⁰ + e⁻²⁰)², which 1 − tanh² 20 loses altogether
  CHECK_THAT(tanh(D::variable(20.0, 0)).tangent[0], WithinRel(1.0 / (std::cosh(20.0) * std::cosh(20.0)), 1e-15));
}

}  // namespace
