// SPDX-License-Identifier: MIT
#include <cmath>
#include <limits>

#include "../catch2_bridge.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;
using qdot::mechanical_system;
using qdot::Vector;

// A few roundings in a solve with a well-conditioned 2×2 matrix.
constexpr double rounding = 1e-13;

// The lecture's rod of mass M and length L on a pivot, with a ring of mass m sliding on it.
struct RodAndRing {
  double M = 2.0, L = 1.5, m = 0.3, g = 9.81;
  template <class S>
  S T(const Vector<S, 2>& q, const Vector<S, 2>& qdot) const {
    return 0.5 * (M * L * L / 3.0 + m * q[0] * q[0]) * qdot[1] * qdot[1] + 0.5 * m * qdot[0] * qdot[0];
  }
  template <class S>
  S V(const Vector<S, 2>& q) const {
    using std::sin;
    return (m * q[0] + M * L / 2.0) * g * sin(q[1]);
  }
};

TEST_CASE("the rod with the sliding ring accelerates as the lecture derives") {
  // r̈ = r φ̇² − g sin φ;  (I + m r²) φ̈ = −2 m r ṙ φ̇ − (m r + M L/2) g cos φ
  const auto s = mechanical_system<2>(RodAndRing{});
  const Vector2d q(0.4, 0.2);
  const Vector2d v(0.1, 1.0);
  const double I = 2.0 * 1.5 * 1.5 / 3.0 + 0.3 * 0.16;
  const Vector2d a = acceleration(s, q, v);
  CHECK_THAT(a[0], WithinAbs(0.4 - 9.81 * std::sin(0.2), rounding));
  CHECK_THAT(a[1], WithinAbs((-2 * 0.3 * 0.4 * 0.1 - (0.3 * 0.4 + 1.5) * 9.81 * std::cos(0.2)) / I, rounding));
  const Vector2d f = rhs(s, q, v);
  CHECK_THAT(f[0], WithinAbs(0.3 * (0.4 - 9.81 * std::sin(0.2)), rounding));
  CHECK_THAT(f[1], WithinAbs(a[1] * I, rounding));
  CHECK(inverse_dynamics(s, q, v, a).norm() < rounding);
}

TEST_CASE("an accelerated motion needs the force that Lagrange's equations leave over") {
  // Inverse dynamics of a free mass: Q = m a
  const auto s = mechanical_system<2>([](const auto& v) { return 1.5 * v.squaredNorm(); });
  const Vector2d Q = inverse_dynamics(s, Vector2d(1, 2), Vector2d(3, 4), Vector2d(5, -6));
  CHECK(Q == Vector2d(15, -18));
}

TEST_CASE("a drive by explicit time adds the mixed derivative") {
  // A bead on a wire that turns at w, q = distance along it: T = ½(q̇² + w² q²), and the same bead seen
  // through a coordinate that moves with the motor: s = q + ½ b t², T = ½((ṡ − b t)² + w² (s − ½ b t²)²).
  const double w = 3.0;
  const double b = 0.7;
  const auto moving = mechanical_system<1>([=](const auto& q, const auto& v, const auto& t) {
    const auto along = v[0] - b * t;
    const auto distance = q[0] - 0.5 * b * t * t;
    return 0.5 * (along * along + w * w * distance * distance);
  });
  const double t = 1.2;
  const double distance = 0.8 - 0.5 * b * t * t;
  const Vector<double, 1> a = acceleration(moving, Vector<double, 1>(0.8), Vector<double, 1>(0.3), t);
  CHECK_THAT(a[0], WithinAbs(w * w * distance + b, rounding));  // s̈ = q̈ + b
  const Vector<double, 1> force = rhs(moving, Vector<double, 1>(0.8), Vector<double, 1>(0.3), t);
  CHECK_THAT(force[0], WithinAbs(w * w * distance + b, rounding));  // M = 1
}

