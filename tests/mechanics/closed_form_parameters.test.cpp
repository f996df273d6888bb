// SPDX-License-Identifier: MIT
//
// Equations that the compiler has derived: what parameters may do to them.
#include "catch2_bridge.hpp"

#include <cmath>
#include <utility>

#include "mechanics/closed_form_difference.hpp"

using namespace qdot;

namespace {

// A few dozen operations.
constexpr double rounded = 1e-12;

// Sums and differences of parameters that stand in a row.
struct SumsInARow {
  double m = 1.0, a = 1.5, b = 2.5, c = 3.5, d = 4.5, e = 5.5;
  constexpr auto T(const auto& v) const { return 0.5 * m * v.squaredNorm(); }
  constexpr auto V(const auto& q) const {
    const auto x = q[0] * q[0], y = q[1] * q[1], z = q[2] * q[2];
    return a * x + b * y + c * y + d * x + e * z - d * z + c * q[0] * q[1] - b * q[0] * q[1];
  }
};

// A large literal beside parameters, and a small one.
struct EarthAndMoon {
  double moon = 1.0, dust = 1.0, k = 3.0;
  constexpr auto T(const auto& v) const {
    return 0.5 * 5.97e24 * v[0] * v[0] + 0.5 * moon * v[0] * v[0] + 0.5 * dust * v[1] * v[1] + 1e-26 * k * v[1] * v[1];
  }
  constexpr auto V(const auto& q) const { return k * (q[0] + q[1]); }
};

// Roots of parameters that add up to the root of another, if roots were linear.
struct Roots {
  double a = 1.0, b = 2.0;
  constexpr auto T(const auto& v) const { return 0.5 * v.squaredNorm(); }
  constexpr auto V(const auto& q) const {
    using std::sqrt;
    const auto x = 1.0 + q[0] * q[0];
    return sqrt(a * x) + sqrt(b * x) + sqrt(a * x + b * x) + 2.0 * sqrt(a * (1.0 + q[1] * q[1])) + sqrt(a * (2.0 + 2.0 * q[1] * q[1]));
  }
};

// Roots and powers of literals, functions of what turns out to be a parameter.
struct Constants {
  double a = 1.0;
  constexpr auto T(const auto& q, const auto& v) const {
    using std::sin, std::sqrt;
    return 0.5 * sqrt(2.0 * (1.0 + q[0] * q[0])) * v[0] * v[0] + 0.5 * (1.0 + sin(q[0] - q[0] + a)) * v[1] * v[1];
  }
  constexpr auto V(const auto& q) const {
    using std::pow;
    return pow(3.0 * q[0], -1.5) + pow(5.0 * q[1], -3.0) + pow(q[0] - q[0] + 2.0, 0.25) * q[1];
  }
};

struct DoublePendulum {
  double m1 = 1.5, m2 = 0.4, l1 = 1.1, l2 = 0.8, g = 9.81;
  constexpr auto T(const auto& q, const auto& v) const {
    using std::cos;
    return 0.5 * (m1 + m2) * l1 * l1 * v[0] * v[0] + 0.5 * m2 * l2 * l2 * v[1] * v[1] + m2 * l1 * l2 * v[0] * v[1] * cos(q[0] - q[1]);
  }
  constexpr auto V(const auto& q) const {
    using std::cos;
    return -(m1 + m2) * g * l1 * cos(q[0]) - m2 * g * l2 * cos(q[1]);
  }
};

// The first mass matters only relative to the second.
struct TwoMasses {
  double m = 1.0, M = 1.0;
  constexpr auto T(const auto& v) const { return 0.5 * m * v[0] * v[0] + 0.5 * M * (v[0] + v[1]) * (v[0] + v[1]); }
  constexpr auto V(const auto& q) const { return q[0] + 2.0 * q[1] * q[1]; }
};

struct OneWithoutMass {
  double m = 1.0;
  constexpr auto T(const auto& v) const { return 0.5 * m * v[0] * v[0]; }
  constexpr auto V(const auto& q) const { return q[0] * q[1]; }
};

// A root of what has the sign of a parameter.
struct RootOfSign {
  double m = 1.0;
  constexpr auto T(const auto& v) const { return 0.5 * v.squaredNorm(); }
  constexpr auto V(const auto& q) const {
    using std::sqrt;
    return sqrt(m * q[0]);
  }
};

struct Equal {
  double m1 = 1.0, m2 = 1.0, k1 = 1.0, k2 = 1.0;
  constexpr auto T(const auto& v) const { return 0.5 * m1 * v[0] * v[0] + 0.5 * m2 * v[1] * v[1]; }
  constexpr auto V(const auto& q) const { return k1 * q[0] * q[0] * q[1] - k2 * q[1] * q[1] * q[0] + m2 * q[1]; }
};

template <int n, class E>
bool is_in_closed_form(const E& energies, const Vector<double, n>& q, const Vector<double, n>& v) {
  const auto written = written_out<n>(energies);
  Vector<double, n> a;
  return detail::closed_form_acceleration<n>(written, q.data(), v.data(), 0.0, a.data());
}

}  // namespace

TEST_CASE("what sums and differences of parameters are is not confused, wherever the parameters stand") {
  CHECK(difference_of_ways<3>(SumsInARow{.m = 0.7, .a = 0.31, .b = 1.7, .c = 0.43, .d = 2.9, .e = 7.3}, 0.5, 1.5) < rounded);
  CHECK(difference_of_ways<2>(Roots{.a = 0.7, .b = 3.1}, 0.5, 1.5) < rounded);
}

TEST_CASE("a parameter is not lost beside a large literal, nor a small literal beside a parameter") {
  CHECK(difference_of_ways<2>(EarthAndMoon{.moon = 7.3e23, .dust = 1e-27}, 0.5, 1.5) < rounded);
}

