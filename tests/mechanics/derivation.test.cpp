// SPDX-License-Identifier: MIT
//
// Equations that are derived from what T and V do, in many kinds of energies, against nested duals that call T and V themselves.
#include "qdot/mechanics/derive/derivation.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "../catch2_bridge.hpp"
#include "../error_message.hpp"
#include "mechanics/shaken_chain.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"
#include "systems/solution_by_pivots.hpp"

using namespace qdot;

namespace {

// Rounding of both, times the condition of M, which is below a hundred here.
constexpr double rounded = 1e-12;

// The worst relative difference of q̈ at random states with entries of q from `low` to `high`, by acceleration() and, where they are derived, by lines; under
// applied forces, too.
template <int n, class E>
double difference_of_ways(const E& energies, double low, double high) {
  const auto system = mechanical_system<n>(energies);
  std::mt19937 random(29);
  std::uniform_real_distribution<double> position(low, high), other(-2.0, 2.0);
  double worst = 0.0;
  for (int sample = 0; sample < 20; ++sample) {
    Vector<double, n> q, v, Q, a;
    for (int i = 0; i < n; ++i) {
      q[i] = position(random);
      v[i] = other(random);
      Q[i] = other(random);
    }
    const double t = other(random);
    const Vector<double, n> general = detail::general_acceleration(system, q, v, t);
    const Vector<double, n> under_force = general + solution_by_pivots<n>(detail::kinetic_hessian<n>(energies, q, v, t), Q);
    const auto add = [&](const Vector<double, n>& found, const Vector<double, n>& expected) {
      worst = std::max(worst, (found - expected).norm() / expected.norm());
    };
    const auto by_lines = [&](const detail::DerivedLines& lines) {
      return lines.with_mass_and_rhs<n>(q.data(), v.data(), t, detail::AccelerationTo<n>{a.data(), detail::singular_pivot<double>(n)});
    };
    if (!detail::with_lines<n>(system.kept_lines(), energies, detail::AtState{q.data(), v.data(), t, n}, by_lines)) return HUGE_VAL;
    add(a, general);
    add(acceleration(system, q, v, t), general);
    add(detail::acceleration_under_force(system, q, v, t, Q, [] {}), under_force);
  }
  return worst;
}

// A top whose tip is held, in Euler's angles.
struct HeavyTop {
  double A = 1.3, C = 0.7, mgl = 1.9;
  auto T(const auto& q, const auto& v) const {
    using std::cos, std::sin;
    const auto across = v[1] * sin(q[0]), along = v[1] * cos(q[0]) + v[2];
    return 0.5 * A * (v[0] * v[0] + across * across) + 0.5 * C * along * along;
  }
  auto V(const auto& q) const {
    using std::cos;
    return mgl * cos(q[0]);
  }
};

struct SphericalPendulum {
  double m = 0.4, l = 1.7, g = 9.81;
  auto T(const auto& q, const auto& v) const {
    using std::sin;
    const auto s = sin(q[0]);
    return 0.5 * m * l * l * (v[0] * v[0] + s * s * v[1] * v[1]);
  }
  auto V(const auto& q) const {
    using std::cos;
    return -m * g * l * cos(q[0]);
  }
};

struct Kepler {
  double m = 1.3, mu = 2.1;
  auto T(const auto& v) const { return 0.5 * m * v.squaredNorm(); }
  auto V(const auto& q) const { return -m * mu / q.norm(); }
};

struct ElasticPendulum {
  double m = 0.7, k = 29.43, l = 1.2, g = 9.81;
  auto T(const auto& q, const auto& v) const { return 0.5 * m * (v[0] * v[0] + q[0] * q[0] * v[1] * v[1]); }
  auto V(const auto& q) const {
    using std::cos;
    return 0.5 * k * (q[0] - l) * (q[0] - l) - m * g * q[0] * cos(q[1]);
  }
};

struct RodAndRing {
  double M = 2.0, L = 1.5, m = 0.3, g = 9.81;
  auto T(const auto& q, const auto& v) const {
    return M * L * L / 6.0 * v[1] * v[1] + 0.5 * m * (v[0] * v[0] + q[0] * q[0] * v[1] * v[1]);
  }
  auto V(const auto& q) const {
    using std::sin;
    return (m * q[0] + 0.5 * M * L) * g * sin(q[1]);
  }
};

struct CartAndPole {
  double M = 2.0, m = 0.3, l = 1.1, g = 9.81;
  auto T(const auto& q, const auto& v) const {
    using std::cos;
    return 0.5 * (M + m) * v[0] * v[0] + m * l * v[0] * v[1] * cos(q[1]) + 0.5 * m * l * l * v[1] * v[1];
  }
  auto V(const auto& q) const {
    using std::cos;
    return m * g * l * cos(q[1]);
  }
};

// The second angle is that between the links.
struct DoublePendulumByAngleBetween {
  double m1 = 1.5, m2 = 0.4, l1 = 1.1, l2 = 0.8, g = 9.81;
  auto T(const auto& q, const auto& v) const {
    using std::cos;
    const auto w = v[0] + v[1];
    return 0.5 * (m1 + m2) * l1 * l1 * v[0] * v[0] + 0.5 * m2 * l2 * l2 * w * w + m2 * l1 * l2 * v[0] * w * cos(q[1]);
  }
  auto V(const auto& q) const {
    using std::cos;
    return -(m1 + m2) * g * l1 * cos(q[0]) - m2 * g * l2 * cos(q[0] + q[1]);
  }
};

// Terms linear in the velocities, and terms without any.
struct RotatingFrame {
  double m = 1.5, W = 0.7, k = 3.0;
  auto T(const auto& q, const auto& v) const {
    const auto vx = v[0] - W * q[1], vy = v[1] + W * q[0];
    return 0.5 * m * (vx * vx + vy * vy);
  }
  auto V(const auto& q) const { return 0.25 * k * q.squaredNorm() * q.squaredNorm(); }
};

struct ChargeInField {
  double m = 1.5, B = 0.7;
  auto T(const auto& q, const auto& v) const {
    using std::exp, std::sin;
    return 0.5 * m * v.squaredNorm() + B * q[0] * q[0] * v[1] - B * sin(q[1] * q[2]) * v[0] + exp(-q[1]) * v[2] - q[2] * q[0];
  }
  auto V(const auto& q) const { return B * q[0]; }
};

struct MovingPivot {
  double m = 1.5, l = 0.7, a = 0.3, w = 2.0, g = 9.81;
  auto T(const auto& q, const auto& v, const auto& t) const {
    using std::cos, std::sin;
    const auto vx = l * v[0] * cos(q[0]) - a * w * sin(w * t), vy = l * v[0] * sin(q[0]);
    return 0.5 * m * (vx * vx + vy * vy);
  }
  auto V(const auto& q, const auto& t) const {
    using std::cos;
    return -m * (g + t * t) * l * cos(q[0]);
  }
};

// A mass that depends on the time, and a term of T that is of the time alone.
struct Rocket {
  double m = 1.5, loss = 0.3;
  auto T(const auto& q, const auto& v, const auto& t) const {
    using std::exp;
    return 0.5 * m * exp(-loss * t) * v.squaredNorm() + t * t + 0.0 * q[0];
  }
  auto V(const auto& q) const { return m * q[0] - q[1]; }
};

struct MassOfThePosition {
  double a = 1.5, b = 0.4;
  auto T(const auto& q, const auto& v) const {
    using std::atan2, std::exp, std::log, std::sqrt, std::tanh;
    return 0.5 * sqrt(a + q[0] * q[0]) * v[0] * v[0] + 0.5 * exp(-b * q[1]) / (1.0 + q[0]) * v[1] * v[1] +
           0.5 * (2.0 + atan2(q[0], q[2])) * v[2] * v[2] + 0.1 * tanh(q[0]) * v[0] * v[1] + 0.1 / (q[1] * q[2] * q[2]) * v[1] * v[2];
  }
  auto V(const auto& q) const {
    using std::cbrt, std::log, std::pow;
    return b * log(q[0] * q[1]) + pow(q[2], 2.5) / cbrt(q[1]) + pow(a + q[0], -9.0) - hypot(q[0], q[1]);
  }
};

struct FreeAlongOne {
  double m = 1.5;
  auto T(const auto& v) const { return 0.5 * m * v[0] * v[0] + 0.25 * m * (v[1] - v[2]) * (v[1] - v[2]) + m * v[2] * v[2]; }
  auto V(const auto& q) const { return q[1] * q[1] * q[2]; }
};

// T is no quadratic form.
struct Relativistic {
  double m = 1.0, c = 3.0, k = 2.0;
  auto T(const auto& v) const {
    using std::sqrt;
    return -m * c * c * sqrt(1.0 - v.squaredNorm() / (c * c));
  }
  auto V(const auto& q) const { return 0.5 * k * q.squaredNorm() + q[0] * q[1]; }
};

// Of third and fourth order in the velocities, with a division by one.
struct QuarticInVelocities {
  double a = 0.1;
  auto T(const auto& q, const auto& v) const {
    const auto w = v[0] * v[0] + v[1] * v[1];
    return 0.5 * w + a * w * w + v[0] * v[0] / (2.0 + v[1] * v[1]) + a * q[0] * v[0] * v[0] * v[1] / (1.0 + q[1] * q[1]);
  }
  auto V(const auto& q) const { return q[0] * q[1]; }
};

// More factors than a monomial holds.
struct ManyFactors {
  double a = 1.0;
  auto T(const auto& q, const auto& v) const {
    using std::cos, std::exp, std::sin, std::tanh;
    const auto x = q[0], y = q[1];
    const auto many = exp(x) * exp(y) * cos(x) * cos(y) * sin(x) * sin(y) * x * y * tanh(x) * tanh(y) * exp(x * y) * sin(x * y);
    return 0.5 * a * (many * v[0] * v[0] + v[1] * v[1]);
  }
  auto V(const auto& q) const { return q[0] + q[1] * q[1]; }
};

struct HighPowers {
  double a = 1.0;
  auto T(const auto& q, const auto& v) const {
    using std::pow;
    return 0.5 * pow(1.0 + q[0], -12.0) * v[0] * v[0] + 0.5 * pow(q[1], 9.0) * v[1] * v[1] + 0.5 * pow(q[0] * q[1], 1.75) * v[2] * v[2];
  }
  auto V(const auto& q) const {
    using std::pow;
    return a * pow(q[0], -11.0) + pow(a * q[1] * q[1], 1.5) + pow(q[2], 70.0) + pow(q[2], -0.5) * pow(q[2], -70.0);
  }
};

// All functions of <cmath> with a derivative, in T and in V.
struct AllFunctions {
  double a = 0.7;
  auto T(const auto& q, const auto& v) const { return 0.5 * sum_of_all(a * q[0]) * v[0] * v[0] + 0.5 * v[1] * v[1]; }
  auto V(const auto& q) const { return sum_of_all(q[1] * 0.5 + 0.1) * q[0]; }