TEST_CASE("terms linear in the velocities deflect, like a magnetic field") {
  // L = ½ v² + ½ B (x ẏ − y ẋ):  ẍ = B ẏ, ÿ = −B ẋ, in any gauge
  const double B = 2.0;
  const Vector2d q(0.3, -0.2);
  const Vector2d v(0.7, 0.4);
  const auto symmetric = mechanical_system<2>([=](const auto& x, const auto& u) {
    return 0.5 * u.squaredNorm() + 0.5 * B * (x[0] * u[1] - x[1] * u[0]);
  });
  const auto landau =
      mechanical_system<2>([=](const auto& x, const auto& u) { return 0.5 * u.squaredNorm() + B * x[0] * u[1]; });
  CHECK((acceleration(symmetric, q, v) - Vector2d(B * 0.4, -B * 0.7)).norm() < rounding);
  CHECK((acceleration(landau, q, v) - Vector2d(B * 0.4, -B * 0.7)).norm() < rounding);
}

TEST_CASE("a T that is not quadratic has velocity-dependent inertia") {
  // L = ½v² + ¼v⁴ − ½q²:  (1 + 3v²) q̈ = −q
  const auto s = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0] + 0.25 * pow(v[0], 4); },
                                      [](const auto& q) { return 0.5 * q[0] * q[0]; });
  const Vector<double, 1> a = acceleration(s, Vector<double, 1>(0.6), Vector<double, 1>(0.5));
  CHECK_THAT(a[0], WithinAbs(-0.6 / 1.75, rounding));
}

TEST_CASE("accelerations of coordinates that are coupled leave no force over, whatever T is made of") {
  // M is full and depends on velocities; inverse_dynamics() differentiates T by nested duals and solves nothing.
  const auto s = mechanical_system<3>(
      [](const auto& q, const auto& v, const auto& t) {
        using std::cos, std::log, std::sin, std::sqrt;
        const auto together = v[0] * cos(q[1]) + v[1] * sin(q[2]) + v[2], all = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        return 2.0 * all + together * together + 0.3 * v[0] * v[1] * v[2] + sqrt(1.0 + q[0] * q[0] * all) + log(2.0 + q[1] * v[1] * v[1]) +
               0.2 * sin(q[0] * v[2]) + 0.2 * cos(q[2] * v[0] * t) + v[0] * v[1] / (3.0 + q[2] + 0.1 * v[2]);
      },
      [](const auto& q) {
        using std::cos;
        return cos(q[0] - q[1]) * q[2] + q[1] / (2.0 + q[2]);
      });
  const Eigen::Vector3d q(0.4, 0.7, -0.3), v(0.5, -0.8, 0.6);
  const Eigen::Vector3d a = acceleration(s, q, v, 1.2);
  CHECK(inverse_dynamics(s, q, v, a, 1.2).norm() < 10 * rounding * a.norm());
  CHECK(a.norm() > 0.1);
}

TEST_CASE("sizes known at run time give the same accelerations, beyond one pass of duals too") {
  // Uncoupled variable masses: T = ½ Σ (1 + q²) v²  ⇒  (1 + q²) q̈ + q v² = 0
  const auto T = [](const auto& q, const auto& v) {
    auto sum = 0.0 * v[0];
    for (Eigen::Index i = 0; i < q.size(); ++i) sum += 0.5 * (1.0 + q[i] * q[i]) * v[i] * v[i];
    return sum;
  };
  for (const Eigen::Index n : {1, 8, 9, 21}) {
    const VectorXd q = VectorXd::LinSpaced(n, 0.1, 1.0);
    const VectorXd v = VectorXd::LinSpaced(n, -1.0, 2.0);
    const VectorXd expected = -(q.array() * v.array().square()) / (1.0 + q.array().square());
    CHECK((acceleration(mechanical_system(n, T), q, v) - expected).norm() < rounding);
  }
}

