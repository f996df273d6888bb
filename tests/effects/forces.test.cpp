// SPDX-License-Identifier: MIT
#include <Eigen/Geometry>
#include <cmath>

#include "../catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/scene_motion.hpp"

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using qdot::mechanical_system;
using qdot::scene;
using qdot::Vector;

// A few roundings on numbers of order ten.
constexpr double rounding = 1e-13;

const auto free_point = mechanical_system<2>([](const auto& v) { return 0.5 * 2.0 * v.squaredNorm(); });
const auto polar_point = mechanical_system<2>(
    [](const auto& q, const auto& v) { return 0.5 * (v[0] * v[0] + q[0] * q[0] * v[1] * v[1]); });
const auto cartesian = [](const auto& q) {
  using std::cos;
  using std::sin;
  return qdot::vector(q[0] * cos(q[1]), q[0] * sin(q[1]));
};
const auto itself = [](const auto& q) { return q; };

TEST_CASE("an argument of an effect's functor that has a default is given the time") {
  // Each of them pushes a unit mass with the force t, or holds it where ẍ = t.
  const auto mass = mechanical_system<1>([](const auto& v) { return 0.5 * v.squaredNorm(); });
  const auto q = Vector<double, 1>(0.3), v = Vector<double, 1>(0.5);
  const auto acceleration_with = [&](const auto& effect) { return acceleration(scene(mass, effect), q, v, 3.0)[0]; };
  const auto force = []<class X>(const X&, const X& w, typename X::Scalar t = typename X::Scalar(0.0)) { return qdot::vector(t + 0.0 * w[0]); };
  const auto power = []<class X>(const X&, const X& w, typename X::Scalar t = typename X::Scalar(0.0)) { return -t * w[0]; };
  const auto place = []<class X>(const X& x, typename X::Scalar t = typename X::Scalar(0.0)) { return qdot::vector(x[0] * t); };
  const auto curve = []<class X>(const X& x, typename X::Scalar t = typename X::Scalar(0.0)) { return x[0] - t * t * t / 6.0; };
  const auto speed = []<class X>(const X&, const X& w, typename X::Scalar t = typename X::Scalar(0.0)) { return w[0] - 0.5 * t * t; };
  CHECK(acceleration_with(qdot::generalized_force(force)) == 3.0);
  CHECK(acceleration_with(qdot::rayleigh(power)) == 3.0);
  CHECK(acceleration_with(qdot::force_at_point([](const auto& x) { return x; }, force)) == 3.0);
  CHECK(acceleration_with(qdot::force_at_point(place, Vector<double, 1>(1.0))) == 3.0);
  CHECK(acceleration_with(qdot::velocity_potential(power)) == -1.0);  // d/dt (ẋ + t) = 0
  CHECK_THAT(acceleration_with(qdot::holonomic("curve", curve)), WithinAbs(3.0, 1e-14));
  CHECK_THAT(acceleration_with(qdot::nonholonomic("speed", speed)), WithinAbs(3.0, 1e-14));
}

TEST_CASE("the force at a point may leave the time out") {
  const auto mass = mechanical_system<1>([](const auto& v) { return 0.5 * v.squaredNorm(); });
  const auto spring = qdot::force_at_point([](const auto& x) { return x; }, [](const auto& r, const auto& u) { return qdot::vector(-4.0 * r[0] - u[0]); });
  CHECK(acceleration(scene(mass, spring), Vector<double, 1>(0.25), Vector<double, 1>(0.5))[0] == -1.5);
}

TEST_CASE("a generalized force enters the equations as it is") {
  const auto s = scene(free_point, qdot::generalized_force([](const auto& q, const auto& v, const auto& t) {
                         return qdot::vector(q[1] * t, -v[0]);
                       }));
  const Vector2d a = acceleration(s, Vector2d(1, 3), Vector2d(4, 5), 2.0);
  CHECK((a - Vector2d(3.0, -2.0)).norm() < rounding);
  CHECK_THAT(power(s, Vector2d(1, 3), Vector2d(4, 5), 2.0), WithinAbs(6.0 * 4 - 4.0 * 5, rounding));
}

TEST_CASE("a force at a point is mapped by the virtual work of its point") {
  // In polar coordinates Q_r = F·e_r and Q_φ = r F·e_φ.
  const Vector2d F(0.7, -1.1);
  const auto s = scene(polar_point, qdot::force_at_point(cartesian, F));
  const Vector2d q(2.0, 0.3);
  const Vector2d Q = rhs(s, q, Vector2d(0, 0));
  CHECK_THAT(Q[0], WithinAbs(F[0] * std::cos(0.3) + F[1] * std::sin(0.3), rounding));
  CHECK_THAT(Q[1], WithinAbs(2.0 * (-F[0] * std::sin(0.3) + F[1] * std::cos(0.3)), rounding));
}

