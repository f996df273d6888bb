// SPDX-License-Identifier: MIT
//
// Gimbal lock: a free body whose axis meets that of space, in Euler's angles and in rotation vectors that change their chart.

#include <cmath>
#include <numbers>

#include "catch2_bridge.hpp"
#include "qdot/integrate/rotation_chart.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "stress/free_bodies.hpp"

using namespace qdot;
using Eigen::Vector3d;

namespace {

const Options fine{.rtol = 1e-12, .atol = 1e-13};
constexpr double fine_error = 1e-9;     // of R after 50 s and some 500 steps at these tolerances; 6e-11 was seen
constexpr double coarse_error = 1e-7;   // after 1 s at rtol = 1e-6, which are fewer than a hundred steps before the crawl
constexpr double rounding = 2e-14;      // R and ω at |q̇| ≤ 3
const stress::ConeThroughPole cone;
const Vector3d moments(1.0, 1.0, cone.I3);

const auto euler = [](const auto& q) { return euler_rotation_313(q[0], q[1], q[2]); };
const auto vector_turn = [](const auto& v) { return rotation_from_vector(v); };
const auto top = stress::turning_body<3>(moments, euler).with_names({"phi", "theta", "psi"});

State<3> euler_start() {
  const Eigen::Matrix3d R = cone.rotation(0.0);
  const Vector3d q(std::atan2(R(0, 2), -R(1, 2)), std::acos(R(2, 2)), std::atan2(R(2, 0), R(2, 1)));
  return {0.0, q, stress::rates<3>(euler, q, cone.omega(0.0))};
}

TEST_CASE("started on the pole, Euler's angles name the turn that they cannot tell") {
  for (const double theta : {0.0, std::numbers::pi}) {
    CAPTURE(theta);
    try {
      simulate(top, State<3>{0.0, Vector3d(0.3, theta, 0.1), Vector3d(1.0, 0.2, 1.0)}, 1.0, Dop853{});
      FAIL("a locked gimbal was let through");
    } catch (const SingularMassMatrix& error) {
      INFO(error.what());
      CHECK_THAT(error.direction()[0], WithinAbs(theta == 0.0 ? -1.0 : 1.0, 1e-9));
      CHECK_THAT(error.direction()[1], WithinAbs(0.0, 1e-9));
      CHECK_THAT(error.direction()[2], WithinAbs(1.0, 1e-9));
    }
  }
}

TEST_CASE("in front of the pole a run in Euler's angles ends by name, right as far as it went") {
  const auto run = simulate(top, euler_start(), 2.0, Dop853{}, {.rtol = 1e-6, .atol = 1e-7});
  INFO(run.message);
  CHECK(run.outcome == Outcome::singular_mass_matrix);
  CHECK(std::abs(run.t - cone.pole) < 1e-6);
  CHECK((euler(run.state().q) - cone.rotation(run.t)).norm() < coarse_error);
}

TEST_CASE("a rotation vector that changes its chart goes through both poles") {
  const auto body = stress::turning_body<3>(moments, vector_turn);
  const Eigen::AngleAxisd turn(cone.rotation(0.0));
  const Vector3d v = turn.angle() * turn.axis();
  const auto run = simulate(body, State<3>{0.0, v, stress::rates<3>(vector_turn, v, cone.omega(0.0))}, 50.0, Dop853{}, fine,
                            events(rotation_chart<0>()));
  INFO(run.message);
  REQUIRE(run.completed());
  double worst = 0.0;
  for (double t = 0.0; t < run.t; t += 0.37)
    worst = std::max(worst, (rotation_from_vector(run.trajectory.at(t).q) - cone.rotation(t)).norm());
  CHECK(worst < fine_error);
  CHECK(run.events.size() > 10);
  for (const auto& change : run.events) {
    const State<3> before = run.trajectory.before(change.t), after = run.trajectory.at(change.t);
    CHECK((rotation_from_vector(before.q) - rotation_from_vector(after.q)).norm() < rounding);
    CHECK((angular_velocity_of(vector_turn, before.q, before.qdot) - angular_velocity_of(vector_turn, after.q, after.qdot)).norm() < rounding);
  }
}

}  // namespace
