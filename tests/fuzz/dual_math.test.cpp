// SPDX-License-Identifier: MIT
#include "dual_math.hpp"

#include <random>

#include "catch2_bridge.hpp"
#include "seed.hpp"

using fuzz::D;

namespace {

// Arguments at which branches, overflow or cancellation are near.
const std::vector<double> special = {0.0, -0.0, 1.0, -1.0, 0.5, -0.5, 2.0, 3.0, -2.0, 1e-5, 1e-9, 1e-17, 1e-100, 1e-200, 1e-289, 1e-308, 5e-324,
                                     1.0 + 0x1p-52, 1.0 - 0x1p-53, -1.0 + 0x1p-53, 1.5707963267948966, 3.141592653589793, 0.7853981633974483,
                                     18.0, 20.0, 36.0, -37.0, -40.0, 354.0, 356.0, 709.0, 711.0, -744.0, -746.0, 1e3, 3.9e3, 1e10, 1e16, 1e50,
                                     1e120, 1e155, 1e200, 1e289, 1.7e308, 2.5, -2.5, 1e-50, -12.0, 12.0, -6.0, 0.25, 0.75};

double random_number(std::mt19937_64& random) {
  const double mantissa = std::uniform_real_distribution<double>(1.0, 2.0)(random);
  const bool far = random() % 8 == 0;
  const int exponent = far ? std::uniform_int_distribution<int>(-1000, 1000)(random) : std::uniform_int_distribution<int>(-12, 5)(random);
  return (random() % 2 == 0 ? 1.0 : -1.0) * std::ldexp(mantissa, exponent);
}

}  // namespace

TEST_CASE("functions of duals and two derivatives of them agree with quadruple precision to a few units in the last place") {
  std::mt19937_64 random(fuzz::seed());
  constexpr int samples = 400;
  for (const fuzz::Rule& rule : fuzz::rules()) {
    INFO(fuzz::seed_text());
    std::string wrong;
    long inside = 0;
    const auto look = [&](double x, double y) {
      inside += rule.inside(x, y);
      if (wrong.size() < 1000) wrong += fuzz::disagreement(rule, x, y);
    };
    for (const double x : special) {
      look(x, 1.5);
      for (const double y : {-12.0, -2.0, -1.0, 0.5, 1.0, 2.0, 7.0}) look(x, y), look(y, x);
    }
    for (int i = 0; i < samples; ++i) {
      const double x = random_number(random), y = random_number(random);
      look(x, y);
      look(x, std::round(4 * y) / 4);
      look(1.0 + 0.01 * x, y);
    }
    CHECK(inside > samples / 4);
    INFO(wrong);
    CHECK(wrong.empty());
  }
}

TEST_CASE("at a tie the first of two is the larger and the smaller") {
  const D x = D::variable(3.0, 0), y = D::variable(3.0, 1);
  CHECK(max(x, y).tangent[0] == 1.0);
  CHECK(max(y, x).tangent[1] == 1.0);
  CHECK(min(x, y).tangent[0] == 1.0);
  CHECK(min(y, x).tangent[1] == 1.0);
}

TEST_CASE("zero to a power that varies has no slope along the exponent") {
  const D x = D::variable(0.0, 0), y = D::variable(2.5, 1);
  CHECK(pow(x, y).value == 0.0);
  CHECK(pow(x, y).tangent[0] == 0.0);
  CHECK(pow(x, y).tangent[1] == 0.0);
}

TEST_CASE("exponents beyond every integer are exponents all the same") {
  const D x = D::variable(1.0, 0);
  CHECK(pow(x, 1e300).value == 1.0);
  CHECK(pow(x, 1e300).tangent[0] == 1e300);
  CHECK(pow(D::variable(0.5, 0), 1e300).value == 0.0);
  CHECK(std::isinf(pow(D::variable(2.0, 0), 1e300).value));
}