TEST_CASE("a force at a point may depend on where it is, how it moves, and when") {
  const auto s = scene(polar_point, qdot::force_at_point(cartesian, [](const auto& r, const auto& v, const auto& t) {
                         return (-r * t - v).eval();
                       }));
  const Vector2d q(2.0, 0.3);
  const Vector2d v(0.5, -0.2);
  // F = −3 r − ṙ: Q_r = −3·2 − 0.5, Q_φ = −r² φ̇
  const Vector2d Q = rhs(s, q, v, 3.0) - rhs(polar_point, q, v);
  CHECK_THAT(Q[0], WithinAbs(-6.5, rounding));
  CHECK_THAT(Q[1], WithinAbs(4.0 * 0.2, rounding));
}

TEST_CASE("a torque on a body does work on its angular velocity") {
  // Euler angles 3-1-3: the torque τ e_z works on φ̇, and on ψ̇ by its projection cos θ.
  const auto top = mechanical_system<3>([](const auto& v) { return 0.5 * v.squaredNorm(); });
  const auto pose = [](const auto& q) { return qdot::euler_rotation_313(q[0], q[1], q[2]); };
  const auto s = scene(top, qdot::torque_on_body(pose, Vector3d(0, 0, 1.5)));
  const Vector3d q(0.4, 0.7, -0.2);
  const Vector3d Q = rhs(s, q, Vector3d(0.1, 0.2, 0.3));
  CHECK_THAT(Q[0], WithinAbs(1.5, rounding));
  CHECK_THAT(Q[1], WithinAbs(0.0, rounding));
  CHECK_THAT(Q[2], WithinAbs(1.5 * std::cos(0.7), rounding));
}

TEST_CASE("a Rayleigh function dissipates its degree times itself") {
  const Vector2d q(1.3, 0.4);
  const Vector2d v(0.5, -0.2);
  // R = ½ c (1 + q²) v²: Q = −c (1 + q²) v, power −2R
  const auto viscous = scene(free_point, qdot::rayleigh([](const auto& x, const auto& w) {
                               return 0.5 * 0.3 * (1.0 + x[0] * x[0]) * w.squaredNorm();
                             }));
  const double R = 0.5 * 0.3 * (1.0 + 1.69) * v.squaredNorm();
  CHECK((rhs(viscous, q, v) + 0.3 * 2.69 * v).norm() < rounding);
  CHECK_THAT(power(viscous, q, v), WithinAbs(-2.0 * R, rounding));
  // Quadratic drag: power −b |v|³
  const auto drag = scene(free_point, qdot::quadratic_drag(itself, 0.8));
  CHECK_THAT(power(drag, q, v), WithinAbs(-0.8 * std::pow(v.norm(), 3), rounding));
  CHECK(rhs(drag, q, Vector2d(0, 0)) == Vector2d(0, 0));
}

TEST_CASE("a spring-damper between two free points keeps both momenta") {
  // Two points in the plane, q = (x1, y1, x2, y2): internal forces sum to zero and have no moment.
  const auto pair = mechanical_system<4>([](const auto& v) { return 0.5 * v.squaredNorm(); });
  const auto first = [](const auto& q) { return qdot::vector(q[0], q[1]); };
  const auto second = [](const auto& q) { return qdot::vector(q[2], q[3]); };
  const auto s = scene(pair, qdot::spring_damper(first, second, 5.0, 0.4, 0.9));
  const Eigen::Vector4d q(0.1, 0.2, 1.0, -0.5);
  const Eigen::Vector4d v(0.3, -0.1, 0.2, 0.7);
  const Eigen::Vector4d Q = rhs(s, q, v);
  CHECK_THAT(Q[0] + Q[2], WithinAbs(0.0, rounding));
  CHECK_THAT(Q[1] + Q[3], WithinAbs(0.0, rounding));
  CHECK_THAT(q[0] * Q[1] - q[1] * Q[0] + q[2] * Q[3] - q[3] * Q[2], WithinAbs(0.0, rounding));
  // Tension k (ℓ − ℓ₀) + c ℓ̇ along the line, by hand
  const Vector2d d(q[2] - q[0], q[3] - q[1]);
  const double rate = d.dot(Vector2d(v[2] - v[0], v[3] - v[1])) / d.norm();
  const double tension = 5.0 * (d.norm() - 0.4) + 0.9 * rate;
  CHECK((Q.head<2>() - tension * d / d.norm()).norm() < rounding);
  CHECK_THAT(power(s, q, v), WithinAbs(-0.9 * rate * rate, rounding));
  CHECK_THAT(energy(s, q, v), WithinAbs(0.5 * v.squaredNorm() + 2.5 * std::pow(d.norm() - 0.4, 2), rounding));
}

