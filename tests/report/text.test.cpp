// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstdlib>
#include <limits>

#include "catch2_bridge.hpp"
#include "qdot/report/csv.hpp"
#include "qdot/report/number.hpp"
#include "qdot/report/symbol.hpp"

using namespace qdot::report;

TEST_CASE("an exact text reads back to the same double") {
  const double x = GENERATE(0.1, 1.0 / 3.0, -9.81, 5e-324, 1.7976931348623157e308, 2.2250738585072014e-308, -0.0, 1e23);
  CHECK(std::strtod(exact_text(x).c_str(), nullptr) == x);
  CHECK(std::signbit(std::strtod(exact_text(x).c_str(), nullptr)) == std::signbit(x));
}

TEST_CASE("texts of numbers are as short as they can be") {
  CHECK(exact_text(0.1) == "0.1");
  CHECK(exact_text(20.0) == "20");
  CHECK(exact_text(1e-10) == "1e-10");
  CHECK(exact_text(std::nan("")) == "nan");
  CHECK(exact_text(-std::numeric_limits<double>::infinity()) == "-inf");
  CHECK(fixed_text(2.50, 3) == "2.5");
  CHECK(fixed_text(-0.0001, 2) == "0");
  CHECK(fixed_text(100, 0) == "100");
  CHECK(readable_text(3.4e-13, 2) == "3.4×10⁻¹³");
  CHECK(readable_text(1e-9) == "10⁻⁹");
}

TEST_CASE("a coordinate's name becomes its symbol") {
  CHECK(symbol("theta1") == "θ₁");
  CHECK(symbol("phidot") == "φ\u0307");
  CHECK(symbol("theta12dot") == "θ\u0307₁₂");
  CHECK(symbol("qdot1") == "q\u0307₁");
  CHECK(symbol("r") == "r");
  CHECK(symbol("kinetic_energy") == "kinetic_energy");
  CHECK(unit_symbol("kg m^2/s^2") == "kg m²/s²");
  CHECK(with_unit_symbol("t", "s") == "t [s]");
  CHECK(with_unit_symbol("t", "") == "t");
}

TEST_CASE("names and numbers in a text become symbols, and units and words stay what they are") {
  CHECK(in_symbols("theta1dot at the start") == "θ\u0307₁ at the start");
  CHECK(in_symbols("max(theta) [rad]") == "max(θ) [rad]");
  CHECK(in_symbols("mu [mu]") == "μ [mu]");
  CHECK(in_symbols("l [m/s^2]") == "l [m/s²]");
  CHECK(in_symbols("kinetic_energy") == "kinetic_energy");
  CHECK(in_symbols("∂theta/∂…") == "∂θ/∂…");
  CHECK(in_symbols("|phi| = -0.5, from -2e-11 to 1.5e+06") == "|φ| = −0.5, from −2×10⁻¹¹ to 1.5×10⁶");
  CHECK(with_readable_numbers("-1, (-2) 3-4 a-5 2026-11-27") == "−1, (−2) 3-4 a-5 2026-11-27");
  CHECK(with_readable_numbers("-x, 1ex, 2e-, e-5, x1e5") == "-x, 1ex, 2e-, e-5, x1e5");
}

TEST_CASE("a CSV has one line of headings with units and one line per row") {
  const Table table{{{"t", "s", {0.0, 0.1}}, {"theta", "rad", {1.0 / 3.0, -2.0}}, {"x", "", {1.0, 1e-300}}}};
  CHECK(csv(table) == "t [s],theta [rad],x\n0,0.3333333333333333,1\n0.1,-2,1e-300\n");
}

TEST_CASE("a CSV quotes a heading that contains commas or quotes") {
  CHECK(csv({{{"a,b", "", {}}, {"say \"x\"", "m", {}}}}) == "\"a,b\",\"say \"\"x\"\" [m]\"\n");
}

TEST_CASE("a table whose columns differ in length is refused") {
  const Table table{{{"t", "s", {0.0, 0.1}}, {"x", "m", {1.0}}}};
  CHECK_THROWS_AS(csv(table), qdot::DimensionError);
}