TEST_CASE("a function of a kinetic energy has its free motion") {
  // T = f(u), u = (1 + q²) q̇²: u is constant on a free motion, so f drops out of (f′ 2(1 + q²) q̇)˙ = f′ 2q q̇², and q̈ = −q q̇²/(1 + q²).
  const auto T = [](const auto& q, const auto& v) {
    using std::exp;
    auto sum = 0.0 * v[0];
    for (Eigen::Index i = 0; i < q.size(); ++i) sum += exp((1.0 + q[i] * q[i]) * (v[i] * v[i]));
    return sum;
  };
  const VectorXd q = VectorXd::LinSpaced(3, 0.2, 1.0), v = VectorXd::LinSpaced(3, -0.8, 1.0);
  const VectorXd expected = -(q.array() * v.array().square()) / (1.0 + q.array().square());
  CHECK((acceleration(mechanical_system(3, T), q, v) - expected).norm() < rounding);
}

TEST_CASE("the exact Jacobian equals the derivative of the accelerations along every direction") {
  const auto s = mechanical_system<2>(RodAndRing{});
  const Vector2d q(0.4, 0.2);
  const Vector2d v(0.1, 1.0);
  const auto J = acceleration_jacobian(s, q, v);
  CHECK((J.qddot - acceleration(s, q, v)).norm() == 0.0);
  // r̈ = r φ̇² − g sin φ by hand
  CHECK_THAT(J.d_q(0, 0), WithinAbs(1.0, rounding));
  CHECK_THAT(J.d_q(0, 1), WithinAbs(-9.81 * std::cos(0.2), rounding));
  CHECK_THAT(J.d_qdot(0, 1), WithinAbs(2 * 0.4 * 1.0, rounding));
  CHECK_THAT(J.d_qdot(0, 0), WithinAbs(0.0, rounding));
  // φ̈ = −(2 m r ṙ φ̇ + (m r + M L/2) g cos φ)/(I + m r²) by hand
  const double I = 1.5 + 0.3 * 0.16;
  const double phidd = J.qddot[1];
  CHECK_THAT(J.d_q(1, 0),
             WithinAbs((-2 * 0.3 * 0.1 - 0.3 * 9.81 * std::cos(0.2) - phidd * 2 * 0.3 * 0.4) / I, rounding));
  CHECK_THAT(J.d_q(1, 1), WithinAbs((0.3 * 0.4 + 1.5) * 9.81 * std::sin(0.2) / I, rounding));
  CHECK_THAT(J.d_qdot(1, 0), WithinAbs(-2 * 0.3 * 0.4 / I, rounding));
  CHECK_THAT(J.d_qdot(1, 1), WithinAbs(-2 * 0.3 * 0.4 * 0.1 / I, rounding));
}

TEST_CASE("accelerations of duals are differentiated once more") {
  // Two independent routes to ∂q̈/∂q: through the solve, and at fixed q̈.
  const auto s = mechanical_system<2>(RodAndRing{});
  const Vector2d q(0.4, 0.2);
  const Vector2d v(0.1, 1.0);
  const Eigen::Matrix2d through = qdot::jacobian(
      [&](const auto& x) {
        using S = typename std::remove_cvref_t<decltype(x)>::Scalar;
        return acceleration(s, x, Vector<S, 2>(v.cast<S>()));
      },
      q);
  CHECK((through - acceleration_jacobian(s, q, v).d_q).norm() < rounding);
}

