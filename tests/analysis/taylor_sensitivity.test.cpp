// SPDX-License-Identifier: MIT
#include "qdot/analysis/taylor_sensitivity.hpp"

#include <cmath>

#include "catch2_bridge.hpp"
#include "qdot/effects/dissipation.hpp"
#include "scenes/double_pendulum.hpp"

using qdot::sensitivities;
using qdot::State;
using qdot::Taylor;

namespace {

const qdot::Options fine{.rtol = 1e-14, .atol = 1e-15};

// An oscillator of mass m and stiffness k, pulled by g.
template <class S>
struct Oscillator {
  S m, k, g;
  auto T(const auto& v) const { return 0.5 * m * v[0] * v[0]; }
  auto V(const auto& q) const { return 0.5 * k * q[0] * q[0] + m * g * q[0]; }
};
const auto oscillator = [](const auto& p) { return Oscillator<std::remove_cvref_t<decltype(p[0])>>{p[0], p[1], p[2]}; };

}  // namespace

// Computed with heyoka's variational equations in long double, as in sensitivity.test.cpp.
TEST_CASE("by power series the double pendulum's tangent at t = 3 has the digits of a computation in extended precision") {
  constexpr double error = 2e-12;  // roundings of some forty steps, which the motion amplifies
  Eigen::Matrix4d expected;
  expected << 0.42512535360011335, 0.32234325900511527, -0.11480303301727812, -0.32188377823700566,  //
      0.35375523822508861, -0.12147143371945361, 0.03465925719707716, 0.61006975762812077,           //
      3.55481773398585877, 2.52890401856926854, 0.87795461024674466, -0.09322081715396367,           //
      2.95323559692079771, -0.59978990735865972, 0.20286440439106009, 1.95089499890557590;
  const auto system = qdot::mechanical_system<2>(qdot::scenes::DoublePendulum{});
  const auto s = sensitivities(system, State<2>{0.0, {1.7, 1.7}, {0, 0}}, 3.0, Taylor{}, fine);
  REQUIRE(s.completed());
  CHECK((s.Phi - expected).cwiseAbs().maxCoeff() < error);
  CHECK(s.Phi_at(0.0).isIdentity(0.0));
}

TEST_CASE("by power series an oscillator depends on its start, mass, stiffness and pull as the closed form says") {
  constexpr double error = 1e-13;  // some rounding units of numbers below ten
  const Eigen::Vector3d p(2.0, 3.0, 0.7);
  const double t = 2.0, w = std::sqrt(p[1] / p[0]), c = std::cos(w * t), d = std::sin(w * t), x0 = 0.4, v0 = -0.3, sag = p[0] * p[2] / p[1];
  const auto s = sensitivities(oscillator, p, State<1>{0.0, {x0}, {v0}}, t, Taylor{}, fine);
  REQUIRE(s.completed());
  REQUIRE(s.Phi.cols() == 5);
  // x = (x₀ + sag) cos wt + v₀/w sin wt − sag
  const double by_w = -(x0 + sag) * t * d - v0 / (w * w) * d + v0 / w * t * c, by_sag = c - 1.0;
  CHECK_THAT(s.Phi(0, 0), WithinAbs(c, error));
  CHECK_THAT(s.Phi(0, 1), WithinAbs(d / w, error));
  CHECK_THAT(s.Phi(1, 0), WithinAbs(-w * d, error));
  CHECK_THAT(s.Phi(0, 2), WithinAbs(by_w * -w / (2 * p[0]) + by_sag * sag / p[0], error));
  CHECK_THAT(s.Phi(0, 3), WithinAbs(by_w * w / (2 * p[1]) - by_sag * sag / p[1], error));
  CHECK_THAT(s.Phi(0, 4), WithinAbs(by_sag * p[0] / p[1], error));
}

TEST_CASE("by power series a damped oscillator depends on its start as the closed form says") {
  constexpr double error = 1e-13;  // some rounding units
  const double t = 2.0, g = 0.25, w = std::sqrt(1.5 - g * g);  // m = 2, k = 3, c = 2 m g = 1
  const auto damped = qdot::scene(qdot::mechanical_system<1>(oscillator(Eigen::Vector3d(2.0, 3.0, 0.7))), qdot::viscous_damping(qdot::Vector<double, 1>(1.0)));
  const auto s = sensitivities(damped, State<1>{0.0, {0.4}, {-0.3}}, t, Taylor{}, fine);
  REQUIRE(s.completed());
  CHECK_THAT(s.Phi(0, 0), WithinAbs(std::exp(-g * t) * (std::cos(w * t) + g / w * std::sin(w * t)), error));
  CHECK_THAT(s.Phi(0, 1), WithinAbs(std::exp(-g * t) * std::sin(w * t) / w, error));
}

TEST_CASE("by power series a ball that bounces once depends on its start and g as the closed form says") {
  constexpr double error = 1e-11;  // the saltation is differenced to some twelve digits
  const double g = 9.8, h = 5.0, e = 0.8, end = 1.5;
  const auto bounce = [](State<1>& s) { s.qdot[0] *= -0.8; };
  const auto s = sensitivities(oscillator, Eigen::Vector3d(1.0, 0.0, g), State<1>{0.0, {h}, {0.0}}, end, Taylor{}, fine,
                               qdot::events(qdot::event("floor", [](const auto& q) { return q[0]; }).falling().action(bounce)));
  INFO(s.message);
  REQUIRE(s.completed());
  REQUIRE(s.events.size() == 1);
  // z = e g t₁ (t − t₁) − ½ g (t − t₁)² with t₁ = √(2h/g)
  const double t1 = std::sqrt(2 * h / g), by_t1 = e * g * (end - 2 * t1) + g * (end - t1);
  CHECK_THAT(s.Phi(0, 0), WithinAbs(by_t1 * t1 / (2 * h), error));
  CHECK_THAT(s.Phi(0, 4), WithinAbs(by_t1 * -t1 / (2 * g) + e * t1 * (end - t1) - 0.5 * (end - t1) * (end - t1), error));
}
