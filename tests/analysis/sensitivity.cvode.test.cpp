// SPDX-License-Identifier: MIT
//
// Derivatives of stiff motions, by CVODE.
#include "qdot/analysis/sensitivity.hpp"

#include <cmath>

#include "catch2_bridge.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/integrate/cvode.hpp"

using qdot::State;

namespace {

constexpr double settled = 1e-7;  // of a tolerance of 1e-10, over some hundred steps of BDF

// A spring of stiffness k in a fluid of friction c ≫ √k, of unit mass: rates s± = (−c ± √(c² − 4k))/2, one of them some c/k² times as fast.
template <class S>
struct Spring {
  S k;
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const { return 0.5 * k * q[0] * q[0]; }
};

}  // namespace

TEST_CASE("a creeping spring depends on stiffness, friction and start as the closed form says, and BDF takes few steps for it") {
  constexpr double k = 3.0, c = 2e4, q0 = 1.5, T = 4000.0;
  const auto family = [](const Eigen::Vector2d& p) {
    return qdot::problem(scene(qdot::mechanical_system<1>(Spring<double>{p[0]}), qdot::viscous_damping(qdot::Vector<double, 1>(p[1]))),
                         State<1>{0.0, {q0}, {0.0}});
  };
  const auto s = sensitivities(family, Eigen::Vector2d(k, c), T, qdot::CvodeBdf{}, {.rtol = 1e-10, .atol = 1e-12}, {.start = true});
  INFO(s.message);
  REQUIRE(s.completed());
  CHECK(s.run.statistics.steps < 2000);  // the fast rate alone would ask explicit methods for c T/6 = 13 million

  using D = qdot::Dual<double, 4>;
  const auto x = [](double value, int j) { return D::variable(value, j); };
  const D place = x(q0, 0), speed = x(0.0, 1), stiff = x(k, 2), friction = x(c, 3);
  const D root = sqrt(friction * friction - 4.0 * stiff), fast = -0.5 * (friction + root), slow = stiff / fast;  // s₊ s₋ = k
  const D end = (speed - fast * place) / root * exp(slow * T);  // of the fast one nothing is left
  CHECK_THAT(s.y[0], WithinAbs(end.value, settled));
  for (std::size_t j = 0; j < 4; ++j) {
    const double expected = end.tangent[j];
    CHECK_THAT(s.Phi(0, static_cast<Eigen::Index>(j)), WithinAbs(expected, settled * std::max(1.0, std::abs(expected))));
  }
}

TEST_CASE("through an event BDF and Adams have the derivatives of the closed form") {
  const auto ball = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 9.81 * q[0]; });
  const auto floor = qdot::event("floor", [](const auto& q) { return q[0]; }).falling().action([](State<1>& s) { s.qdot *= -0.8; });
  const double h = 1.0, g = 9.81, T = 0.7, t1 = std::sqrt(2 * h / g);  // y = 0.8 g t₁ (T − t₁) − g (T − t₁)²/2, dt₁/dh = 1/(g t₁)
  const double by_h = (0.8 * g * (T - 2 * t1) + g * (T - t1)) / (g * t1);
  const auto check = [&](const auto& method) {
    const auto s = sensitivities(ball, State<1>{0.0, {h}, {0.0}}, T, method, {.rtol = 1e-10, .atol = 1e-12}, events(floor));
    INFO(s.message);
    REQUIRE(s.completed());
    CHECK_THAT(s.Phi(0, 0), WithinAbs(by_h, settled));
    REQUIRE(s.events.size() == 1);
    CHECK_THAT(s.events[0].time[0], WithinAbs(1 / (g * t1), settled));
  };
  check(qdot::CvodeBdf{});
  check(qdot::CvodeAdams{});
}
