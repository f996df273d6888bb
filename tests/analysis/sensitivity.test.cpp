// SPDX-License-Identifier: MIT
#include "qdot/analysis/sensitivity.hpp"

#include <cmath>
#include <numbers>

#include "catch2_bridge.hpp"
#include "qdot/effects/contact.hpp"
#include "scenes/double_pendulum.hpp"

using qdot::Dop853;
using qdot::event;
using qdot::events;
using qdot::Options;
using qdot::sensitivities;
using qdot::State;

namespace {

const Options fine{.rtol = 1e-13, .atol = 1e-14};

template <class S>
struct DoublePendulum {
  S m1, m2, l1, l2, g;
  auto T(const auto& q, const auto& v) const {
    using std::cos;
    return 0.5 * (m1 + m2) * l1 * l1 * v[0] * v[0] + 0.5 * m2 * l2 * l2 * v[1] * v[1] + m2 * l1 * l2 * v[0] * v[1] * cos(q[0] - q[1]);
  }
  auto V(const auto& q) const {
    using std::cos;
    return -(m1 + m2) * g * l1 * cos(q[0]) - m2 * g * l2 * cos(q[1]);
  }
};

}  // namespace

// Computed with heyoka's variational equations in long double; all digits shown there agree between 1e-18 and 1e-20 as tolerance.
TEST_CASE("the double pendulum's tangent at t = 3 has the digits of a computation in extended precision") {
  constexpr double error = 2e-11;
  Eigen::Matrix4d expected;
  expected << 0.42512535360011335, 0.32234325900511527, -0.11480303301727812, -0.32188377823700566,  //
      0.35375523822508861, -0.12147143371945361, 0.03465925719707716, 0.61006975762812077,           //
      3.55481773398585877, 2.52890401856926854, 0.87795461024674466, -0.09322081715396367,           //
      2.95323559692079771, -0.59978990735865972, 0.20286440439106009, 1.95089499890557590;
  const auto system = qdot::mechanical_system<2>(qdot::scenes::DoublePendulum{});
  const auto s = sensitivities(system, State<2>{0.0, {1.7, 1.7}, {0, 0}}, 3.0, Dop853{}, fine);
  REQUIRE(s.completed());
  INFO((s.Phi - expected).cwiseAbs().maxCoeff());
  CHECK((s.Phi - expected).cwiseAbs().maxCoeff() < error);
  CHECK(s.Phi_at(0.0).isIdentity(0.0));
}

TEST_CASE("a ball that bounces three times depends on g, e, h and the end as the closed form says") {
  constexpr double error = 1e-10;
  const Eigen::Vector3d p(9.8, 0.8, 50.0);
  const auto by_action = [](const Eigen::VectorXd& p) {
    const auto ball = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [g = p[0]](const auto& q) { return g * q[0]; });
    const auto gap = [](const auto& q) { return q[0]; };
    return qdot::problem(ball, State<1>{0.0, {p[2]}, {0.0}}, events(event("floor", gap).falling().then(qdot::impact(ball, gap, qdot::restitution(p[1])))));
  };
  const auto by_contact = [](const Eigen::VectorXd& p) {
    const auto ball = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [g = p[0]](const auto& q) { return g * q[0]; });
    return qdot::problem(scene(ball, qdot::contact("floor", [](const auto& q) { return q[0]; }, qdot::restitution(p[1]))), State<1>{0.0, {p[2]}, {0.0}});
  };
  const auto check = [&](const auto& s) {
    INFO(s.message);
    REQUIRE(s.completed());
    REQUIRE(s.events.size() == 3);
    INFO(s.Phi);
    CHECK_THAT(s.y[0], WithinAbs(8.494217007606032792, error));
    CHECK_THAT(s.Phi(0, 0), WithinAbs(-7.277029744509896286, error));
    CHECK_THAT(s.Phi(0, 1), WithinAbs(314.568839957685554, 100 * error));
    CHECK_THAT(s.Phi(0, 2), WithinAbs(1.596182170076060328, error));
    CHECK_THAT(s.ydot[0], WithinAbs(-9.508652199492931147, error));
    // t₁ = √(2h/g)
    CHECK_THAT(s.events[0].time[0], WithinAbs(-0.5 * std::sqrt(2 * 50 / 9.8) / 9.8, error));
    CHECK_THAT(s.events[0].time[1], WithinAbs(0.0, error));
    CHECK_THAT(s.events[0].time[2], WithinAbs(0.5 * std::sqrt(2 / (9.8 * 50)), error));
  };
  check(sensitivities(by_action, p, 15.0, Dop853{}, fine));
  check(sensitivities(by_contact, p, 15.0, Dop853{}, fine));
}