 private:
  static auto sum_of_all(const auto& x) {
    using std::acos, std::acosh, std::asin, std::asinh, std::atan, std::atan2, std::atanh, std::cbrt, std::cos, std::cosh, std::erf, std::erfc,
        std::exp, std::expm1, std::hypot, std::log, std::log1p, std::sin, std::sinh, std::sqrt, std::tan, std::tanh;
    return sin(x) + cos(x) + tan(x) + asin(x) - acos(x) + atan(x) + atan2(x, 1.0 + x * x) + atan2(2.0, x) + exp(x) + expm1(x) + log(x) + 10.0 +
           log1p(x) + sinh(x) + cosh(x) + tanh(x) + asinh(x) + acosh(2.0 + x) + atanh(x) + cbrt(x) + erf(x) + erfc(x) + hypot(x, 2.0) + sqrt(x);
  }
};

// Two bodies on a line and a spring between them; and a mass that depends on how far they are apart.
struct FarFromTheOrigin {
  double m = 1.1, k = 0.7, l = 0.3;
  auto T(const auto& q, const auto& v) const {
    const auto apart = q[1] - q[0];
    return 0.5 * m * v[0] * v[0] + 0.5 * m * (1.0 + apart * apart) * v[1] * v[1];
  }
  auto V(const auto& q) const {
    const auto longer = q[1] - q[0] - l;
    return 0.5 * k * longer * longer;
  }
};

// Many operations.
struct ManyTerms {
  double a = 0.1;
  auto T(const auto& q, const auto& v) const {
    using std::sin;
    using S = typename std::decay_t<decltype(q)>::Scalar;
    S sum(0.0);
    for (int k = 0; k < 14; ++k) sum += (2.0 + sin((1.0 + a * k) * q[0] + k * q[1])) * (v[0] + k * v[1]) * (v[0] + k * v[1]);
    return sum;
  }
  auto V(const auto& q) const { return q[0] * q[1]; }
};

// Sums and differences of parameters that stand in a row.
struct SumsInARow {
  double m = 1.0, a = 1.5, b = 2.5, c = 3.5, d = 4.5, e = 5.5;
  auto T(const auto& v) const { return 0.5 * m * v.squaredNorm(); }
  auto V(const auto& q) const {
    const auto x = q[0] * q[0], y = q[1] * q[1], z = q[2] * q[2];
    return a * x + b * y + c * y + d * x + e * z - d * z + c * q[0] * q[1] - b * q[0] * q[1];
  }
};

// A large literal beside parameters, and a small one.
struct EarthAndMoon {
  double moon = 1.0, dust = 1.0, k = 3.0;
  auto T(const auto& v) const {
    return 0.5 * 5.97e24 * v[0] * v[0] + 0.5 * moon * v[0] * v[0] + 0.5 * dust * v[1] * v[1] + 1e-26 * k * v[1] * v[1];
  }
  auto V(const auto& q) const { return k * (q[0] + q[1]); }
};

// Roots of parameters that add up to the root of another, if roots were linear.
struct Roots {
  double a = 1.0, b = 2.0;
  auto T(const auto& v) const { return 0.5 * v.squaredNorm(); }
  auto V(const auto& q) const {
    using std::sqrt;
    const auto x = 1.0 + q[0] * q[0];
    return sqrt(a * x) + sqrt(b * x) + sqrt(a * x + b * x) + 2.0 * sqrt(a * (1.0 + q[1] * q[1])) + sqrt(a * (2.0 + 2.0 * q[1] * q[1]));
  }
};

// Roots and powers of literals, functions of what turns out to be a parameter.
struct Constants {
  double a = 1.0;
  auto T(const auto& q, const auto& v) const {
    using std::sin, std::sqrt;
    return 0.5 * sqrt(2.0 * (1.0 + q[0] * q[0])) * v[0] * v[0] + 0.5 * (1.0 + sin(q[0] - q[0] + a)) * v[1] * v[1];
  }
  auto V(const auto& q) const {
    using std::pow;
    return pow(3.0 * q[0], -1.5) + pow(5.0 * q[1], -3.0) + pow(q[0] - q[0] + 2.0, 0.25) * q[1];
  }
};

struct DoublePendulum {
  double m1 = 1.5, m2 = 0.4, l1 = 1.1, l2 = 0.8, g = 9.81;
  auto T(const auto& q, const auto& v) const {
    using std::cos;
    return 0.5 * (m1 + m2) * l1 * l1 * v[0] * v[0] + 0.5 * m2 * l2 * l2 * v[1] * v[1] + m2 * l1 * l2 * v[0] * v[1] * cos(q[0] - q[1]);
  }
  auto V(const auto& q) const {
    using std::cos;
    return -(m1 + m2) * g * l1 * cos(q[0]) - m2 * g * l2 * cos(q[1]);
  }
};

// The first mass matters only relative to the second.
struct TwoMasses {
  double m = 1.0, M = 1.0;
  auto T(const auto& v) const { return 0.5 * m * v[0] * v[0] + 0.5 * M * (v[0] + v[1]) * (v[0] + v[1]); }
  auto V(const auto& q) const { return q[0] + 2.0 * q[1] * q[1]; }
};

struct OneWithoutMass {
  double m = 1.0;
  auto T(const auto& v) const { return 0.5 * m * v[0] * v[0]; }
  auto V(const auto& q) const { return q[0] * q[1]; }
};

// A root of what has the sign of a parameter.
struct RootOfSign {
  double m = 1.0;
  auto T(const auto& v) const { return 0.5 * v.squaredNorm(); }
  auto V(const auto& q) const {
    using std::sqrt;
    return sqrt(m * q[0]);
  }
};

}  // namespace

