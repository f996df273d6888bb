// SPDX-License-Identifier: MIT
#include "catch2_bridge.hpp"

#include <cmath>

#include "qdot/ad/derivatives.hpp"
#include "qdot/mechanics/velocity.hpp"

using namespace qdot;

namespace {

// Sums of a few products of numbers of size 1: some units in the last place.
constexpr double rounding = 1e-14;

const auto spherical = [](const auto& q) {
  using std::cos;
  using std::sin;
  return vector(q[0] * sin(q[1]) * cos(q[2]), q[0] * sin(q[1]) * sin(q[2]), q[0] * cos(q[1]));
};

}  // namespace

TEST_CASE("a vector of integers holds real numbers") {
  STATIC_REQUIRE(std::is_same_v<decltype(qdot::vector(1, 2)), Eigen::Vector2d>);
  CHECK((qdot::vector(1, 2) / 2).eval()[0] == 0.5);
}

TEST_CASE("the velocity in spherical coordinates is the textbook one") {
  const Vector<double, 3> q(1.3, 0.7, -2.1), qdot(0.4, -1.1, 0.9);
  const double r = q[0], theta = q[1], phi = q[2];
  const Vector<double, 3> e_r(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
  const Vector<double, 3> e_theta(std::cos(theta) * std::cos(phi), std::cos(theta) * std::sin(phi), -std::sin(theta));
  const Vector<double, 3> e_phi(-std::sin(phi), std::cos(phi), 0.0);
  const Vector<double, 3> expected = qdot[0] * e_r + r * qdot[1] * e_theta + r * std::sin(theta) * qdot[2] * e_phi;
  const Vector<double, 3> v = velocity_of(spherical, q, qdot);
  CHECK((v - expected).norm() < rounding);
}

TEST_CASE("at rest a velocity still depends on the velocities that its exponents have") {
  // x = 2^q: ẋ = ln 2 · 2^q q̇, so that ∂ẋ/∂q̇ = 2^q ln 2 whatever q̇ is.
  const auto place = [](const auto& q) {
    using std::pow;
    return vector(pow(2.0, q[0]));
  };
  const Vector<double, 1> q(0.3), rest(0.0);
  const auto velocity = [&](const auto& v) {
    using D = typename std::remove_cvref_t<decltype(v)>::Scalar;
    return velocity_of(place, Vector<D, 1>(q.cast<D>()), v)[0];
  };
  CHECK_THAT(gradient(velocity, rest)[0], WithinAbs(std::log(2.0) * std::pow(2.0, 0.3), rounding));
}

TEST_CASE("the acceleration in spherical coordinates has the centrifugal and Coriolis terms of the textbook") {
  const Vector<double, 3> q(1.3, 0.7, -2.1), qdot(0.4, -1.1, 0.9), qddot(-0.3, 0.8, 1.7);
  const double r = q[0], theta = q[1], phi = q[2];
  const double s = std::sin(theta), c = std::cos(theta);
  const Vector<double, 3> e_r(s * std::cos(phi), s * std::sin(phi), c);
  const Vector<double, 3> e_theta(c * std::cos(phi), c * std::sin(phi), -s);
  const Vector<double, 3> e_phi(-std::sin(phi), std::cos(phi), 0.0);
  const double a_r = qddot[0] - r * qdot[1] * qdot[1] - r * s * s * qdot[2] * qdot[2];
  const double a_theta = r * qddot[1] + 2.0 * qdot[0] * qdot[1] - r * s * c * qdot[2] * qdot[2];
  const double a_phi = r * s * qddot[2] + 2.0 * s * qdot[0] * qdot[2] + 2.0 * r * c * qdot[1] * qdot[2];
  const Vector<double, 3> a = acceleration_of(spherical, q, qdot, qddot);
  CHECK((a - (a_r * e_r + a_theta * e_theta + a_phi * e_phi)).norm() < rounding);
}

TEST_CASE("the velocity is the Jacobian times the coordinate velocities") {
  const Vector<double, 3> q(0.6, 1.2, 0.4), qdot(-0.5, 0.3, 2.0);
  const Vector<double, 3> expected = jacobian(spherical, q) * qdot;
  CHECK((velocity_of(spherical, q, qdot) - expected).norm() < rounding);
}

TEST_CASE("an explicit time adds the velocity of the moving frame") {
  // a pendulum of length 1 hung on a support that moves as (t², 3t)
  const auto position = [](const auto& q, const auto& t) {
    using std::cos;
    using std::sin;
    return vector(t * t + sin(q[0]), 3.0 * t - cos(q[0]));
  };
  const Vector<double, 1> q(0.8), qdot(1.5);
  const double t = 2.5;
  const Vector<double, 2> v = velocity_of(position, q, qdot, t);
  CHECK_THAT(v[0], WithinAbs(2.0 * t + std::cos(0.8) * 1.5, rounding));
  CHECK_THAT(v[1], WithinAbs(3.0 + std::sin(0.8) * 1.5, rounding));
}

TEST_CASE("a scalar, a matrix and a constant all have a velocity") {
  const Vector<double, 2> q(2.0, 3.0), qdot(0.5, -1.0);
  CHECK(velocity_of([](const auto& x) { return x[0] * x[1]; }, q, qdot) == 0.5 * 3.0 - 2.0);
  CHECK(velocity_of([](const auto&) { return 7.0; }, q, qdot) == 0.0);
  const auto both = value_and_velocity_of(
      [](const auto& x) {
        using S = std::decay_t<decltype(x[0])>;
        Matrix<S, 2> m;
        m << x[0], S(1.0), x[0] * x[0], x[1];
        return m;
      },
      q, qdot);
  Eigen::Matrix2d rate;
  rate << 0.5, 0.0, 2.0, -1.0;
  CHECK(both.value(1, 0) == 4.0);
  CHECK(both.rate == rate);
}

TEST_CASE("a run-time number of coordinates gives the same velocity") {
  Eigen::VectorXd q(3), qdot(3);
  q << 1.3, 0.7, -2.1;
  qdot << 0.4, -1.1, 0.9;
  const Vector<double, 3> fixed_q = q, fixed_qdot = qdot;
  CHECK(velocity_of(spherical, q, qdot) == velocity_of(spherical, fixed_q, fixed_qdot));
}

TEST_CASE("the kinetic energy from positions carries exact second derivatives: its Hessian in q̇ is JᵀJ") {
  const Vector<double, 3> q(1.3, 0.7, -2.1), qdot(0.4, -1.1, 0.9);
  const auto T_of_velocity = [&q](const auto& w) { return 0.5 * velocity_of(spherical, q, w).squaredNorm(); };
  const Eigen::Matrix3d J = jacobian(spherical, q);
  CHECK((hessian(T_of_velocity, qdot) - J.transpose() * J).cwiseAbs().maxCoeff() < rounding);
}

TEST_CASE("an inner velocity is not confused with an outer derivative") {
  // d/dx of the velocity of x ↦ x·y along (x, y)˙ = (1, 0): velocity = y, so the derivative along x is 0
  const auto f = [](const auto& x) {
    return velocity_of([](const auto& y) { return y[0] * y[1]; }, x, Eigen::Vector2d(1.0, 0.0).cast<std::decay_t<decltype(x[0])>>().eval());
  };
  const Vector<double, 2> at(3.0, 5.0);
  const Vector<double, 2> slope = gradient(f, at);
  CHECK(f(at) == 5.0);
  CHECK(slope == Vector<double, 2>(0.0, 1.0));
}
