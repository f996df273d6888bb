// SPDX-License-Identifier: MIT
//
// One list of functions, the same for every scalar that T and V can meet: values against the C library's, derivatives against difference
// quotients of it in long double. What a scalar cannot take it refuses in words.
#include "catch2_bridge.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "qdot/ad/formula/recording.hpp"
#include "qdot/ad/records/reverse.hpp"
#include "qdot/ad/pack_math.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"

using namespace qdot;
using namespace qdot::detail;

namespace {

constexpr double at = 0.6, rate = 0.7;  // x, and its derivative along whatever a scalar differentiates along
constexpr double rounded = 1e-13;       // a dozen operations, and (h⁴ f⁽⁵⁾ + ε/h)/30 of long double

Dual<double, 1> moving(double x, double xdot) {
  Dual<double, 1> d(x);
  d.tangent[0] = xdot;
  return d;
}

template <class S>
using Values = std::vector<S>;

// Each function that is one formula everywhere, with all arguments moving, and one beside plain numbers.
template <class S>
Values<S> analytic(const S& x) {
  using std::acos, std::acosh, std::asin, std::asinh, std::atan, std::atan2, std::atanh, std::cbrt, std::cos, std::cosh, std::erf, std::erfc,
      std::exp, std::exp2, std::expm1, std::fma, std::hypot, std::log, std::log10, std::log1p, std::log2, std::pow, std::sin, std::sinh, std::sqrt,
      std::tan, std::tanh;
  const S y = 1.5 + x;
  return {sqrt(x), cbrt(x), exp(x), exp2(x), expm1(x), log(x), log2(x), log10(x), log1p(x), erf(x), erfc(x), sin(x), cos(x), tan(x), asin(x), acos(x),
          atan(x), sinh(x), cosh(x), tanh(x), asinh(x), acosh(y), atanh(x), pow(x, 3), pow(x, -2), pow(x, 1.5), pow(x, y), pow(2.0, x), atan2(x, y),
          atan2(x, 2.0), atan2(2.0, x), hypot(x, y), hypot(x, 2.0), hypot(2.0, x), hypot(x, y, x), hypot(x, 2.0, 1.5), hypot(2.0, x, y), fma(x, y, x),
          fma(x, 2.0, 1.5), fma(2.0, x, y), fma(2.0, 1.5, x), sincos(x).sin, sincos(x).cos};
}
// And those that are not.
template <class S>
Values<S> kinked(const S& x) {
  using std::abs, std::ceil, std::copysign, std::fabs, std::floor, std::fmax, std::fmin, std::max, std::min;
  const S y = 1.5 + x, minus = -x;
  return {abs(minus), fabs(minus), floor(minus), ceil(y), max(x, y), max(x, S(1.0)), min(x, y), min(y, S(1.0)), fmax(x, y), fmax(x, 1.0), fmax(1.0, y),
          fmin(x, y), fmin(x, 1.0), fmin(1.0, y), copysign(y, minus), copysign(x, -1.0), copysign(2.0, minus)};
}
template <class S>
Values<S> all(const S& x) {
  Values<S> values = analytic(x);
  for (const S& value : kinked(x)) values.push_back(value);
  return values;
}

// Whatever a scalar says about f(x(t)), value and d/dt, must be what differences say.
struct Truth {
  std::vector<double> value, derivative;
};
const Truth& truth() {
  static const Truth known = [] {
    Truth t;
    constexpr long double h = 1e-4L;
    std::array<Values<long double>, 5> f;
    for (int k = 0; k < 5; ++k) f[static_cast<std::size_t>(k)] = all<long double>(at + (k - 2) * h);
    for (std::size_t i = 0; i < f[2].size(); ++i) {
      t.value.push_back(static_cast<double>(f[2][i]));
      t.derivative.push_back(static_cast<double>(rate * (f[0][i] - 8 * f[1][i] + 8 * f[3][i] - f[4][i]) / (12 * h)));
    }
    return t;
  }();
  return known;
}
template <class S, class ValueOf, class DerivativeOf>
void check(const Values<S>& f, const ValueOf& value, const DerivativeOf& derivative) {
  for (std::size_t i = 0; i < f.size(); ++i) {
    INFO("function " << i);
    CHECK_THAT(value(f[i]), WithinAbs(truth().value[i], rounded * (1 + std::abs(truth().value[i]))));
    CHECK_THAT(derivative(f[i]), WithinAbs(truth().derivative[i], 10 * rounded * (1 + std::abs(truth().derivative[i]))));
  }
}
struct Rope {
  constexpr auto T(const auto& v) const { return 0.5 * (v[0] * v[0] + v[1] * v[1]); }
  constexpr auto V(const auto& q) const {
    using std::hypot;
    return hypot(q[0], q[1]);
  }
};

}  // namespace

TEST_CASE("every function is there for numbers and for duals of any depth") {
  using D = Dual<double, 1>;
  using DD = Dual<D, 1>;
  check(all(moving(at, rate)), [](const D& f) { return f.value; }, [](const D& f) { return f.tangent[0]; });
  check(all(DD(moving(at, rate))), [](const DD& f) { return f.value.value; }, [](const DD& f) { return f.value.tangent[0]; });
}