TEST_CASE("derived equations of motion are those of T and V: tops, carts, and pendulums by the angle between them") {
  CHECK(difference_of_ways<3>(HeavyTop{.A = 0.9, .C = 1.1, .mgl = 0.3}, 0.5, 2.5) < rounded);
  CHECK(difference_of_ways<2>(CartAndPole{.M = 1.2, .m = 0.4, .l = 0.6}, -2.0, 2.0) < rounded);
  CHECK(difference_of_ways<2>(DoublePendulumByAngleBetween{.m1 = 0.4, .m2 = 1.3, .l1 = 0.9, .l2 = 1.4}, -2.0, 2.0) < rounded);
  CHECK(difference_of_ways<3>(FreeAlongOne{.m = 0.3}, -2.0, 2.0) < rounded);
}

TEST_CASE("derived equations of motion are those of T and V: pendulums and orbits") {
  CHECK(difference_of_ways<2>(SphericalPendulum{.m = 2.0, .l = 0.6}, 0.5, 2.5) < rounded);
  CHECK(difference_of_ways<2>(Kepler{.m = 0.2, .mu = 3.0}, 0.5, 1.5) < rounded);
  CHECK(difference_of_ways<2>(ElasticPendulum{.m = 0.2, .k = 3.0}, 0.5, 2.5) < rounded);
  CHECK(difference_of_ways<2>(RodAndRing{.M = 0.2, .L = 0.4}, -2.5, 2.5) < rounded);
}

