#pragma once
// SPDX-License-Identifier: MIT
//
// Each function of dual numbers against quadruple precision: value, first and second derivatives at (x, y), the derivatives
// from closed forms written here. Errors are counted in units in the last place (ulps) of the exact number,
//
//     |computed − exact| / ulp(exact) ,
//
// or of the size that the terms of a sum have before they cancel, where a derivative has a zero in the middle of its domain
// (asin″ at 0). A result beyond the range of double must come out as infinity, or as the largest numbers.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "quad.hpp"
#include "qdot/ad/dual_math.hpp"

namespace fuzz {

using D = qdot::Dual<double, 2>;
using DD = qdot::Dual<D, 2>;

/// f, its derivatives, and the sizes of the terms that they are sums of, where those are larger.
struct Exact {
  quad f, fx, fy, fxx, fxy, fyy;
  quad size_first = 0, size_second = 0;
};

struct Rule {
  std::string_view name;
  DD (*dual)(const DD& x, const DD& y);
  Exact (*exact)(quad x, quad y);
  bool (*inside)(double x, double y);
  /// Bound in ulps for {value, first, second derivatives}.
  std::array<double, 3> (*bound)(double x, double y);
};

inline Exact of_x(quad f, quad f1, quad f2, quad size_second = 0) { return {f, f1, 0, f2, 0, 0, 0, size_second}; }

/// log₂ of |x| in steps of one.
inline int exponent_of(quad x) {
  int e = 0;
  for (x = magnitude(x); x >= quad(0x1p1000); x *= quad(0x1p-1000)) e += 1000;
  for (; x > 0 && x < quad(0x1p-1000); x *= quad(0x1p1000)) e -= 1000;
  return x > 0 ? e + std::ilogb(static_cast<double>(x)) : -1100;
}

constexpr quad largest = std::numeric_limits<double>::max();

inline double ulps_between(double computed, quad exact, quad size) {
  if (std::isnan(computed)) return std::numeric_limits<double>::infinity();
  const int exponent = std::max(exponent_of(std::max(magnitude(exact), magnitude(size))) - 52, -1074);
  const quad difference = magnitude(quad(computed) - exact);
  if (exponent_of(difference) - exponent > 900) return std::numeric_limits<double>::infinity();
  return static_cast<double>(difference / quad(std::ldexp(1.0, exponent)));
}

/// Errors of {value, first, second derivatives} in ulps, the largest of each kind. Where one is beyond the range of double, those
/// of its kind and the higher ones need only show that by not being finite.
inline std::array<double, 3> errors(const Rule& rule, double x, double y) {
  const DD f = rule.dual(DD::variable(D::variable(x, 0), 0), DD::variable(D::variable(y, 1), 1));
  const Exact e = rule.exact(x, y);
  bool beyond = false, shown = false;
  const auto worst = [&](std::initializer_list<std::pair<double, quad>> kind, quad size) {
    double error = 0.0;
    for (const auto& [computed, exact] : kind) {
      beyond = beyond || magnitude(exact) > largest;
      shown = shown || !std::isfinite(computed);
    }
    if (beyond) return shown ? 0.0 : std::numeric_limits<double>::infinity();
    for (const auto& [computed, exact] : kind) error = std::max(error, ulps_between(computed, exact, size));
    return error;
  };
  const double value = worst({{f.value.value, e.f}}, 0);
  const double first = worst({{f.value.tangent[0], e.fx}, {f.tangent[0].value, e.fx}, {f.value.tangent[1], e.fy}, {f.tangent[1].value, e.fy}},
                             e.size_first);
  const double second = worst({{f.tangent[0].tangent[0], e.fxx}, {f.tangent[0].tangent[1], e.fxy}, {f.tangent[1].tangent[0], e.fxy},
                               {f.tangent[1].tangent[1], e.fyy}},
                              e.size_second);
  return {value, first, second};
}

/// What is wrong at (x, y), with the numbers; empty where all is within its bound.
inline std::string disagreement(const Rule& rule, double x, double y) {
  if (!std::isfinite(x) || !std::isfinite(y) || !rule.inside(x, y)) return {};
  const std::array<double, 3> error = errors(rule, x, y), bound = rule.bound(x, y);
  std::string text;
  for (std::size_t i = 0; i < 3; ++i) {
    if (error[i] <= bound[i]) continue;
    char line[200];
    std::snprintf(line, sizeof line, "%s at (%.17g, %.17g) [%a, %a]: derivative of order %d is off by %.3g ulps, more than %.3g\n",
                  std::string(rule.name).c_str(), x, y, x, y, static_cast<int>(i), error[i], bound[i]);
    text += line;
  }
  return text;
}

// Below 1e-290 and above 1e290 a product of two factors in a derivative may leave the range of double before its quotient returns.
inline bool usual(double x) { return std::abs(x) < 1e290 && std::abs(x) > 1e-290; }
inline bool moderate(double x) { return std::abs(x) < 1e90 && std::abs(x) > 1e-90; }

#define QDOT_FUZZ_RULE(expression, closed_form, domain, ...)                                                    \
  Rule {                                                                                                        \
    #expression, []([[maybe_unused]] const DD& x, [[maybe_unused]] const DD& y) -> DD { return expression; },   \
        []([[maybe_unused]] quad x, [[maybe_unused]] quad y) -> Exact { return closed_form; },                  \
        []([[maybe_unused]] double x, [[maybe_unused]] double y) -> bool { return domain; },                    \
        []([[maybe_unused]] double x, [[maybe_unused]] double y) -> std::array<double, 3> { return __VA_ARGS__; } \
  }

inline int whole(double y) { return static_cast<int>(std::fmod(y, 13.0)); }
inline quad whole(quad y) { return whole(static_cast<double>(y)); }
inline double log_size(double x) { return std::abs(std::log(std::abs(x))); }

/// All functions. A bound is that of the C library (1 ulp), plus half an ulp for each operation in the rule, rounded up.
inline const std::vector<Rule>& rules() {
  static const quad pi = acosq(-1), two_by_root_pi = quad(2) / sqrtq(pi), ln2 = logq(2), ln10 = logq(10);
  static const std::vector<Rule> all = {
      QDOT_FUZZ_RULE(sqrt(x), of_x(sqrtq(x), 1 / (2 * sqrtq(x)), -1 / (4 * x * sqrtq(x))), x > 0 && usual(x), {1, 2, 5}),
      QDOT_FUZZ_RULE(cbrt(x), of_x(cbrtq(x), cbrtq(x) / (3 * x), -2 * cbrtq(x) / (9 * x * x)), x != 0 && usual(x), {4, 10, 25}),
      QDOT_FUZZ_RULE(exp(x), of_x(expq(x), expq(x), expq(x)), std::abs(x) < 1e6, {1, 1, 1}),
      QDOT_FUZZ_RULE(exp2(x), of_x(powq(2, x), ln2 * powq(2, x), ln2 * ln2 * powq(2, x)), std::abs(x) < 1e4, {1, 3, 4}),
      QDOT_FUZZ_RULE(expm1(x), of_x(expm1q(x), expq(x), expq(x)), std::abs(x) < 1e6, {1, 3, 3}),
      QDOT_FUZZ_RULE(log(x), of_x(logq(x), 1 / x, -1 / (x * x)), x > 0 && usual(x), {1, 1, 2}),
      QDOT_FUZZ_RULE(log2(x), of_x(logq(x) / ln2, 1 / (x * ln2), -1 / (x * x * ln2)), x > 0 && usual(x), {1, 3, 5}),
      QDOT_FUZZ_RULE(log10(x), of_x(logq(x) / ln10, 1 / (x * ln10), -1 / (x * x * ln10)), x > 0 && usual(x), {2, 4, 6}),
      QDOT_FUZZ_RULE(log1p(x), of_x(log1pq(x), 1 / (1 + x), -1 / ((1 + x) * (1 + x))), x > -1 && x < 1e290, {1, 2, 3}),
      QDOT_FUZZ_RULE(sin(x), of_x(sinq(x), cosq(x), -sinq(x)), std::abs(x) < 1e15, {1, 1, 1}),
      QDOT_FUZZ_RULE(cos(x), of_x(cosq(x), -sinq(x), -cosq(x)), std::abs(x) < 1e15, {1, 1, 1}),
      QDOT_FUZZ_RULE(tan(x), of_x(tanq(x), 1 + tanq(x) * tanq(x), 2 * tanq(x) * (1 + tanq(x) * tanq(x))), std::abs(x) < 1e15, {1, 4, 6}),
      QDOT_FUZZ_RULE(asin(x), of_x(asinq(x), 1 / sqrtq((1 - x) * (1 + x)), x / (sqrtq((1 - x) * (1 + x)) * (1 - x) * (1 + x)),
                                   1 / sqrtq((1 - x) * (1 + x))), std::abs(x) < 1, {1, 3, 6}),
      QDOT_FUZZ_RULE(acos(x), of_x(acosq(x), -1 / sqrtq((1 - x) * (1 + x)), -x / (sqrtq((1 - x) * (1 + x)) * (1 - x) * (1 + x)),
                                   1 / sqrtq((1 - x) * (1 + x))), std::abs(x) < 1, {1, 3, 6}),
      QDOT_FUZZ_RULE(atan(x), of_x(atanq(x), 1 / (1 + x * x), -2 * x / ((1 + x * x) * (1 + x * x))), std::abs(x) < 1e150, {1, 3, 5}),
      QDOT_FUZZ_RULE(sinh(x), of_x(sinhq(x), coshq(x), sinhq(x)), std::abs(x) < 1e4, {2, 2, 2}),
      QDOT_FUZZ_RULE(cosh(x), of_x(coshq(x), sinhq(x), coshq(x)), std::abs(x) < 1e4, {2, 2, 2}),
      QDOT_FUZZ_RULE(tanh(x), of_x(tanhq(x), 1 / (coshq(x) * coshq(x)), -2 * tanhq(x) / (coshq(x) * coshq(x))), std::abs(x) < 4e3, {3, 5, 6}),
      QDOT_FUZZ_RULE(asinh(x), of_x(asinhq(x), 1 / hypotq(1, x), -x / (hypotq(1, x) * (1 + x * x))), std::abs(x) < 1e150, {2, 2, 5}),
      QDOT_FUZZ_RULE(acosh(x), of_x(acoshq(x), 1 / sqrtq((x - 1) * (x + 1)), -x / (sqrtq((x - 1) * (x + 1)) * (x - 1) * (x + 1))),
                     x > 1 && x < 1e150, {3, 4, 8}),
      QDOT_FUZZ_RULE(atanh(x), of_x(atanhq(x), 1 / ((1 - x) * (1 + x)), 2 * x / ((1 - x) * (1 + x) * (1 - x) * (1 + x)), 1 / ((1 - x) * (1 + x))),
                     std::abs(x) < 1, {2, 3, 6}),
      // e^(−x²) has the rounding of x² in its exponent: x² ulps, whatever the exponential does.
      QDOT_FUZZ_RULE(erf(x), of_x(erfq(x), two_by_root_pi * expq(-x * x), -2 * x * two_by_root_pi * expq(-x * x)), std::abs(x) < 40,
                     {1, 8 + x * x, 8 + x * x}),
      QDOT_FUZZ_RULE(erfc(x), of_x(erfcq(x), -two_by_root_pi * expq(-x * x), 2 * x * two_by_root_pi * expq(-x * x)), std::abs(x) < 40,
                     {3, 8 + x * x, 8 + x * x}),
      // Repeated squaring doubles the error each time; so does a power of 1/x.
      QDOT_FUZZ_RULE(pow(x, whole(innermost_value(y))),
                     of_x(powq(x, whole(y)), whole(y) * powq(x, whole(y) - 1), whole(y) * (whole(y) - 1) * powq(x, whole(y) - 2)),
                     x != 0 && usual(x), {2.0 + 1.5 * std::abs(whole(y)), 4.0 + 1.5 * std::abs(whole(y)), 6.0 + 1.5 * std::abs(whole(y))}),
      // The rounding of y − 1 and y − 2 in the exponent costs log x, which the larger of two neighbouring ulps may double.
      QDOT_FUZZ_RULE(pow(x, innermost_value(y)), of_x(powq(x, y), y * powq(x, y - 1), y * (y - 1) * powq(x, y - 2)),
                     x > 0 && moderate(x) && std::abs(y) < 64 && std::fmod(4 * y, 1.0) == 0 && y != std::floor(y),
                     {1, 3 + log_size(x), 5 + 2 * log_size(x)}),
      QDOT_FUZZ_RULE(pow(x, y),
                     (Exact{powq(x, y), y * powq(x, y - 1), powq(x, y) * logq(x), y * (y - 1) * powq(x, y - 2),
                            powq(x, y - 1) * (1 + y * logq(x)), powq(x, y) * logq(x) * logq(x), 0,
                            powq(x, y - 1) * (1 + magnitude(y * logq(x)))}),
                     x > 0 && moderate(x) && std::abs(y) < 3 && std::abs(y) > 1e-30, {1, 4 + 2 * log_size(x), 8 + 4 * log_size(x)}),
      QDOT_FUZZ_RULE(hypot(x, y),
                     (Exact{hypotq(x, y), x / hypotq(x, y), y / hypotq(x, y), y * y / powq(hypotq(x, y), 3), -x * y / powq(hypotq(x, y), 3),
                            x * x / powq(hypotq(x, y), 3), 0, 1 / hypotq(x, y)}),
                     usual(x) && usual(y), {1, 2, 5}),
      QDOT_FUZZ_RULE(atan2(x, y),
                     (Exact{atan2q(x, y), y / (x * x + y * y), -x / (x * x + y * y), -2 * x * y / ((x * x + y * y) * (x * x + y * y)),
                            (x - y) * (x + y) / ((x * x + y * y) * (x * x + y * y)), 2 * x * y / ((x * x + y * y) * (x * x + y * y)), 0,
                            1 / (x * x + y * y)}),
                     moderate(x) && moderate(y), {1, 4, 12}),
      QDOT_FUZZ_RULE(fma(x, y, x), (Exact{x * y + x, y + 1, x, 0, 1, 0, magnitude(y) + 1, 0}), moderate(x) && moderate(y), {1, 1, 1}),
      QDOT_FUZZ_RULE(x * y, (Exact{x * y, y, x, 0, 1, 0}), moderate(x) && moderate(y), {1, 1, 1}),
      QDOT_FUZZ_RULE(x / y, (Exact{x / y, 1 / y, -x / (y * y), 0, -1 / (y * y), 2 * x / (y * y * y), 0, magnitude(x / (y * y * y)) * quad(1e-300)}),
                     moderate(x) && moderate(y), {1, 2, 4}),
      QDOT_FUZZ_RULE(x - y * x, (Exact{x - y * x, 1 - y, -x, 0, -1, 0, 1 + magnitude(y), 0}),
                     moderate(x) && moderate(y) && std::abs(1 - y) > 0.25 * std::abs(y), {8, 1, 1}),
  };
  return all;
}
#undef QDOT_FUZZ_RULE

}  // namespace fuzz