TEST_CASE("derivatives of accelerations through quotients are those of accelerations of duals") {
  const auto s = mechanical_system<2>(
      [](const auto& q, const auto& v) { return 0.5 * v[0] * v[0] + 0.5 * (q[0] * q[0] / (1.0 + q[1] * q[1]) + 1.0) * v[1] * v[1]; },
      [](const auto& q) {
        using std::sqrt;
        const auto r = sqrt(q[0] * q[0] + q[1] * q[1]);
        return q[0] / r * q[1] - 2.0 / (1.0 + r);
      });
  const Vector2d q(0.4, 0.7);
  const Vector2d v(0.3, -0.8);
  const auto along = [&](const auto& x, const auto& u) { return acceleration(s, x, u); };
  const Eigen::Matrix2d along_q = qdot::jacobian([&](const auto& x) {
    using S = typename std::remove_cvref_t<decltype(x)>::Scalar;
    return along(x, Vector<S, 2>(v.cast<S>()));
  }, q);
  const Eigen::Matrix2d along_qdot = qdot::jacobian([&](const auto& u) {
    using S = typename std::remove_cvref_t<decltype(u)>::Scalar;
    return along(Vector<S, 2>(q.cast<S>()), u);
  }, v);
  const auto J = acceleration_jacobian(s, q, v);
  CHECK((J.d_q - along_q).norm() < rounding * (1.0 + along_q.norm()));
  CHECK((J.d_qdot - along_qdot).norm() < rounding * (1.0 + along_qdot.norm()));
}

TEST_CASE("the first-order form stacks velocities on accelerations") {
  const auto form = first_order_form(mechanical_system<2>(RodAndRing{}).with_names({"r", "phi"}));
  STATIC_REQUIRE(qdot::FirstOrderSystem<decltype(form)>);
  STATIC_REQUIRE(decltype(form)::size_at_compile_time == 4);
  const Eigen::Vector4d y(0.4, 0.2, 0.1, 1.0);
  VectorXd ydot(4);
  form.derivative(0.0, y, ydot);
  CHECK(ydot.head(2) == Vector2d(0.1, 1.0));
  CHECK_THAT(ydot[0 + 2], WithinAbs(0.4 - 9.81 * std::sin(0.2), rounding));
  Eigen::MatrixXd J(4, 4);
  form.jacobian(0.0, y, J);
  CHECK(J.topLeftCorner(2, 2).isZero());
  CHECK(J.topRightCorner(2, 2).isIdentity());
  CHECK_THAT(J(2, 3), WithinAbs(0.8, rounding));
  CHECK(form.component_name(1) == "phi");
  CHECK(form.component_name(3) == "phidot");
  const auto state = form.state(2.0, y);
  CHECK(state.t == 2.0);
  CHECK(form.packed(state) == y);
}

TEST_CASE("NaN is never handed back as an acceleration") {
  const auto s = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); },
                                      [](const auto& q) { return 1.0 / q[0] + 0.0 * q[1]; })
                     .with_names({"x", "y"});
  const double nan = std::nan("");
  CHECK_THROWS_WITH(acceleration(s, Vector2d(0.0, 1.0), Vector2d(0.0, 0.0)),
                    "the energies must be finite, but V is inf at t = 0; check it there for a division by zero, a root or logarithm outside its "
                    "domain, or overflow");
  CHECK_THROWS_AS(acceleration(s, Vector2d(nan, 1.0), Vector2d(0.0, 0.0)), qdot::NonFinite);
  const auto arc = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) {
    using std::acos;
    return acos(q[0]) + 0.0 * q[1];
  });
  CHECK_THROWS_WITH(acceleration(arc, Vector2d(1.0 + 0x1p-52, 1.0), Vector2d(0.0, 0.0)),
                    "the energies must be finite, but V is nan at t = 0, because acos(x) has no value at x = 1.0000000000000002 (it needs -1 <= x <= 1); check it "
                    "there for a division by zero, a root or logarithm outside its domain, or overflow");
}

TEST_CASE("a state that is not finite is named before the accelerations that follow from it") {
  const auto s = mechanical_system<2>([](const auto& q, const auto& v) { return 0.5 * (v[0] * v[0] + (1.0 + q[0] * q[0]) * v[1] * v[1]); },
                                      [](const auto& q) { return q[0]; })
                     .with_names({"x", "y"});
  CHECK_THROWS_WITH(acceleration(s, Vector2d(1.0, 1.0), Vector2d(0.0, std::numeric_limits<double>::infinity())),
                    "the equations of motion must be finite, but ydot is not at t = 0; check T and V there for a division by zero, a root or "
                    "logarithm outside its domain, or overflow");
}

}  // namespace