TEST_CASE("derived equations of motion are those of T and V: terms linear in the velocities, without them, and of the time") {
  CHECK(difference_of_ways<2>(RotatingFrame{.m = 0.4, .W = -0.9}, -2.0, 2.0) < rounded);
  CHECK(difference_of_ways<3>(ChargeInField{.m = 0.4, .B = 1.4}, -1.0, 1.0) < rounded);
  CHECK(difference_of_ways<1>(MovingPivot{.m = 0.4, .l = 1.2, .a = 0.1}, -2.0, 2.0) < rounded);
  CHECK(difference_of_ways<2>(Rocket{.m = 0.4, .loss = 0.1}, -2.0, 2.0) < rounded);
  CHECK(difference_of_ways<2>(ShakenChain{.m = 0.3, .l = 2.1, .g = 1.62, .w = 0.7}, -2.0, 2.0) < rounded);
}

TEST_CASE("derived equations of motion are those of T and V: masses that depend on the position in many ways") {
  CHECK(difference_of_ways<3>(MassOfThePosition{.a = 0.9, .b = 0.7}, 0.5, 1.5) < rounded);
}

TEST_CASE("derived equations of motion are those of T and V: T that is no quadratic form in the velocities") {
  CHECK(difference_of_ways<2>(Relativistic{.m = 0.3, .c = 4.0}, -1.0, 1.0) < rounded);
  CHECK(difference_of_ways<2>(QuarticInVelocities{.a = 0.03}, -0.5, 0.5) < rounded);
}

