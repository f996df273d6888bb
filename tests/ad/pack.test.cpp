// SPDX-License-Identifier: MIT
//
// Packs against the same operations on their lanes, and their functions against 64-bit mantissas.
#include "catch2_bridge.hpp"

#include <cmath>
#include <limits>
#include <random>

#include "qdot/ad/pack_math.hpp"

using namespace qdot;

namespace {

using P = Pack<8>;

constexpr double infinity = std::numeric_limits<double>::infinity();

// The largest error over random arguments, in units in the last place of the exact value.
template <class F, class Exact>
double worst_error(const F& f, const Exact& exact, double low, double high) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(low, high);
  double worst = 0.0;
  for (int sample = 0; sample < 4000; ++sample) {
    const P x = P::of([&](int) { return uniform(random); });
    const P y = f(x);
    for (int lane = 0; lane < P::size; ++lane) {
      const long double right = exact(static_cast<long double>(x[lane]));
      const double magnitude = std::abs(static_cast<double>(right));
      const double ulp = std::nextafter(magnitude, infinity) - magnitude;
      const double error = static_cast<double>(std::abs(static_cast<long double>(y[lane]) - right)) / ulp;
      worst = error <= worst ? worst : error;  // NaN counts
    }
  }
  return worst;
}

}  // namespace

TEST_CASE("arithmetic and comparisons of packs are those of their lanes") {
  const P a = P::of([](int lane) { return 0.5 + lane; });
  const P b = P::of([](int lane) { return 4.25 - lane; });
  const P sum = 2.0 * a + b / 4 - 1, product = -a * b;
  for (int lane = 0; lane < 8; ++lane) {
    CHECK(sum[lane] == 2.0 * a[lane] + b[lane] / 4 - 1);
    CHECK(product[lane] == -a[lane] * b[lane]);
    CHECK((a < b)[lane] == (a[lane] < b[lane]));
    CHECK(((!(a >= b)) & (a != 1.5))[lane] == (a[lane] < b[lane] && a[lane] != 1.5));
    CHECK(select(a < b, a, b)[lane] == std::min(a[lane], b[lane]));
    CHECK(max(a, b)[lane] == std::max(a[lane], b[lane]));
    CHECK(abs(a - b)[lane] == std::abs(a[lane] - b[lane]));
  }
  CHECK((a < b).any());
  CHECK(!(a < b).all());
  CHECK((a > 0.0).all());
  CHECK(!(a < 0.0).any());
  double memory[8];
  a.store(memory);
  CHECK((P::load(memory) == a).all());
  CHECK(select(1.0 < 2.0, 3.0, 4.0) == 3.0);
}

TEST_CASE("functions of packs are right to a unit or two in the last place") {
  const auto sine = [](const P& x) { return sin(x); };
  const auto cosine = [](const P& x) { return cos(x); };
  const auto exact_sine = [](long double x) { return std::sin(x); };
  const auto exact_cosine = [](long double x) { return std::cos(x); };
  for (const double range : {1.0, 10.0, 1e5, 2e7}) {
    CHECK(worst_error(sine, exact_sine, -range, range) < 1.6);
    CHECK(worst_error(cosine, exact_cosine, -range, range) < 1.6);
  }
  CHECK(worst_error([](const P& x) { return tan(x); }, [](long double x) { return std::tan(x); }, -10.0, 10.0) < 3.5);
  CHECK(worst_error([](const P& x) { return exp(x); }, [](long double x) { return std::exp(x); }, -720.0, 700.0) < 1.1);
  CHECK(worst_error([](const P& x) { return exp(x); }, [](long double x) { return std::exp(x); }, -1.0, 1.0) < 1.1);
  CHECK(worst_error([](const P& x) { return log(x); }, [](long double x) { return std::log(x); }, 0.5, 2.0) < 1.1);
  CHECK(worst_error([](const P& x) { return log(x); }, [](long double x) { return std::log(x); }, 1e-5, 1e5) < 1.1);
  CHECK(worst_error([](const P& x) { return sqrt(x); }, [](long double x) { return std::sqrt(x); }, 0.0, 10.0) <= 0.501);
  CHECK(worst_error([](const P& x) { return pow(x, 1.5); }, [](long double x) { return std::pow(x, 1.5L); }, 0.1, 10.0) < 1.6);
  CHECK(worst_error([](const P& x) { return pow(x, -3); }, [](long double x) { return std::pow(x, -3.0L); }, 0.1, 10.0) < 2.6);
  CHECK(worst_error([](const P& x) { return pow(x, 0.3); }, [](long double x) { return std::pow(x, 0.3L); }, 0.1, 10.0) < 9.0);  // 0.3
}

TEST_CASE("sine and cosine are right beside multiples of a quarter turn") {
  for (const double k : {1.0, 2.0, 11.0, 1000.0, 36573.0, 63661.0}) {
    const double x = k * 1.5707963267948966;
    CHECK(sin(P(x))[3] == Approx(std::sin(x)).epsilon(1e-15).margin(0));
    CHECK(cos(P(x))[5] == Approx(std::cos(x)).epsilon(1e-15).margin(0));
  }
}

TEST_CASE("lanes outside of a function's range are those of <cmath>") {
  const P x = P::of([](int lane) { return lane == 2 ? 1e9 : lane == 5 ? infinity : 0.25; });
  CHECK(sin(x)[2] == std::sin(1e9));
  CHECK(std::isnan(sin(x)[5]));
  CHECK(sin(x)[0] == Approx(std::sin(0.25)).epsilon(1e-15));
  CHECK(exp(x)[5] == infinity);
  CHECK(exp(-x)[2] == 0.0);
  CHECK(log(P(0.0))[1] == -infinity);
  CHECK(std::isnan(log(P(-1.0))[1]));
  CHECK(log(P(1e-310))[0] == std::log(1e-310));
}
