// SPDX-License-Identifier: MIT
#include <cmath>

#include "../catch2_bridge.hpp"
#include "qdot/ad/derivatives.hpp"
#include "qdot/ad/formula/recording.hpp"
#include "qdot/ad/series/sweep.hpp"

namespace {

using namespace qdot;
using formula::Recorded;
using formula::Recording;
using taylor::Sweep;

// Sums of some twenty terms of size one.
constexpr double rounding = 1e-14;

// The series of f(t₀ + s) to order 24, summed at s.
template <class Formula>
double summed_series(const Formula& f, double t0, double s) {
  constexpr int order = 24;
  Recording recording;
  const int t = recording.graph.variable(0);
  const int w = f(Recorded(recording, t)).node_in(recording);
  Sweep sweep(recording.graph, {.early = {}, .series = {w, t}, .values = {}, .late = {}}, order);
  sweep.set(sweep.slot(t), t0);
  sweep.start();
  double sum = sweep.latest(sweep.slot(w)), power = 1.0;
  for (int k = 1; k <= order; ++k) {
    sweep.set(sweep.slot(t), k == 1 ? 1.0 : 0.0);
    sweep.advance(k);
    sweep.complete(k);
    power *= s;
    sum += sweep.latest(sweep.slot(w)) * power;
  }
  return sum;
}

// ∂f/∂x of a recorded formula at a plain number.
template <class Formula>
double recorded_derivative(const Formula& f, double x) {
  Recording recording;
  const int variable = recording.graph.variable(0);
  const int w = f(Recorded(recording, variable)).node_in(recording);
  const int variables[] = {variable};
  const int derivative = recording.graph.gradient(w, variables)[0];
  Sweep sweep(recording.graph, {.early = {}, .series = {variable}, .values = {derivative}, .late = {}}, 1);
  sweep.set(sweep.slot(variable), x);
  sweep.start();
  return sweep.value(sweep.slot(derivative));
}

#define QDOT_CHECK_FORMULA(expression)                                                                          \
  do {                                                                                                          \
    const auto f = [](const auto& x) {                                                                          \
      using std::acos, std::acosh, std::asin, std::asinh, std::atan, std::atan2, std::atanh, std::cbrt, std::cos, \
          std::cosh, std::erf, std::erfc, std::exp, std::exp2, std::expm1, std::fma, std::hypot, std::log, std::log10, \
          std::log1p, std::log2, std::pow, std::sin, std::sinh, std::sqrt, std::tan, std::tanh;                 \
      return expression;                                                                                        \
    };                                                                                                          \
    INFO(#expression);                                                                                          \
    CHECK_THAT(summed_series(f, 0.37, 0.05), WithinAbs(f(0.42), rounding * (1 + std::abs(f(0.42)))));           \
    const double expected = derivative(f, 0.37);                                                                \
    CHECK_THAT(recorded_derivative(f, 0.37), WithinAbs(expected, rounding * (1 + std::abs(expected))));          \
  } while (false)

TEST_CASE("the series of every function sums to the function, and its derivative is the dual number's") {
  QDOT_CHECK_FORMULA(sin(3.0 * x) * cos(x));
  QDOT_CHECK_FORMULA(tan(x));
  QDOT_CHECK_FORMULA(asin(x) + acos(x * x) + atan(2.0 * x));
  QDOT_CHECK_FORMULA(atan2(1.0 + x, 2.0 - x * x));
  QDOT_CHECK_FORMULA(exp(x) - expm1(x * x) + exp2(x));
  QDOT_CHECK_FORMULA(log(x + 1.0) + log1p(x * x) + log2(x + 2.0) + log10(x + 3.0));
  QDOT_CHECK_FORMULA(sinh(x) * cosh(x) - tanh(2.0 * x));
  QDOT_CHECK_FORMULA(asinh(x) + acosh(2.0 + x) + atanh(x));
  QDOT_CHECK_FORMULA(cbrt(1.0 + x) * sqrt(2.0 + x * x));
  QDOT_CHECK_FORMULA(erf(x) + erfc(x * x));
  QDOT_CHECK_FORMULA(hypot(x, 1.0 + x));
  QDOT_CHECK_FORMULA(hypot(x, x) + x * atan2(x, x));
  QDOT_CHECK_FORMULA(fma(x, x, 1.0 + x));
  QDOT_CHECK_FORMULA(pow(x + 1.0, 3) + pow(x + 1.0, -2) + pow(x + 2.0, 1.5) + pow(x + 2.0, -0.3) + pow(1.0 + x, x));
  QDOT_CHECK_FORMULA(1.0 / (1.0 + x * x) - (1.0 + x) / (3.0 - x) + (x * x + 2.0) / sqrt(1.0 + x));
  QDOT_CHECK_FORMULA((x - 1.0) * (x - 1.0) * (2.0 - x) / 7.0 - x + 4.0);
}

TEST_CASE("whole powers are right at zero") {
  for (const int k : {2, 3, 4, 16}) {
    const auto power = [k](const auto& x) {
      using std::pow;
      return pow(x, k) * 1.0;
    };
    CHECK(summed_series(power, 0.0, 0.5) == std::pow(0.5, k));
    CHECK(recorded_derivative(power, 0.0) == 0.0);
  }
}

TEST_CASE("a formula that occurs twice is one node, and simple ones are simplified") {
  Recording recording;
  formula::Graph& g = recording.graph;
  const Recorded x(recording, g.variable(0)), y(recording, g.variable(1));
  const auto node = [&](const Recorded& r) { return r.node_in(recording); };
  CHECK(node(cos(x - y) * x) == node(x * cos(x - y)));
  CHECK(node(x * y - y * x) == g.constant(0.0));
  CHECK(node(2.0 * x / 2.0) == node(x));
  CHECK(node(0.0 * x) == g.constant(0.0));
  CHECK(node(x / x) == g.constant(1.0));
  CHECK(node(1.0 / sqrt(x * x + y * y) / sqrt(x * x + y * y)) == node(1.0 / (x * x + y * y)));
  CHECK(node(-(-x)) == node(x));
}

TEST_CASE("what has no series is refused in words") {
  Recording recording;
  const Recorded x(recording, recording.graph.variable(0));
  CHECK_THROWS_WITH(abs(x),
                    "power series, and derivatives by Taylor and Gauss, need energies and forces that are one formula everywhere, but T or V uses the "
                    "function abs of its arguments; Dop853 takes them as they are");
  CHECK_THROWS_AS(x < 1.0, NotAnalytic);
  CHECK_THROWS_AS(max(x, Recorded(0.0)), NotAnalytic);
  CHECK(Recorded(1.0) < Recorded(2.0));
  CHECK_FALSE(x == 0.0);
  REQUIRE(recording.assumptions.size() == 1);
}

}  // namespace