TEST_CASE("derived equations of motion are those of T and V: many factors, many terms, high powers, all functions") {
  CHECK(difference_of_ways<2>(ManyFactors{.a = 1.4}, 0.3, 1.2) < rounded);
  CHECK(difference_of_ways<2>(ManyTerms{.a = 0.2}, -1.0, 1.0) < rounded);
  CHECK(difference_of_ways<3>(HighPowers{.a = 1.4}, 0.8, 1.2) < rounded);
  CHECK(difference_of_ways<2>(AllFunctions{.a = 0.6}, 0.2, 0.9) < rounded);
}

TEST_CASE("bodies that are near each other and far from the origin lose no digits in derived equations") {
  const FarFromTheOrigin system{.m = 1.3, .k = 0.9, .l = 0.01};
  for (const double far : {1e3, 1e6, 1e9}) {
    const Vector<double, 2> q(far + 0.3, far + 0.3 + 0.0625), v(0.4, 0.5);
    const Vector<double, 2> a = acceleration(mechanical_system<2>(system), q, v);
    // By hand, of the distance, which is exact.
    const double d = q[1] - q[0], force = -system.k * (d - system.l), mass = system.m * (1.0 + d * d);
    const double a0 = (-force - system.m * d * v[1] * v[1]) / system.m;
    const double a1 = (force + system.m * d * v[1] * v[1] - 2.0 * system.m * d * (v[1] - v[0]) * v[1]) / mass;
    CHECK_THAT(a[0], WithinRel(a0, rounded));
    CHECK_THAT(a[1], WithinRel(a1, rounded));
  }
}

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

