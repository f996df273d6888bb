// SPDX-License-Identifier: MIT
//
// Scales: masses, springs, coordinates and times of very different size. All are two coordinates with constant M and K, so that the
// motion is known: M q̈ + K q = 0.

#include <cmath>
#include <numbers>

#include "catch2_bridge.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"

using namespace qdot;
using Eigen::Matrix2d;
using Eigen::Vector2d;

namespace {

const Options fine{.rtol = 1e-12, .atol = 1e-14};
constexpr double fine_error = 1e-11;  // relative, after ten periods at these tolerances; 7e-13 was seen, 7e-12 with a full M at 1e9
constexpr double stiff_error = 5e-9;  // after 225 periods at rtol = 1e-11; 7e-10 was seen
constexpr double coarse_error = 1e-9; // after three periods at rtol = 1e-10; 1e-10 was seen
constexpr double rounding = 1e-13;    // of a momentum that stays zero; 3e-15 was seen

struct Linear {
  Matrix2d M, K;
  auto T(const auto& v) const { return 0.5 * (M(0, 0) * v[0] * v[0] + M(1, 1) * v[1] * v[1]) + M(0, 1) * v[0] * v[1]; }
  auto V(const auto& q) const { return 0.5 * (K(0, 0) * q[0] * q[0] + K(1, 1) * q[1] * q[1]) + K(0, 1) * q[0] * q[1]; }
};
auto linear(const Matrix2d& M, const Matrix2d& K) { return mechanical_system<2>(Linear{M, K}); }
Matrix2d symmetric(double a, double b, double c) { return (Matrix2d() << a, b, b, c).finished(); }

TEST_CASE("two masses on a spring swing about their centre of mass, at any ratio of the masses") {
  // k = the reduced mass, so that ω = 1; the spring is stretched by 1, and the centre of mass rests at 0.
  for (double ratio = 1e-9; ratio < 2e9; ratio *= 1e3) {
    const double m1 = 1.0, m2 = ratio, mu = m1 * m2 / (m1 + m2), periods = 10 * 2 * std::numbers::pi;
    CAPTURE(ratio);
    {
      // x₁ and x₂: each mass has its own amplitude, and its own tolerance.
      const Vector2d amplitude(-m2 / (m1 + m2), m1 / (m1 + m2));
      const auto run = simulate(linear(symmetric(m1, 0.0, m2), symmetric(mu, -mu, mu)), State<2>{0.0, amplitude, Vector2d(0, 0)}, periods,
                                Dop853{}, {.rtol = 1e-12, .atol = {1e-12 * -amplitude[0], 1e-12 * amplitude[1], 1e-12 * -amplitude[0], 1e-12 * amplitude[1]}});
      REQUIRE(run.completed());
      CHECK((run.state().q - amplitude).cwiseQuotient(amplitude).norm() < fine_error);
      CHECK(std::abs(m1 * run.state().qdot[0] + m2 * run.state().qdot[1]) / mu < rounding);
    }
    {
      // x₁ and the stretch: M is full, and as badly conditioned as the ratio says.
      const auto run = simulate(linear(symmetric(m1 + m2, m2, m2), symmetric(0.0, 0.0, mu)), State<2>{0.0, Vector2d(-m2 / (m1 + m2), 1.0), Vector2d(0, 0)},
                                periods, Dop853{}, fine);
      INFO(run.message);
      REQUIRE(run.completed());
      CHECK(std::abs(run.state().q[1] - 1.0) < fine_error);
    }
  }
}

TEST_CASE("a stiff spring in a row with a soft one swings in both modes") {
  // Soft spring k = 1 to the wall, stiff spring k between two unit masses.
  for (double k = 1e8; k < 2e12; k *= 1e2) {
    const long double a = 1.0L + k, b = -k, d = k, half = (a - d) / 2, root = std::sqrt(half * half + b * b);
    const long double fast = (a + d) / 2 + root, slow = (a * d - b * b) / fast;  // ω²
    const double angle = static_cast<double>(std::atan2(-half + root, -b));       // of the slow mode's shape
    const Vector2d slow_shape(std::cos(angle), std::sin(angle)), fast_shape(-std::sin(angle), std::cos(angle));
    const double end = 1e3 / std::sqrt(k), speed = std::sqrt(k);  // 1414 rad of the fast mode
    const auto at = [&](double t) -> Vector2d {
      return slow_shape * std::cos(static_cast<double>(std::sqrt(slow)) * t) + 0.1 * fast_shape * std::cos(static_cast<double>(std::sqrt(fast)) * t);
    };
    const auto run = simulate(linear(Matrix2d::Identity(), symmetric(1.0 + k, -k, k)), State<2>{0.0, at(0.0), Vector2d(0, 0)}, end, Dop853{},
                              {.rtol = 1e-11, .atol = {1e-12, 1e-12, 1e-12 * speed, 1e-12 * speed}});
    CAPTURE(k);
    INFO(run.message);
    REQUIRE(run.completed());
    CHECK((run.state().q - at(end)).norm() < stiff_error);
  }
}

TEST_CASE("a coordinate of size 1e12 does not spoil its neighbour of size one") {
  for (double size = 1e6; size < 2e12; size *= 1e3) {
    const auto run = simulate(linear(Matrix2d::Identity(), symmetric(1.0, 0.0, 0.0)), State<2>{0.0, Vector2d(1.0, size), Vector2d(0.0, size)}, 20.0,
                              Dop853{}, fine);
    CAPTURE(size);
    REQUIRE(run.completed());
    CHECK(std::abs(run.state().q[0] - std::cos(20.0)) < fine_error);
    CHECK(std::abs(run.state().q[1] / (21.0 * size) - 1.0) < rounding);
  }
}

TEST_CASE("far from t = 0 the clock has few digits, and the motion keeps its own") {
  constexpr double t0 = 1e9;  // rounded to 1.2e-7
  for (double omega = 1.0; omega < 2e8; omega *= 10) {  // the last way is two units long
    const double end = t0 + 20.0 / omega, passed = end - t0;
    const auto run = simulate(linear(Matrix2d::Identity(), symmetric(omega * omega, 0.0, 1.0)), State<2>{t0, Vector2d(1.0, 0.0), Vector2d(0, 0)}, end,
                              Dop853{}, {.rtol = 1e-10, .atol = 1e-12});
    CAPTURE(omega);
    INFO(run.message);
    REQUIRE(run.completed());
    CHECK(std::abs(run.state().q[0] - std::cos(omega * passed)) < coarse_error);
  }
}

}  // namespace