TEST_CASE("a law of tension pulls along the line of its points") {
  const auto s = scene(free_point, qdot::tension_between(itself, Vector2d(0, 0), [](const auto& length, const auto& rate) {
                         return 2.0 * length * length * length + 0.1 * rate;
                       }));
  const Vector2d q(3.0, 4.0);
  const Vector2d v(1.0, 0.0);
  const double tension = 2.0 * 125.0 + 0.1 * 0.6;
  CHECK((rhs(s, q, v) + tension * Vector2d(0.6, 0.8)).norm() < 1e-11);
}

TEST_CASE("a spring pulls along all axes of points that are given as rows") {
  const auto row = [](const auto& q) { return Eigen::Matrix<typename std::remove_cvref_t<decltype(q)>::Scalar, 1, 2>(q[0], q[1]); };
  const auto s = scene(free_point, qdot::spring_damper(row, Vector2d(0, 0), 2.0, 1.0));
  CHECK((rhs(s, Vector2d(3.0, 4.0), Vector2d(0.0, 0.0)) + 8.0 * Vector2d(0.6, 0.8)).norm() < rounding);
}

TEST_CASE("a velocity-dependent potential deflects without work") {
  // U = −½ B (x ẏ − y ẋ): m ẍ = B ẏ, m ÿ = −B ẋ
  const double B = 3.0;
  const auto s = scene(free_point, qdot::velocity_potential([=](const auto& q, const auto& v) {
                         return -0.5 * B * (q[0] * v[1] - q[1] * v[0]);
                       }));
  const Vector2d a = acceleration(s, Vector2d(0.2, 0.9), Vector2d(1.0, 2.0));
  CHECK_THAT(a[0], WithinAbs(B * 2.0 / 2.0, rounding));
  CHECK_THAT(a[1], WithinAbs(-B * 1.0 / 2.0, rounding));
}

TEST_CASE("a turning and accelerating frame gives Coriolis, centrifugal, Euler and inertial forces") {
  const auto point = mechanical_system<3>([](const auto& v) { return 0.5 * 2.0 * v.squaredNorm(); });
  const auto omega = [](const auto& t) { return qdot::vector(0.0 * t, 0.3 * t, 0.5 + 0.0 * t); };
  const auto push = [](const auto& t) { return qdot::vector(1.0 + 0.0 * t, 0.0 * t, 2.0 * t); };
  const auto s = scene(point, qdot::non_inertial_frame(2.0, itself, omega, push));
  const Vector3d r(0.4, -0.3, 0.8);
  const Vector3d v(1.0, 0.2, -0.5);
  const double t = 1.5;
  const Vector3d W(0.0, 0.45, 0.5);
  const Vector3d Wdot(0.0, 0.3, 0.0);
  const Vector3d expected = -2.0 * W.cross(v) - W.cross(W.cross(r)) - Wdot.cross(r) - Vector3d(1.0, 0.0, 3.0);
  CHECK((acceleration(s, r, v, t) - expected).norm() < rounding);
}

TEST_CASE("regularized friction opposes motion and saturates") {
  const auto s = scene(free_point, qdot::regularized_friction(0, 0.7, 1e-3));
  CHECK_THAT(rhs(s, Vector2d(0, 0), Vector2d(1.0, 1.0))[0], WithinAbs(-0.7, rounding));
  CHECK_THAT(rhs(s, Vector2d(0, 0), Vector2d(-1.0, 1.0))[0], WithinAbs(0.7, rounding));
  CHECK(rhs(s, Vector2d(0, 0), Vector2d(0.0, 1.0)) == Vector2d(0, 0));
}

TEST_CASE("viscous damping brakes each velocity with its coefficient") {
  const auto s = scene(free_point, qdot::viscous_damping(Vector2d(0.2, 0.7)));
  CHECK((rhs(s, Vector2d(1, 2), Vector2d(3, -4)) - Vector2d(-0.6, 2.8)).norm() < rounding);
  CHECK_THAT(power(s, Vector2d(1, 2), Vector2d(3, -4)), WithinAbs(-0.2 * 9 - 0.7 * 16, rounding));
}

TEST_CASE("parameters of effects outside their range are refused with their values") {
  CHECK_THROWS_AS(qdot::viscous_damping(Vector2d(0.1, -0.2)), qdot::InvalidValue);
  CHECK_THROWS_AS(qdot::regularized_friction(0, 1.0, 0.0), qdot::InvalidValue);
  CHECK_THROWS_AS(qdot::spring_damper(itself, Vector2d(0, 0), -1.0, 0.0), qdot::InvalidValue);
}

}  // namespace