TEST_CASE("a state without a mass matrix has no accelerations, and one beside it has") {
  const Vector<double, 2> v(0.1, 0.2);
  CHECK_THROWS_AS(acceleration(mechanical_system<3>(HeavyTop{}), Vector<double, 3>(0.0, 0.2, 0.3), Vector<double, 3>(0.1, 0.2, 4.0)), MassMatrixError);
  CHECK_THROWS_AS(acceleration(mechanical_system<2>(OneWithoutMass{}), Vector<double, 2>(1.0, 2.0), v), MassMatrixError);
  CHECK_THROWS_AS(acceleration(mechanical_system<2>(DoublePendulum{.m1 = 0.0}), Vector<double, 2>(0.3, 0.3), v), MassMatrixError);
  CHECK(acceleration(mechanical_system<2>(DoublePendulum{.m1 = 0.0}), Vector<double, 2>(0.3, 0.8), v).allFinite());
  CHECK(acceleration(mechanical_system<2>(DoublePendulum{.m1 = 0.0}), Vector<double, 2>(0.3, 0.3 + 1e-5), v).allFinite());
}

TEST_CASE("a refused mass matrix is called zero or negative as it is") {
  const Vector<double, 2> q(0.3, 0.8), v(0.1, 0.2);
  const auto complaint = [&](const DoublePendulum& energies) {
    return error_message([&] { (void)acceleration(mechanical_system<2>(energies), q, v); });
  };
  CHECK(complaint({.m1 = 0.0, .m2 = 0.0}).find("all of it is zero") != std::string::npos);
  CHECK(complaint({.l2 = 0.0}).find("no kinetic energy") != std::string::npos);
  CHECK(complaint({.m1 = -3.0}).find("no positive kinetic energy") != std::string::npos);
}

TEST_CASE("parameters and positions that are not finite are refused, never handed on") {
  const Vector<double, 2> q(0.3, 0.8), v(0.1, 0.2);
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    CHECK_THROWS_AS(acceleration(mechanical_system<2>(DoublePendulum{}), Vector<double, 2>(bad, 0.1), v), NonFinite);
    CHECK_THROWS_AS(acceleration(mechanical_system<2>(DoublePendulum{}), q, Vector<double, 2>(0.1, bad)), NonFinite);
    CHECK_THROWS_AS(acceleration(mechanical_system<2>(DoublePendulum{.g = bad}), q, v), NonFinite);
  }
}

TEST_CASE("masses that are zero, negative, not a number, or lost beside others have no accelerations") {
  const Vector<double, 2> q(0.3, 0.8), v(0.1, 0.2);
  for (const double m : {0.0, -1.0, std::nan(""), 1e-17, -1e-17}) {
    CHECK_THROWS_AS(acceleration(mechanical_system<2>(TwoMasses{.m = m, .M = 1.0}), q, v), Error);
    CHECK_THROWS_AS(acceleration(mechanical_system<2>(OneWithoutMass{.m = m}), q, v), Error);
  }
  CHECK_THROWS_AS(acceleration(mechanical_system<2>(TwoMasses{.m = 1.0, .M = 0.0}), q, v), MassMatrixError);
  CHECK_THROWS_AS(acceleration(mechanical_system<2>(DoublePendulum{.l2 = 0.0}), q, v), MassMatrixError);
  CHECK_THROWS_AS(acceleration(mechanical_system<2>(DoublePendulum{.m1 = 1.0, .m2 = -0.5}), q, v), MassMatrixError);
  CHECK(acceleration(mechanical_system<2>(TwoMasses{.m = 1e-3, .M = 1.0}), q, v).allFinite());
}

TEST_CASE("a root of a product with negative factors is taken") {
  const auto system = mechanical_system<1>(RootOfSign{.m = -2.0});
  const Vector<double, 1> q(-0.5), v(0.1);
  CHECK_THAT(acceleration(system, q, v)[0], WithinRel(1.0, rounded));  // −m/(2√(m q))
}
