// SPDX-License-Identifier: MIT
#include "qdot/effects/rows/onset_direction.hpp"

#include <Eigen/Core>

#include "catch2_bridge.hpp"

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
constexpr double rounding = 1e-14;  // of a bisection to neighbouring numbers

VectorXd vector(double x, double y) { return Eigen::Vector2d(x, y); }

}  // namespace

TEST_CASE("where all directions have the same inertia sliding begins along the force") {
  const auto s = qdot::detail::onset_direction(MatrixXd(0.5 * MatrixXd::Identity(2, 2)), vector(3.0, 4.0));
  REQUIRE(s.has_value());
  CHECK((*s - vector(0.6, 0.8)).norm() < rounding);
}

TEST_CASE("an onset direction s satisfies (G + a) s = v0 with the a that it was made from") {
  MatrixXd G(2, 2);
  G << 2.0, 0.5, 0.5, 1.0;
  const VectorXd s = vector(0.28, -0.96);
  for (const double a : {0.1, 3.0, 1e3}) {
    const auto found = qdot::detail::onset_direction(G, VectorXd(G * s + a * s));
    REQUIRE(found.has_value());
    CHECK((*found - s).norm() < rounding);
  }
}

TEST_CASE("friction that can hold what would move has no onset") {
  MatrixXd G(2, 2);
  G << 2.0, 0.5, 0.5, 1.0;
  CHECK_FALSE(qdot::detail::onset_direction(G, VectorXd(0.99 * G * vector(0.28, -0.96))).has_value());
  CHECK(qdot::detail::onset_direction(G, VectorXd(1.01 * G * vector(0.28, -0.96))).has_value());
}

TEST_CASE("without friction sliding begins along the acceleration") {
  const auto s = qdot::detail::onset_direction(MatrixXd(MatrixXd::Zero(2, 2)), vector(-3.0, 4.0));
  REQUIRE(s.has_value());
  CHECK((*s - vector(-0.6, 0.8)).norm() < rounding);
}
