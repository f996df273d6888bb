// SPDX-License-Identifier: MIT
#include <cmath>
#include <type_traits>

#include "../catch2_bridge.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/scene_form.hpp"
#include "scenes/double_pendulum.hpp"

namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;
using qdot::mechanical_system;
using qdot::scene;
using qdot::Vector;

constexpr double rounding = 1e-13;

const auto double_pendulum = mechanical_system<2>(qdot::scenes::DoublePendulum{});

// An effect from outside the library: a wind that pushes the first coordinate.
struct Wind {
  double strength = 1.0;
  template <class S, int n>
  Vector<S, n> force(const Vector<S, n>& q, const Vector<S, n>&, const S& t) const {
    using std::sin;
    Vector<S, n> Q = Vector<S, n>::Zero(q.size());
    Q[0] = strength * sin(t);
    return Q;
  }
};

TEST_CASE("a scene without effects is its system") {
  const auto s = scene(double_pendulum);
  STATIC_REQUIRE(std::is_same_v<std::remove_cvref_t<decltype(first_order_form(s))>,
                                std::remove_cvref_t<decltype(first_order_form(double_pendulum))>>);
  const Vector2d q(0.3, -0.8);
  const Vector2d v(1.2, 0.4);
  CHECK(acceleration(s, q, v) == acceleration(double_pendulum, q, v));
}

TEST_CASE("an effect written outside the library enters like any other") {
  const auto s = scene(double_pendulum, Wind{2.0});
  const Vector2d q(0.3, -0.8);
  const Vector2d v(1.2, 0.4);
  const Vector2d Q = rhs(s, q, v, 0.7) - rhs(double_pendulum, q, v);
  CHECK_THAT(Q[0], WithinAbs(2.0 * std::sin(0.7), rounding));
  CHECK_THAT(Q[1], WithinAbs(0.0, rounding));
}

// Another one, whose length and numbers are not the scene's own.
struct SteadyWind {
  template <class S, int n>
  Eigen::VectorXd force(const Vector<S, n>& q, const Vector<S, n>&, const S&) const {
    return VectorXd::Constant(q.size(), 0.5);
  }
};

TEST_CASE("the force of an effect may be a vector of plain numbers and of run-time length") {
  const Vector2d q(0.3, -0.8), v(1.2, 0.4);
  const auto s = scene(double_pendulum, SteadyWind{});
  CHECK((rhs(s, q, v) - rhs(double_pendulum, q, v) - Vector2d(0.5, 0.5)).norm() < rounding);
}

TEST_CASE("effects add up, in any order, to rounding") {
  const auto damper = qdot::viscous_damping(Vector2d(0.2, 0.1));
  const auto ab = scene(double_pendulum, Wind{1.0}, damper);
  const auto ba = scene(double_pendulum, damper, Wind{1.0});
  const Vector2d q(0.3, -0.8);
  const Vector2d v(1.2, 0.4);
  CHECK((acceleration(ab, q, v, 0.5) - acceleration(ba, q, v, 0.5)).norm() < rounding);
}

TEST_CASE("terms in the energies keep the shortest signature that holds them") {
  const auto constant = mechanical_system<1>([](const auto& v) { return 0.5 * v.squaredNorm(); });
  const auto with_spring = scene(constant, qdot::spring_damper([](const auto& q) { return q; }, Vector<double, 1>(0.0), 3.0, 0.0));
  STATIC_REQUIRE(decltype(with_spring)::SystemType::kinetic_signature == qdot::KineticSignature::velocity);
  CHECK_THAT(acceleration(with_spring, Vector<double, 1>(0.4), Vector<double, 1>(0.1))[0], WithinAbs(-1.2, rounding));
}

TEST_CASE("a controller's state is integrated beside the mechanics") {
  // ẍ = −z, ż = x: an integral controller on a free unit mass
  const auto mass = mechanical_system<1>([](const auto& v) { return 0.5 * v.squaredNorm(); }).with_names({"x"});
  const auto s = scene(mass, qdot::controller([](const auto&, const auto&, const auto& z, const auto&) { return -z[0]; },
                                              [](const auto& q, const auto&, const auto&, const auto&) { return q[0]; },
                                              Vector<double, 1>(0.25)));
  const auto form = first_order_form(s);
  STATIC_REQUIRE(decltype(form)::size_at_compile_time == 3);
  const VectorXd y = form.packed(qdot::State<1>{0.0, Vector<double, 1>(2.0), Vector<double, 1>(3.0)});
  CHECK(y == Eigen::Vector3d(2.0, 3.0, 0.25));
  VectorXd ydot(3);
  form.derivative(0.0, y, ydot);
  CHECK(ydot == Eigen::Vector3d(3.0, -0.25, 2.0));
  Eigen::MatrixXd J(3, 3);
  form.jacobian(0.0, y, J);
  Eigen::Matrix3d expected;
  expected << 0, 1, 0, 0, 0, -1, 1, 0, 0;
  CHECK((J - expected).norm() == 0.0);
  CHECK(form.component_name(2) == "z0");
}

TEST_CASE("the Jacobian of a scene holds its effects") {
  // q̈ = −c q̇ + sin t on a unit mass: ∂q̈/∂q̇ = −c
  const auto mass = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); });
  const auto form = first_order_form(scene(mass, qdot::viscous_damping(Vector2d(0.2, 0.7)), Wind{}));
  Eigen::MatrixXd J(4, 4);
  form.jacobian(0.3, Eigen::Vector4d(1, 2, 3, 4), J);
  Eigen::Matrix4d expected = Eigen::Matrix4d::Zero();
  expected.topRightCorner<2, 2>().setIdentity();
  expected(2, 2) = -0.2;
  expected(3, 3) = -0.7;
  CHECK((J - expected).norm() < rounding);
}

}  // namespace
