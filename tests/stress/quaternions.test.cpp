// SPDX-License-Identifier: MIT
//
// A free body in every attitude by a quaternion. T does not feel the quaternion's length, so M has rank 3 of 4; a constraint holds the
// length, by projection, or an inertia of its own lets it rest where it is.

#include <cmath>

#include "catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "stress/free_bodies.hpp"

using namespace qdot;
using Eigen::Vector3d;
using Eigen::Vector4d;

namespace {

const Options fine{.rtol = 1e-12, .atol = 1e-13};
constexpr double fine_error = 2e-10;  // of R, ω, L and the length after 50 s at these tolerances; 2e-11 was seen
constexpr double rounding = 4e-16;    // of a length of one
const stress::ConeThroughPole cone;
const Vector3d symmetric(1.0, 1.0, cone.I3), asymmetric(1.0, 2.0, 3.0);

const auto quaternion = [](const auto& p) { return rotation_from_quaternion(p); };

auto body_of_unit_quaternion(const Vector3d& moments) {
  return scene(stress::turning_body<4>(moments, quaternion),
               holonomic("unit quaternion", [](const auto& p) { return p.squaredNorm() - 1.0; }));
}

State<4> started(const Eigen::Matrix3d& R, const Vector3d& omega) {
  const Eigen::Quaterniond turn(R);
  const Vector4d p(turn.w(), turn.x(), turn.y(), turn.z());
  return {0.0, p, stress::rates<4>(quaternion, p, omega)};
}

TEST_CASE("a unit quaternion goes through both poles") {
  const auto run = simulate(body_of_unit_quaternion(symmetric), started(cone.rotation(0.0), cone.omega(0.0)), 50.0, Dop853{}, fine);
  INFO(run.message);
  REQUIRE(run.completed());
  CHECK((quaternion(run.state().q) - cone.rotation(run.t)).norm() < fine_error);
  CHECK(std::abs(run.state().q.norm() - 1.0) < rounding);
}

TEST_CASE("a quaternion whose length has an inertia needs no constraint") {
  const auto plain = stress::turning_body<4>(symmetric, quaternion);
  const auto body = mechanical_system<4>([=](const auto& p, const auto& pdot) {
    const auto rate = p.dot(pdot);
    return plain.energies().T(p, pdot) + 0.5 * rate * rate;
  });
  const auto run = simulate(body, started(cone.rotation(0.0), cone.omega(0.0)), 50.0, Dop853{}, fine);
  INFO(run.message);
  REQUIRE(run.completed());
  CHECK((quaternion(run.state().q) - cone.rotation(run.t)).norm() < fine_error);
  CHECK(std::abs(run.state().q.norm() - 1.0) < fine_error);
}

TEST_CASE("an asymmetric body in quaternions turns by Jacobi's elliptic functions") {
  const stress::AsymmetricBody known{1.0, 2.0, 3.0, 2.1, 4.5};
  const Vector3d start = known.body_omega(0.0);
  const auto run = simulate(body_of_unit_quaternion(asymmetric), started(Eigen::Matrix3d::Identity(), start), 50.0, Dop853{}, fine);
  REQUIRE(run.completed());
  const State<4> end = run.state();
  const Vector3d omega = body_angular_velocity_of(quaternion, end.q, end.qdot);
  CHECK((omega - known.body_omega(run.t)).norm() < fine_error);
  const Vector3d L = asymmetric.cwiseProduct(start), L_end = quaternion(end.q) * asymmetric.cwiseProduct(omega);
  CHECK((L_end - L).norm() < fine_error);
}

}  // namespace
