// SPDX-License-Identifier: MIT
#include "qdot/effects/scene_at_state.hpp"

#include <cmath>

#include "../catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/input.hpp"

namespace {

using Eigen::Vector2d;
using qdot::scene;
using qdot::State;

constexpr double rounding = 1e-13;  // of some ten operations on numbers of the order of ten

constexpr double m = 2.0, l = 1.5, g = 9.81, c = 0.3;

// A pendulum in Cartesian coordinates, on a rod, in air.
const auto bob = qdot::mechanical_system<2>([](const auto&, const auto& v) { return 0.5 * m * v.squaredNorm(); },
                                            [](const auto& q) { return m * g * q[1]; });
const auto rod = qdot::holonomic("rod", [](const auto& q) { return 0.5 * (q.squaredNorm() - l * l); });
const auto air = qdot::rayleigh([](const auto&, const auto& v) { return 0.5 * c * v.squaredNorm(); });
const auto pendulum = scene(bob, rod, air);

// The same by one angle: place, velocity and what the angle's equation says.
struct ByAngle {
  double angle = 0.7, rate = 1.1;
  Vector2d along() const { return {std::cos(angle), std::sin(angle)}; }
  Vector2d outward() const { return {std::sin(angle), -std::cos(angle)}; }
  State<2> state() const { return {0.4, Vector2d(l * outward()), Vector2d(l * rate * along())}; }
  Vector2d acceleration() const { return l * (-(g / l) * std::sin(angle) - c / m * rate) * along() - l * rate * rate * outward(); }
  Vector2d tension() const { return -(m * l * rate * rate + m * g * std::cos(angle)) * outward(); }
};

TEST_CASE("at a state of a pendulum on its rod a scene answers as the pendulum's angle does") {
  const ByAngle hand;
  const State<2> s = hand.state();
  const double speed = l * hand.rate, height = -l * std::cos(hand.angle);
  CHECK((acceleration(pendulum, s) - hand.acceleration()).norm() < 100 * rounding);
  CHECK((reactions(pendulum, s) - hand.tension()).norm() < 100 * rounding);
  CHECK_THAT(power(pendulum, s), WithinAbs(-c * speed * speed, 100 * rounding));
  CHECK_THAT(energy(pendulum, s), WithinAbs(0.5 * m * speed * speed + m * g * height, 100 * rounding));
  CHECK_THAT(lagrangian(pendulum, s), WithinAbs(0.5 * m * speed * speed - m * g * height, 100 * rounding));
  CHECK_THAT(jacobi_energy(pendulum, s), WithinAbs(energy(pendulum, s), 100 * rounding));
}

TEST_CASE("what a motion needs beyond a scene's own forces is m a + m g + c v, and on the free motion what the rod gives") {
  const ByAngle hand;
  const State<2> s = hand.state();
  const Vector2d wanted(3.0, -1.0);
  CHECK((motion_residual(pendulum, s, wanted) - (m * wanted + Vector2d(0, m * g) + c * s.qdot)).norm() < 100 * rounding);
  CHECK((motion_residual(pendulum, s, acceleration(pendulum, s)) - hand.tension()).norm() < 100 * rounding);
}

TEST_CASE("the Jacobian of a scene at a state is that of its formula, with the effects' own states held") {
  // q̈ = (u − ∇V − c q̇)/m with the input u = z along the first coordinate
  const auto pushed = scene(bob, air, qdot::input("push", 0));
  const State<2> s = {0.0, Vector2d(0.3, -0.2), Vector2d(0.5, 0.1)};
  const Eigen::Matrix<double, 1, 1> push(4.0);
  const auto a = acceleration_jacobian(pushed, s, push);
  CHECK((a.qddot - (Vector2d(push[0], -m * g) - c * s.qdot) / m).norm() < rounding);
  CHECK((a.qddot - acceleration(pushed, s, push)).norm() == 0.0);
  CHECK(a.d_q.norm() < rounding);
  CHECK((a.d_qdot + c / m * Eigen::Matrix2d::Identity()).norm() < rounding);
  CHECK_THAT(power(pushed, s, push), WithinAbs(push[0] * s.qdot[0] - c * s.qdot.squaredNorm(), rounding));
  CHECK_THAT(power(pushed, s), WithinAbs(-c * s.qdot.squaredNorm(), rounding));  // an input begins at zero
  CHECK((acceleration_jacobian(scene(bob), s).qddot - Vector2d(0, -g)).norm() < rounding);
}

}  // namespace
