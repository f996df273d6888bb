// SPDX-License-Identifier: MIT
//
// Equations that the compiler has derived, against nested duals: systems of few coordinates.
#include "catch2_bridge.hpp"

#include <cmath>

#include "mechanics/closed_form_difference.hpp"
#include "mechanics/shaken_chain.hpp"

using namespace qdot;

namespace {

// Rounding of both, times the condition of M, which is below a hundred here.
constexpr double rounded = 1e-12;

struct SphericalPendulum {
  double m = 0.4, l = 1.7, g = 9.81;
  constexpr auto T(const auto& q, const auto& v) const {
    using std::sin;
    const auto s = sin(q[0]);
    return 0.5 * m * l * l * (v[0] * v[0] + s * s * v[1] * v[1]);
  }
  constexpr auto V(const auto& q) const {
    using std::cos;
    return -m * g * l * cos(q[0]);
  }
};

struct Kepler {
  double m = 1.3, mu = 2.1;
  constexpr auto T(const auto& v) const { return 0.5 * m * v.squaredNorm(); }
  constexpr auto V(const auto& q) const { return -m * mu / q.norm(); }
};

struct ElasticPendulum {
  double m = 0.7, k = 29.43, l = 1.2, g = 9.81;
  constexpr auto T(const auto& q, const auto& v) const { return 0.5 * m * (v[0] * v[0] + q[0] * q[0] * v[1] * v[1]); }
  constexpr auto V(const auto& q) const {
    using std::cos;
    return 0.5 * k * (q[0] - l) * (q[0] - l) - m * g * q[0] * cos(q[1]);
  }
};

struct RodAndRing {
  double M = 2.0, L = 1.5, m = 0.3, g = 9.81;
  constexpr auto T(const auto& q, const auto& v) const {
    return M * L * L / 6.0 * v[1] * v[1] + 0.5 * m * (v[0] * v[0] + q[0] * q[0] * v[1] * v[1]);
  }
  constexpr auto V(const auto& q) const {
    using std::sin;
    return (m * q[0] + 0.5 * M * L) * g * sin(q[1]);
  }
};

struct CartAndPole {
  double M = 2.0, m = 0.3, l = 1.1, g = 9.81;
  constexpr auto T(const auto& q, const auto& v) const {
    using std::cos;
    return 0.5 * (M + m) * v[0] * v[0] + m * l * v[0] * v[1] * cos(q[1]) + 0.5 * m * l * l * v[1] * v[1];
  }
  constexpr auto V(const auto& q) const {
    using std::cos;
    return m * g * l * cos(q[1]);
  }
};

// The second angle is that between the links.
struct DoublePendulumByAngleBetween {
  double m1 = 1.5, m2 = 0.4, l1 = 1.1, l2 = 0.8, g = 9.81;
  constexpr auto T(const auto& q, const auto& v) const {
    using std::cos;
    const auto w = v[0] + v[1];
    return 0.5 * (m1 + m2) * l1 * l1 * v[0] * v[0] + 0.5 * m2 * l2 * l2 * w * w + m2 * l1 * l2 * v[0] * w * cos(q[1]);
  }
  constexpr auto V(const auto& q) const {
    using std::cos;
    return -(m1 + m2) * g * l1 * cos(q[0]) - m2 * g * l2 * cos(q[0] + q[1]);
  }
};

// Terms linear in the velocities, and terms without any.
struct RotatingFrame {
  double m = 1.5, W = 0.7, k = 3.0;
  constexpr auto T(const auto& q, const auto& v) const {
    const auto vx = v[0] - W * q[1], vy = v[1] + W * q[0];
    return 0.5 * m * (vx * vx + vy * vy);
  }
  constexpr auto V(const auto& q) const { return 0.25 * k * q.squaredNorm() * q.squaredNorm(); }
};

struct ChargeInField {
  double m = 1.5, B = 0.7;
  constexpr auto T(const auto& q, const auto& v) const {
    using std::exp, std::sin;
    return 0.5 * m * v.squaredNorm() + B * q[0] * q[0] * v[1] - B * sin(q[1] * q[2]) * v[0] + exp(-q[1]) * v[2] - q[2] * q[0];
  }
  constexpr auto V(const auto& q) const { return B * q[0]; }
};

struct MovingPivot {
  double m = 1.5, l = 0.7, a = 0.3, w = 2.0, g = 9.81;
  constexpr auto T(const auto& q, const auto& v, const auto& t) const {
    using std::cos, std::sin;
    const auto vx = l * v[0] * cos(q[0]) - a * w * sin(w * t), vy = l * v[0] * sin(q[0]);
    return 0.5 * m * (vx * vx + vy * vy);
  }
  constexpr auto V(const auto& q, const auto& t) const {
    using std::cos;
    return -m * (g + t * t) * l * cos(q[0]);
  }
};

// A mass that depends on the time, and a term of T that is of the time alone.
struct Rocket {
  double m = 1.5, loss = 0.3;
  constexpr auto T(const auto& q, const auto& v, const auto& t) const {
    using std::exp;
    return 0.5 * m * exp(-loss * t) * v.squaredNorm() + t * t + 0.0 * q[0];
  }
  constexpr auto V(const auto& q) const { return m * q[0] - q[1]; }
};

struct MassOfThePosition {
  double a = 1.5, b = 0.4;
  constexpr auto T(const auto& q, const auto& v) const {
    using std::atan2, std::exp, std::log, std::sqrt, std::tanh;
    return 0.5 * sqrt(a + q[0] * q[0]) * v[0] * v[0] + 0.5 * exp(-b * q[1]) / (1.0 + q[0]) * v[1] * v[1] +
           0.5 * (2.0 + atan2(q[0], q[2])) * v[2] * v[2] + 0.1 * tanh(q[0]) * v[0] * v[1] + 0.1 / (q[1] * q[2] * q[2]) * v[1] * v[2];
  }
  constexpr auto V(const auto& q) const {
    using std::cbrt, std::log, std::pow;
    return b * log(q[0] * q[1]) + pow(q[2], 2.5) / cbrt(q[1]) + pow(a + q[0], -9.0) - hypot(q[0], q[1]);
  }
};

struct FreeAlongOne {
  double m = 1.5;
  constexpr auto T(const auto& v) const { return 0.5 * m * v[0] * v[0] + 0.25 * m * (v[1] - v[2]) * (v[1] - v[2]) + m * v[2] * v[2]; }
  constexpr auto V(const auto& q) const { return q[1] * q[1] * q[2]; }
};

constexpr bool under_forces = true;  // where coordinates are eliminated, one is left, or some are: forces do not look at T and V

}  // namespace

