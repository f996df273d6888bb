// SPDX-License-Identifier: MIT
#include "catch2_bridge.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "qdot/ad/derivatives.hpp"
#include "qdot/mechanics/rotation.hpp"

using namespace qdot;

namespace {

// Products of three 3×3 matrices of entries up to 1.
constexpr double rounding = 1e-14;

double distance(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) { return (a - b).cwiseAbs().maxCoeff(); }

Eigen::Vector3d random_vector(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const double x = uniform(random), y = uniform(random), z = uniform(random);
  return {x, y, z};
}

const auto euler_313 = [](const auto& q) { return euler_rotation_313(q[0], q[1], q[2]); };
const auto euler_321 = [](const auto& q) { return euler_rotation_321(q[0], q[1], q[2]); };
const auto turned_by_vector = [](const auto& q) { return rotation_from_vector(q); };

}  // namespace

TEST_CASE("skew is the cross product, and the axial vector undoes it") {
  const Eigen::Vector3d a(1.0, -2.0, 0.5), b(0.3, 0.7, -1.1);
  CHECK((skew(a) * b - a.cross(b)).norm() < rounding);
  CHECK(axial_vector(skew(a)) == a);
}

TEST_CASE("a quarter turn about an axis takes the next axis to the one after it") {
  const double quarter = std::numbers::pi / 2.0;
  CHECK((rotation_x(quarter) * Eigen::Vector3d::UnitY() - Eigen::Vector3d::UnitZ()).norm() < rounding);
  CHECK((rotation_y(quarter) * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitX()).norm() < rounding);
  CHECK((rotation_z(quarter) * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm() < rounding);
  CHECK((planar_rotation(quarter) * Eigen::Vector2d::UnitX() - Eigen::Vector2d::UnitY()).norm() < rounding);
}

TEST_CASE("all rotations are proper: RᵀR = E and det R = 1") {
  std::mt19937 random(1);
  for (int sample = 0; sample < 100; ++sample) {
    const Eigen::Vector3d a = 3.0 * random_vector(random);
    const Eigen::Vector4d p(0.3, a[0], a[1], a[2]);
    for (const Eigen::Matrix3d& R : {euler_313(a), euler_321(a), turned_by_vector(a), rotation_from_quaternion(p)}) {
      CHECK(distance(R.transpose() * R, Eigen::Matrix3d::Identity()) < rounding);
      CHECK_THAT(R.determinant(), WithinAbs(1.0, rounding));
    }
  }
}

TEST_CASE("Euler angles, quaternions and rotation vectors agree with Eigen's") {
  std::mt19937 random(2);
  using Eigen::AngleAxisd, Eigen::Vector3d;
  for (int sample = 0; sample < 100; ++sample) {
    const Vector3d a = 3.0 * random_vector(random);
    const Eigen::Matrix3d zxz = (AngleAxisd(a[0], Vector3d::UnitZ()) * AngleAxisd(a[1], Vector3d::UnitX()) *
                                 AngleAxisd(a[2], Vector3d::UnitZ())).toRotationMatrix();
    const Eigen::Matrix3d zyx = (AngleAxisd(a[0], Vector3d::UnitZ()) * AngleAxisd(a[1], Vector3d::UnitY()) *
                                 AngleAxisd(a[2], Vector3d::UnitX())).toRotationMatrix();
    CHECK(distance(euler_313(a), zxz) < rounding);
    CHECK(distance(euler_321(a), zyx) < rounding);
    CHECK(distance(rotation_from_vector(a), AngleAxisd(a.norm(), a.normalized()).toRotationMatrix()) < rounding);
    const Eigen::Quaterniond p(0.4, a[0], a[1], a[2]);
    CHECK(distance(rotation_from_quaternion(Eigen::Vector4d(0.4, a[0], a[1], a[2])), p.normalized().toRotationMatrix()) < rounding);
  }
}

TEST_CASE("a quaternion and its multiples give the same rotation") {
  const Eigen::Vector4d p(0.3, -0.5, 0.8, 0.1);
  CHECK(distance(rotation_from_quaternion(p), rotation_from_quaternion((-7.5 * p).eval())) < rounding);
}

TEST_CASE("the exponential map is seamless where series and closed form meet") {
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, -2.0, 2.0) / 3.0;
  for (const double angle : {0.0, 1e-9, 0.1, 0.4999999, 0.5000001, 1.0, 3.1}) {
    CHECK(distance(turned_by_vector((angle * axis).eval()), Eigen::AngleAxisd(angle, axis).toRotationMatrix()) < rounding);
  }
}

