// SPDX-License-Identifier: MIT
#include <cmath>

#include "../catch2_bridge.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"

namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using qdot::mechanical_system;

const Vector2d somewhere(0.3, -0.4);
const Vector2d moving(1.0, 2.0);
const auto linear_potential = [](const auto& q) { return 2.0 * q[0] - q[1]; };  // forces (−2, 1)

TEST_CASE("the mass matrix of a double pendulum equals the hand-derived one") {
  const auto T = [](const auto& q, const auto& qdot) {
    using std::cos;
    return qdot[0] * qdot[0] + 0.5 * qdot[1] * qdot[1] + qdot[0] * qdot[1] * cos(q[0] - q[1]);
  };
  const double c = std::cos(0.7);
  Matrix2d expected;
  expected << 2.0, c, c, 1.0;
  CHECK((mass_matrix(mechanical_system<2>(T), somewhere, moving) - expected).norm() < 1e-15);
  CHECK((mass_matrix(mechanical_system(2, T), Eigen::VectorXd(somewhere), Eigen::VectorXd(moving)) - expected).norm() <
        1e-15);
}

TEST_CASE("the mass matrix of a T that is not quadratic depends on the velocities") {
  // T = ½ v² + ¼ v⁴:  M = 1 + 3 v²
  const auto s = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0] + 0.25 * pow(v[0], 4); });
  const qdot::Vector<double, 1> q(0.0);
  CHECK(mass_matrix(s, q, qdot::Vector<double, 1>(2.0))(0, 0) == 13.0);
}

TEST_CASE("a massless coordinate is named") {
  const auto s = mechanical_system<2>([](const auto& v) { return 0.5 * v[0] * v[0] + 0.0 * v[1]; }, linear_potential)
                     .with_names({"x", "y"});
  CHECK_THROWS_AS(acceleration(s, somewhere, moving), qdot::SingularMassMatrix);
  CHECK_THROWS_WITH(
      acceleration(s, somewhere, moving),
      "the mass matrix must be positive definite, but at t = 0 the motion with velocity along y has no kinetic energy "
      "(relative inertia 0); give that motion a mass or an inertia, remove the coordinate, or leave the point where "
      "the coordinates degenerate (a pole, r = 0)");
}

TEST_CASE("a direction without inertia across coordinates is named by its weights") {
  const auto s =
      mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] + 2.0 * v[1]) * (v[0] + 2.0 * v[1]); }, linear_potential);
  try {
    acceleration(s, somewhere, moving);
    FAIL("a singular mass matrix must not be solved");
  } catch (const qdot::SingularMassMatrix& e) {
    REQUIRE(e.direction().size() == 2);
    CHECK_THAT(e.direction()[0], WithinAbs(-1.0, 1e-15));
    CHECK_THAT(e.direction()[1], WithinAbs(0.5, 1e-15));
    CHECK(std::string(e.what()).find("-q0 + 0.5*q1") != std::string::npos);
  }
}

TEST_CASE("a singular direction hidden by rounding is still found") {
  // M = [[1, 1/3], [1/3, 1/9]] in rounded arithmetic: det is 1e-17 and not 0.
  const auto s = mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] + v[1] / 3.0) * (v[0] + v[1] / 3.0); },
                                      linear_potential);
  CHECK_THROWS_AS(acceleration(s, somewhere, moving), qdot::SingularMassMatrix);
}

TEST_CASE("grams beside tonnes are no singularity") {
  for (const double ratio : {1e-9, 1e9, 1e-150}) {
    const auto s = mechanical_system<2>(
        [=](const auto& v) { return 0.5 * v[0] * v[0] + 0.5 * ratio * v[1] * v[1]; }, linear_potential);
    const Vector2d a = acceleration(s, somewhere, moving);
    CHECK_THAT(a[0], WithinRel(-2.0, 1e-15));
    CHECK_THAT(a[1], WithinRel(1.0 / ratio, 1e-15));
  }
}

TEST_CASE("a negative mass is named and refused") {
  const auto s = mechanical_system<2>([](const auto& v) { return 0.5 * v[0] * v[0] - 0.5 * v[1] * v[1]; }, linear_potential);
  try {
    acceleration(s, somewhere, moving);
    FAIL("an indefinite mass matrix must not be solved unasked");
  } catch (const qdot::IndefiniteMassMatrix& e) {
    CHECK(e.direction() == std::vector<double>{0.0, 1.0});
    CHECK(e.inertia() == -1.0);
    CHECK(std::string(e.what()).find("with_indefinite_mass_matrix()") != std::string::npos);
  }
}

TEST_CASE("a regular indefinite mass matrix is solved when the system says that it is meant") {
  // T = ½ x ẋ² + ẋ ẏ: M = [[x, 1], [1, 0]], a zero pivot at x = 0. With V = 2x − y:
  // y: d/dt ẋ = 1;  x: x ẍ + ½ ẋ² + ÿ = −2
  const auto s = mechanical_system<2>(
                     [](const auto& q, const auto& v) { return 0.5 * q[0] * v[0] * v[0] + v[0] * v[1]; }, linear_potential)
                     .with_names({"x", "y"});
  const Vector2d q(0.0, 0.5);
  CHECK_THROWS_AS(acceleration(s, q, moving), qdot::IndefiniteMassMatrix);
  const Vector2d a = acceleration(s.with_indefinite_mass_matrix(), q, moving);
  CHECK_THAT(a[0], WithinAbs(1.0, 1e-15));
  CHECK_THAT(a[1], WithinAbs(-2.5, 1e-15));
}

TEST_CASE("an indefinite system without an inverse is still refused by name") {
  const auto s = mechanical_system<2>([](const auto& v) { return v[0] * v[0] + 0.0 * v[1]; }, linear_potential)
                     .with_names({"x", "y"})
                     .with_indefinite_mass_matrix();
  try {
    acceleration(s, somewhere, moving);
    FAIL("a singular mass matrix must not be solved");
  } catch (const qdot::SingularMassMatrix& e) {
    CHECK(std::string(e.what()).find("vanishes on velocities along y") != std::string::npos);
  }
}

TEST_CASE("a Lagrangian linear in the velocities has no accelerations to solve for") {
  // L = x ẏ − ½(x² + y²): M = 0
  const auto s = mechanical_system<2>([](const auto& q, const auto& v) { return q[0] * v[1]; },
                                      [](const auto& q) { return 0.5 * q.squaredNorm(); });
  CHECK_THROWS_AS(acceleration(s, somewhere, moving), qdot::SingularMassMatrix);
}

TEST_CASE("a mass matrix that is not finite names its entry") {
  const auto s = mechanical_system<2>([](const auto& q, const auto& v) { return 0.5 * v[0] * v[0] / q[0] + 0.5 * v[1] * v[1]; },
                                      linear_potential)
                     .with_names({"x", "y"});
  CHECK_THROWS_AS(acceleration(s, Vector2d(0.0, 1.0), moving), qdot::NonFinite);
}

}  // namespace