TEST_CASE("powers of literals and functions of parameters are what they are") {
  CHECK(difference_of_ways<2>(Constants{.a = 0.4}, 0.5, 1.5) < rounded);
}

TEST_CASE("parameters that are equal by accident in the object that the compiler tries are still two") {
  CHECK(difference_of_ways<2>(Equal{.m1 = 0.5, .m2 = 3.0, .k1 = 0.2, .k2 = 7.0}, -1.0, 1.0) < rounded);
}

TEST_CASE("lambdas keep what they have captured in derived equations") {
  const double m = 0.7, k = 12.0;
  const auto system = mechanical_system<1>(written_out<1>([=](const auto& q, const auto& v) { return 0.5 * m * (1.0 + q[0] * q[0]) * v[0] * v[0]; },
                                                          [=](const auto& q) { return 0.5 * k * q[0] * q[0]; }));
  const Vector<double, 1> q(0.4), v(1.1);
  Vector<double, 1> a;
  REQUIRE(detail::closed_form_acceleration<1>(system.energies(), q.data(), v.data(), 0.0, a.data()));
  CHECK_THAT(a[0], WithinRel((-k * q[0] - m * q[0] * v[0] * v[0]) / (m * (1.0 + q[0] * q[0])), rounded));
}

TEST_CASE("copies and moves of written-out energies have the same derived equations, and a default one those of the default object") {
  using Written = decltype(written_out<2>(DoublePendulum{}));
  const Vector<double, 2> q(0.4, -0.7), v(1.1, 0.3);
  const Written original = written_out<2>(DoublePendulum{.m1 = 0.2, .m2 = 3.0});
  Written copy = original;
  Written assigned;
  Vector<double, 2> a, b;
  const auto of = [&](const Written& w, Vector<double, 2>& result) { return detail::closed_form_acceleration<2>(w, q.data(), v.data(), 0.0, result.data()); };
  REQUIRE(of(assigned, a));
  REQUIRE(of(written_out<2>(DoublePendulum{}), b));
  CHECK(a == b);
  REQUIRE(of(original, a));
  REQUIRE(of(copy, b));
  CHECK(a == b);
  assigned = std::move(copy);
  REQUIRE(of(assigned, b));
  CHECK(a == b);
}

TEST_CASE("a state without a mass matrix is no state of the derived equations: the general way names it") {
  const Vector<double, 3> top(0.0, 0.2, 0.3), spin(0.1, 0.2, 4.0);
  CHECK(!is_in_closed_form<3>(HeavyTop{}, top, spin));
  CHECK(!is_in_closed_form<2>(OneWithoutMass{}, {1.0, 2.0}, {0.1, 0.2}));
  CHECK(!is_in_closed_form<2>(DoublePendulum{.m1 = 0.0}, {0.3, 0.3}, {0.1, 0.2}));
  CHECK(!is_in_closed_form<2>(DoublePendulum{.m1 = 0.0}, {0.3, 0.3 + 1e-9}, {0.1, 0.2}));
  CHECK(!is_in_closed_form<2>(DoublePendulum{.m1 = 1e-17}, {0.3, 0.3 - 1e-10}, {0.1, 0.2}));
  CHECK(is_in_closed_form<2>(DoublePendulum{.m1 = 0.0}, {0.3, 0.8}, {0.1, 0.2}));
}

TEST_CASE("masses that are zero, negative, not a number, or lost beside others have no derived equations") {
  const Vector<double, 2> q(0.3, 0.8), v(0.1, 0.2);
  const double nan = std::nan("");
  for (const double m : {0.0, -1.0, nan, 1e-17, -1e-17}) {
    CHECK(!is_in_closed_form<2>(TwoMasses{.m = m, .M = 1.0}, q, v));
    CHECK(!is_in_closed_form<2>(OneWithoutMass{.m = m}, q, v));
  }
  CHECK(!is_in_closed_form<2>(TwoMasses{.m = 1.0, .M = 0.0}, q, v));
  CHECK(!is_in_closed_form<2>(DoublePendulum{.l2 = 0.0}, q, v));
  CHECK(!is_in_closed_form<2>(DoublePendulum{.m1 = 1.0, .m2 = -0.5}, q, v));
  CHECK(!is_in_closed_form<3>(HeavyTop{.A = -1.0}, {0.3, 0.2, 0.1}, {0.1, 0.2, 0.3}));
  CHECK(!is_in_closed_form<3>(HeavyTop{.C = 0.0}, {0.3, 0.2, 0.1}, {0.1, 0.2, 0.3}));
  CHECK(is_in_closed_form<2>(TwoMasses{.m = 1e-3, .M = 1.0}, q, v));
}

TEST_CASE("a root of a product with negative factors is taken, by whatever way") {
  const auto system = mechanical_system<1>(written_out<1>(RootOfSign{.m = -2.0}));
  const Vector<double, 1> q(-0.5), v(0.1);
  CHECK_THAT(acceleration(system, q, v)[0], WithinRel(1.0, rounded));  // −m/(2√(m q))
}

TEST_CASE("what is not finite is not handed back by derived equations") {
  const double nan = std::nan(""), infinity = HUGE_VAL;
  for (const double bad : {nan, infinity, -infinity}) {
    CHECK(!is_in_closed_form<2>(DoublePendulum{}, {bad, 0.1}, {0.1, 0.2}));
    CHECK(!is_in_closed_form<2>(DoublePendulum{}, {0.3, 0.1}, {0.1, bad}));
    CHECK(!is_in_closed_form<2>(DoublePendulum{.g = bad}, {0.3, 0.1}, {0.1, 0.2}));
  }
}