TEST_CASE("the exponential map has its derivatives at zero: R(v) = E + [v×] + ½[v×]² + …") {
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero(), v(0.7, -1.2, 0.4);
  const auto bilinear = [&v](const auto& x) {
    const auto R = rotation_from_vector(x);
    return (v.transpose() * (R * v))(0, 0);
  };
  // vᵀ R(x) v = |v|² − ½ |x × v|² + …, so its Hessian at 0 is −(|v|² E − v vᵀ)
  CHECK(gradient(bilinear, zero).norm() < rounding);
  const Eigen::Matrix3d expected = -(v.squaredNorm() * Eigen::Matrix3d::Identity() - v * v.transpose());
  CHECK(distance(hessian(bilinear, zero), expected) < rounding);
  CHECK((angular_velocity_of(turned_by_vector, zero, v) - v).norm() < rounding);
}

TEST_CASE("Euler's kinematic equations for 3-1-3 come out of R") {
  std::mt19937 random(3);
  for (int sample = 0; sample < 100; ++sample) {
    const Eigen::Vector3d q = 3.0 * random_vector(random), qdot = 3.0 * random_vector(random);
    const double phi = q[0], theta = q[1], psi = q[2];
    const Eigen::Vector3d body(qdot[0] * std::sin(theta) * std::sin(psi) + qdot[1] * std::cos(psi),
                               qdot[0] * std::sin(theta) * std::cos(psi) - qdot[1] * std::sin(psi),
                               qdot[0] * std::cos(theta) + qdot[2]);
    const Eigen::Vector3d space(qdot[1] * std::cos(phi) + qdot[2] * std::sin(theta) * std::sin(phi),
                                qdot[1] * std::sin(phi) - qdot[2] * std::sin(theta) * std::cos(phi),
                                qdot[0] + qdot[2] * std::cos(theta));
    CHECK((body_angular_velocity_of(euler_313, q, qdot) - body).norm() < rounding);
    CHECK((angular_velocity_of(euler_313, q, qdot) - space).norm() < rounding);
  }
}

TEST_CASE("yaw, pitch and roll rates give the angular velocity of the flight mechanics books") {
  const Eigen::Vector3d q(0.3, -0.4, 0.9), qdot(1.1, 0.2, -0.7);
  const double pitch = q[1], roll = q[2];
  const Eigen::Vector3d body(qdot[2] - qdot[0] * std::sin(pitch),
                             qdot[1] * std::cos(roll) + qdot[0] * std::cos(pitch) * std::sin(roll),
                             -qdot[1] * std::sin(roll) + qdot[0] * std::cos(pitch) * std::cos(roll));
  CHECK((body_angular_velocity_of(euler_321, q, qdot) - body).norm() < rounding);
}

TEST_CASE("the angular velocity of a quaternion is 2 ṗ p⁻¹, and ṗ along p turns nothing") {
  const Eigen::Vector4d p(0.3, -0.5, 0.8, 0.1), pdot(0.2, 0.7, -0.4, 1.3);
  const auto rotation = [](const auto& x) { return rotation_from_quaternion(x); };
  const Eigen::Quaterniond a(p[0], p[1], p[2], p[3]), b(pdot[0], pdot[1], pdot[2], pdot[3]);
  const Eigen::Vector3d expected = 2.0 * (b * a.conjugate()).vec() / p.squaredNorm();
  CHECK((angular_velocity_of(rotation, p, pdot) - expected).norm() < rounding);
  CHECK(angular_velocity_of(rotation, p, p).norm() < rounding);
}

TEST_CASE("space and body components of the angular velocity are turned into each other by R") {
  const Eigen::Vector3d q(0.3, 1.4, 0.9), qdot(1.1, 0.2, -0.7);
  const Eigen::Vector3d space = angular_velocity_of(turned_by_vector, q, qdot);
  const Eigen::Vector3d body = body_angular_velocity_of(turned_by_vector, q, qdot);
  CHECK((space - turned_by_vector(q) * body).norm() < rounding);
}

TEST_CASE("a table that turns with time adds its own angular velocity") {
  // R = R_z(Ω t) R_x(q): ω = Ω e_z + q̇ (the x axis of the table)
  const auto rotation = [](const auto& q, const auto& t) { return (rotation_z(2.0 * t) * rotation_x(q[0])).eval(); };
  const Vector<double, 1> q(0.4), qdot(1.5);
  const double t = 0.7;
  const Eigen::Vector3d expected(1.5 * std::cos(1.4), 1.5 * std::sin(1.4), 2.0);
  CHECK((angular_velocity_of(rotation, q, qdot, t) - expected).norm() < rounding);
}

TEST_CASE("points of a turning body move with ω × r") {
  const Eigen::Vector3d q(0.3, 1.4, 0.9), qdot(1.1, 0.2, -0.7), p(0.2, -0.6, 1.0);
  const auto position = [&p](const auto& x) { return (euler_313(x) * p).eval(); };
  const Eigen::Vector3d r = position(q);
  CHECK((velocity_of(position, q, qdot) - angular_velocity_of(euler_313, q, qdot).cross(r)).norm() < rounding);
}