TEST_CASE("derived equations of motion are those of T and V: coordinates that are eliminated") {
  CHECK(difference_of_ways<3, under_forces>(HeavyTop{.A = 0.9, .C = 1.1, .mgl = 0.3}, 0.5, 2.5) < rounded);
  CHECK(difference_of_ways<2, under_forces>(CartAndPole{.M = 1.2, .m = 0.4, .l = 0.6}, -2.0, 2.0) < rounded);
  CHECK(difference_of_ways<2>(DoublePendulumByAngleBetween{.m1 = 0.4, .m2 = 1.3, .l1 = 0.9, .l2 = 1.4}, -2.0, 2.0) < rounded);
  CHECK(difference_of_ways<3, under_forces>(FreeAlongOne{.m = 0.3}, -2.0, 2.0) < rounded);
}

TEST_CASE("derived equations of motion are those of T and V: pendulums and orbits") {
  CHECK(difference_of_ways<2>(SphericalPendulum{.m = 2.0, .l = 0.6}, 0.5, 2.5) < rounded);
  CHECK(difference_of_ways<2, under_forces>(Kepler{.m = 0.2, .mu = 3.0}, 0.5, 1.5) < rounded);
  CHECK(difference_of_ways<2>(ElasticPendulum{.m = 0.2, .k = 3.0}, 0.5, 2.5) < rounded);
  CHECK(difference_of_ways<2>(RodAndRing{.M = 0.2, .L = 0.4}, -2.5, 2.5) < rounded);
}

TEST_CASE("derived equations of motion are those of T and V: terms linear in the velocities, without them, and of the time") {
  CHECK(difference_of_ways<2>(RotatingFrame{.m = 0.4, .W = -0.9}, -2.0, 2.0) < rounded);
  CHECK(difference_of_ways<3, under_forces>(ChargeInField{.m = 0.4, .B = 1.4}, -1.0, 1.0) < rounded);
  CHECK(difference_of_ways<1, under_forces>(MovingPivot{.m = 0.4, .l = 1.2, .a = 0.1}, -2.0, 2.0) < rounded);
  CHECK(difference_of_ways<2>(Rocket{.m = 0.4, .loss = 0.1}, -2.0, 2.0) < rounded);
  CHECK(difference_of_ways<2>(ShakenChain{.m = 0.3, .l = 2.1, .g = 1.62, .w = 0.7}, -2.0, 2.0) < rounded);
}

TEST_CASE("derived equations of motion are those of T and V: masses that depend on the position in many ways") {
  CHECK(difference_of_ways<3, under_forces>(MassOfThePosition{.a = 0.9, .b = 0.7}, 0.5, 1.5) < rounded);
}
