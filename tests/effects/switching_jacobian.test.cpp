// SPDX-License-Identifier: MIT
//
// Jacobians of scenes that switch: each phase has its own, from closed forms and from nested duals.
#include <array>
#include <cmath>
#include <type_traits>

#include "../catch2_bridge.hpp"
#include "qdot/ad/derivatives.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/dry_friction.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/mechanics/kinematic_system.hpp"

using namespace qdot;

namespace {

// Rounding of forces of order ten through a factorization or two.
constexpr double rounded = 1e-12;
constexpr double g = 9.81;
constexpr double apart = 0.0, closed = 1.0, sticks = 0.0;

template <class Form>
Eigen::MatrixXd jacobian_of(const Form& form, const Eigen::VectorXd& y, double t = 0.3) {
  Eigen::MatrixXd J(y.size(), y.size());
  form.jacobian(t, y, J);
  return J;
}
// The same by nested duals.
template <class Sc>
Eigen::MatrixXd reference(const SceneForm<Sc>& form, const Eigen::VectorXd& y, double t = 0.3) {
  Eigen::MatrixXd J(y.size(), y.size());
  detail::write_scene_jacobian(detail::SceneSlopesOf<Sc>(form.scene()), t, y, J);
  return J;
}
double difference(const Eigen::MatrixXd& found, const Eigen::MatrixXd& expected) { return (found - expected).norm() / (1.0 + expected.norm()); }

const auto point = [](const auto& v) { return 0.5 * v.squaredNorm(); };
const auto weight = [](const auto& q) { return g * q[1]; };

TEST_CASE("on a rope a mass has the Jacobian of a circle where it is taut, and of free fall where it is slack") {
  const auto form = first_order_form(
      scene(mechanical_system<2>(point, weight), rope(
                                                     "rope", [](const auto& q) { return q; }, Vector<double, 2>(0.0, 0.0), 1.0)));
  const auto by_hand = [](const auto& y) {  // q̈ = f + 2 q λ, λ = −(v² + f·q)/(2 q²) with f = (0, −g)
    using S = typename std::remove_cvref_t<decltype(y)>::Scalar;
    const S factor = -(y[2] * y[2] + y[3] * y[3] - g * y[1]) / (y[0] * y[0] + y[1] * y[1]);
    return Vector<S, 2>(factor * y[0], S(-g) + factor * y[1]);
  };
  for (const double phase : {apart, closed, apart, closed, 2.0}) {
    CAPTURE(phase);
    Vector<double, 5> y;
    y << 0.6, -0.8, 0.8, 0.6, phase;
    Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(5, 5);
    expected(0, 2) = expected(1, 3) = 1.0;
    if (phase == closed) expected.block(2, 0, 2, 4) = qdot::jacobian(by_hand, Vector<double, 4>(y.head<4>()));
    CHECK(difference(jacobian_of(form, y), expected) < rounded);
    Eigen::VectorXd beside(5), alone(5);
    Eigen::MatrixXd J(5, 5);
    form.derivative_and_jacobian(0.3, y, beside, J);
    form.derivative(0.3, y, alone);
    CHECK((beside - alone).norm() < rounded);
    CHECK(difference(J, expected) < rounded);
  }
}

TEST_CASE("a block that slides against friction has the slopes of it, and one that sticks has none") {
  // F = 2 + v²/2 against v: q̈ = −k q − s F
  const auto s = scene(mechanical_system<1>(point, [](const auto& q) { return 1.5 * q[0] * q[0]; }),
                       dry_friction("block", 0, [](const auto&, const auto& v) { return 2.0 + 0.5 * v[0] * v[0]; }));
  const auto form = first_order_form(s);
  for (const double phase : {1.0, -1.0, sticks, 1.0}) {
    CAPTURE(phase);
    const Vector<double, 3> y(0.4, 0.7, phase);
    Eigen::Matrix3d expected = Eigen::Matrix3d::Zero();
    expected(0, 1) = 1.0;
    if (phase != sticks) expected.row(1) << -3.0, -phase * 0.7, 0.0;
    CHECK(difference(jacobian_of(form, y), expected) < rounded);
  }
}

// A mass above a floor of its own shape, on a spring that grows with time, rubbing against a wall; and a motor beside both.
const auto floor_gap = [](const auto& q) {
  using std::cos;
  return q[1] - 0.2 * cos(q[0]);
};
const auto along = [](const auto& q, const auto& v) {
  using std::sin;
  return v[0] + 0.3 * sin(q[1]) * v[1];
};
const auto motor = controller(
    [](const auto&, const auto&, const auto& z, const auto&) {
      using S = typename std::decay_t<decltype(z)>::Scalar;
      return Vector<S, 2>(z[0] * z[0], S(0.0));
    },
    [](const auto& q, const auto& v, const auto& z, const auto&) {
      using S = typename std::decay_t<decltype(q)>::Scalar;
      return Vector<S, 1>(1.0 - q[1] * z[0] - v[0]);
    },
    Vector<double, 1>(0.5));

TEST_CASE("every combination of phases has the Jacobian that nested duals give, whoever asks in which order") {
  const auto s = scene(
      mechanical_system<2>(
          [](const auto& q, const auto& v) { return (0.7 + 0.1 * q[0] * q[0]) * v[0] * v[0] + 0.4 * v[1] * v[1] + 0.2 * v[0] * v[1]; },
          [](const auto& q, const auto& t) { return g * q[1] + t * q[0] * q[0]; }),
      contact("floor", floor_gap), motor, dry_friction("wall", along, 0.4, 0.7));
  const auto form = first_order_form(s), copy = form;
  REQUIRE(detail::has_traced_jacobian<std::remove_cvref_t<decltype(s)>>);
  for (int round = 0; round < 2; ++round)
    for (const double floor : {apart, closed, 2.0})
      for (const double wall : {-1.0, sticks, 1.0, 2.0}) {
        CAPTURE(floor, wall);
        Vector<double, 7> y;
        y << 0.3, 0.4, -0.5, 0.6, floor, 0.8, wall;
        CHECK(difference(jacobian_of(round == 0 ? form : copy, y), reference(form, y)) < rounded);
      }
}

TEST_CASE("phases are as many as there are: what was recorded first makes room, and is right when it comes again") {
  const auto wall = [](double x) { return [x](const auto& q) { return q[0] - x * q[1] * q[1]; }; };
  const auto rough = [](double c) {
    return [c](const auto& q, const auto& v) { return v[0] + c * q[0] * v[1]; };
  };
  const auto form = first_order_form(scene(mechanical_system<3>(point, [](const auto& q) { return q[0] * q[1] * q[2] + q.squaredNorm(); }),
                                           contact("one", wall(0.3)), dry_friction("two", rough(0.2), 0.3),
                                           dry_friction("three", rough(-0.7), 0.4), dry_friction("four", rough(1.1), 0.1)));
  for (int again = 0; again < 2; ++again)
    for (const double one : {apart, closed})
      for (const double two : {-1.0, 1.0, 2.0})
        for (const double three : {-1.0, 1.0})
          for (const double four : {-1.0, 1.0, 2.0}) {
            Vector<double, 10> y;
            y << 0.3, 0.4, -0.5, 0.6, -0.2, 0.9, one, two, three, four;
            CHECK(difference(jacobian_of(form, y), reference(form, y)) < rounded);
          }
}

TEST_CASE("positions on closed contacts, more of them than can be independent, have the Jacobian that nested duals give") {
  const auto place = [](const auto& q, auto& bodies) {
    using std::cos, std::sin;
    bodies.point_mass(1.0, vector(sin(q[0]), -cos(q[0])));
    bodies.planar_body(0.5, 0.2, vector(sin(q[0]) + 0.5 * sin(q[1]), -cos(q[0]) - 0.5 * cos(q[1])), q[1]);
  };
  const auto gap = [](const auto& q) {
    using std::cos;
    return 1.2 - cos(q[0]) - 0.5 * cos(q[1]);
  };
  const auto twice = [gap](const auto& q) { return 2.0 * gap(q); };
  const auto form = first_order_form(scene(kinematic_system<2>(place, gravity_along<1>(-g)), contact("floor", gap), contact("again", twice)));
  for (const double first : {apart, closed})
    for (const double second : {apart, closed}) {
      CAPTURE(first, second);
      Vector<double, 6> y;
      y << 0.4, 0.9, 0.3, -0.7, first, second;
      CHECK(difference(jacobian_of(form, y), reference(form, y)) < 1e2 * rounded);  // of both, one is as good as the other
    }
}

TEST_CASE("where a method begins, functors that have become others are recorded again in all phases") {
  double stiffness = 1.0;
  auto form = first_order_form(scene(mechanical_system<2>(point, [k = &stiffness](const auto& q) { return 0.5 * *k * q[0] * q[0] + g * q[1]; }),
                                     contact("floor", floor_gap)));
  const auto in = [](double phase) {
    Vector<double, 5> y;
    y << 0.3, 0.4, -0.5, 0.6, phase;
    return y;
  };
  (void)jacobian_of(form, in(apart)), (void)jacobian_of(form, in(closed));
  stiffness = 7.0;
  detail::renew(form);
  CHECK_THAT(jacobian_of(form, in(apart))(2, 0), WithinAbs(-7.0, rounded));
  CHECK(difference(jacobian_of(form, in(closed)), reference(form, in(closed))) < rounded);
}

TEST_CASE("a gap that branches, of which there is no formula, is differentiated as it is") {
  const auto stairs = [](const auto& q) {
    return q[0] < 0.0 ? std::remove_cvref_t<decltype(q[1])>(q[1]) : std::remove_cvref_t<decltype(q[1])>(q[1] - q[0] * q[0]);
  };
  const auto form = first_order_form(scene(mechanical_system<2>(point, weight), contact("stairs", stairs)));
  for (const double x : {-0.3, 0.3})
    for (const double phase : {apart, closed}) {
      CAPTURE(x, phase);
      Vector<double, 5> y;
      y << x, 0.4, -0.5, 0.6, phase;
      CHECK(difference(jacobian_of(form, y), reference(form, y)) < rounded);
    }
}

}  // namespace