TEST_CASE("every function is there for packs") {
  using P = Pack<2>;
  const auto lane = [](const P& f) { return f[1]; };
  const Values<P> values = all(P(at));
  for (std::size_t i = 0; i < values.size(); ++i) {
    INFO("function " << i);
    CHECK_THAT(lane(values[i]), WithinAbs(truth().value[i], rounded * (1 + std::abs(truth().value[i]))));
  }
}

TEST_CASE("every function is there backwards") {
  using N = Dual<double, 1>;
  Tape<N> tape(1, 0);
  const Reverse<N> x = tape.variable(0, N(at));
  std::vector<N> adjoint;
  check(all(x), [](const Reverse<N>& f) { return f.value.value; },
        [&](const Reverse<N>& f) {
          tape.sweep(f, adjoint);
          return rate * adjoint[0].value;
        });
  Tape<double> plain(1);
  std::vector<double> share;
  check(all(plain.variable(0, at)), [](const Reverse<double>& f) { return f.value; },
        [&](const Reverse<double>& f) {
          plain.sweep(f, share);
          return rate * share[0];
        });
}

TEST_CASE("every analytic function is there for series, and the others are refused in words") {
  formula::Recording run;
  const formula::Recorded x(run, run.graph.variable(0));
  std::vector<int> outputs, slopes;
  for (const formula::Recorded& f : analytic(x)) outputs.push_back(f.node_in(run));
  const int variable = 0;
  for (const int f : outputs) slopes.push_back(run.graph.gradient(f, std::span<const int>(&variable, 1))[0]);
  std::vector<double> number;
  for (const formula::Node& w : run.graph.nodes()) {
    const auto of = [&](int k) { return k < 0 ? 0.0 : number[static_cast<std::size_t>(k)]; };
    switch (w.kind) {
      case formula::Kind::constant: number.push_back(w.c); break;
      case formula::Kind::variable: number.push_back(at); break;
      case formula::Kind::affine: number.push_back(w.ca * of(w.a) + w.cb * of(w.b) + w.c); break;
      case formula::Kind::product: number.push_back(of(w.a) * of(w.b)); break;
      case formula::Kind::quotient: number.push_back(of(w.a) / of(w.b)); break;
      case formula::Kind::power: number.push_back(std::pow(of(w.a), w.c)); break;
      case formula::Kind::function: number.push_back(formula::value_of(w.function, of(w.a), of(w.b))); break;
    }
  }
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    INFO("function " << i);
    const double value = number[static_cast<std::size_t>(outputs[i])], slope = number[static_cast<std::size_t>(slopes[i])];
    CHECK_THAT(value, WithinAbs(truth().value[i], rounded * (1 + std::abs(truth().value[i]))));
    CHECK_THAT(rate * slope, WithinAbs(truth().derivative[i], 10 * rounded * (1 + std::abs(truth().derivative[i]))));
  }
  const auto refused = [&](const auto& use) {
    try {
      use();
      return std::string("taken");
    } catch (const NotAnalytic& error) {
      return std::string(error.what());
    }
  };
  const auto says = [&](const auto& use, const std::string& name) { return refused(use).find("uses the " + name) != std::string::npos; };
  CHECK(says([&] { return abs(x); }, "function abs"));
  CHECK(says([&] { return floor(x); }, "function floor"));
  CHECK(says([&] { return ceil(x); }, "function ceil"));
  CHECK(says([&] { return max(x, 1.0); }, "comparison max"));
  CHECK(says([&] { return fmin(1.0, x); }, "comparison min"));
  CHECK(says([&] { return copysign(1.0, x); }, "function copysign"));
  CHECK(says([&] { return isnan(x); }, "function isnan"));
}

TEST_CASE("a function that ends has no slope beyond its end, for any scalar") {
  const auto no_slope = [](const auto& f, double outside) {
    using D = Dual<double, 1>;
    Tape<D> tape(1, 0);
    std::vector<D> adjoint;
    const Reverse<D> backwards = f(tape.variable(0, D(outside)));
    tape.sweep(backwards, adjoint);
    return std::isnan(f(moving(outside, 1.0)).tangent[0]) && std::isnan(adjoint[0].value);
  };
  CHECK(no_slope([](const auto& x) { return log(x); }, -1.0));
  CHECK(no_slope([](const auto& x) { return log2(x); }, -1.0));
  CHECK(no_slope([](const auto& x) { return log10(x); }, -1.0));
  CHECK(no_slope([](const auto& x) { return log1p(x); }, -2.0));
  CHECK(no_slope([](const auto& x) { return atanh(x); }, 1.5));
  CHECK(no_slope([](const auto& x) { return acosh(x); }, -1.5));
}

TEST_CASE("hypot keeps its range and its digits in equations of motion") {
  const auto system = mechanical_system<2>(Rope{});
  for (const double size : {1e-160, 1e-9, 1.0, 1e200}) {
    INFO(size);
    const Vector<double, 2> q(3 * size, 4 * size), v(0.0, 0.0), a = acceleration(system, q, v);
    CHECK_THAT(a[0], WithinAbs(-0.6, rounded));
    CHECK_THAT(a[1], WithinAbs(-0.8, rounded));
  }
}
