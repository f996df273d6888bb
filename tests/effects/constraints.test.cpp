// SPDX-License-Identifier: MIT
#include <cmath>

#include "../catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/scene_form.hpp"

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using qdot::holonomic;
using qdot::mechanical_system;
using qdot::scene;
using qdot::Vector;

constexpr double g = 9.81;
// Rounding in forces of order ten, through a factorization or two.
constexpr double rounding = 1e-12;

const auto heavy_point = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); },
                                              [](const auto& q) { return g * q[1]; })
                             .with_names({"x", "y"});
const auto circle = [](const auto& q) { return q[0] * q[0] + q[1] * q[1] - 1.0; };

TEST_CASE("the tension of a pendulum pulls towards the pivot with m(g cos θ + v²/l)") {
  // At the bottom with v = 2: 13.81 upwards, λ = −6.905 for φ = x² + y² − 1 and −13.81 for half of it.
  const auto s = scene(heavy_point, holonomic("rod", circle));
  const auto bottom = constrained_acceleration(s, Vector2d(0, -1), Vector2d(2, 0));
  CHECK_THAT(bottom.lambda[0], WithinAbs(-6.905, rounding));
  CHECK((reactions(s, Vector2d(0, -1), Vector2d(2, 0)) - Vector2d(0, 13.81)).norm() < rounding);
  const auto half = scene(heavy_point, holonomic("rod", [](const auto& q) { return 0.5 * circle(q); }));
  CHECK_THAT(constrained_acceleration(half, Vector2d(0, -1), Vector2d(2, 0)).lambda[0], WithinAbs(-13.81, rounding));
  for (const double theta : {-2.0, 0.3, 1.1, 3.0}) {
    const double v = 1.7;
    const Vector2d q(std::sin(theta), -std::cos(theta));
    const Vector2d R = reactions(s, q, v * Vector2d(std::cos(theta), std::sin(theta)));
    CHECK((R + (g * std::cos(theta) + v * v) * q).norm() < rounding);
  }
}

TEST_CASE("a rod with a ring in five coordinates moves as in two, and shows its reactions") {
  // x_G, y_G, φ of the rod (M = 2, L = 1.5), x, y of the ring (m = 0.3); values from the two-coordinate equations
  // by hand: normal force on the ring m(r φ̈ + 2 ṙ φ̇) + m g cos φ = 1.73507903406208.
  const double M = 2.0, L = 1.5, m = 0.3;
  const auto bodies = mechanical_system<5>(
      [=](const auto& v) {
        return 0.5 * M * (v[0] * v[0] + v[1] * v[1]) + 0.5 * (M * L * L / 12.0) * v[2] * v[2] + 0.5 * m * (v[3] * v[3] + v[4] * v[4]);
      },
      [=](const auto& q) { return M * g * q[1] + m * g * q[4]; });
  const auto s = scene(bodies, holonomic("pivot", [=](const auto& q) {
                         using std::cos;
                         using std::sin;
                         return qdot::vector(q[0] - 0.5 * L * cos(q[2]), q[1] - 0.5 * L * sin(q[2]));
                       }),
                       holonomic("ring on the rod", [](const auto& q) {
                         using std::cos;
                         using std::sin;
                         return q[4] * cos(q[2]) - q[3] * sin(q[2]);
                       }));
  const double r = 0.4, phi = 0.2, rdot = 0.1, phidot = 1.0;
  const double c = std::cos(phi), sn = std::sin(phi);
  Vector<double, 5> q, v;
  q << 0.75 * c, 0.75 * sn, phi, r * c, r * sn;
  v << -0.75 * sn * phidot, 0.75 * c * phidot, phidot, rdot * c - r * sn * phidot, rdot * sn + r * c * phidot;
  const auto solution = constrained_acceleration(s, q, v);
  CHECK_THAT(solution.qddot[2], WithinAbs(-10.0771408710391, 1e-11));
  const double along = solution.qddot[3] * c + solution.qddot[4] * sn;  // r̈ − r φ̇²
  CHECK_THAT(along + r * phidot * phidot, WithinAbs(-1.54894613509955, 1e-11));
  CHECK_THAT(solution.lambda[0], WithinAbs(1.53292838, 5e-9));
  CHECK_THAT(solution.lambda[1], WithinAbs(4.50759255, 5e-9));
  CHECK_THAT(solution.lambda[2], WithinAbs(1.73507903406208, 1e-11));
  CHECK(constraint_names(s) == std::vector<std::string>{"pivot[0]", "pivot[1]", "ring on the rod"});
}

TEST_CASE("a redundant constraint changes no motion, and its multipliers have least norm") {
  const auto s = scene(heavy_point, holonomic("rod", circle), holonomic("the same rod", circle));
  const Vector2d q(0.6, -0.8), v(0.8, 0.6);
  const auto solution = constrained_acceleration(s, q, v);
  const auto single = constrained_acceleration(scene(heavy_point, holonomic("rod", circle)), q, v);
  CHECK(solution.rank == 1);
  CHECK((solution.qddot - single.qddot).norm() < rounding);
  CHECK_THAT(solution.lambda[0], WithinAbs(0.5 * single.lambda[0], rounding));
  CHECK_THAT(solution.lambda[1], WithinAbs(0.5 * single.lambda[0], rounding));
}

TEST_CASE("the scale of a constraint changes its multiplier and nothing else") {
  const Vector2d q(0.6, -0.8), v(0.8, 0.6);
  const auto reference = constrained_acceleration(scene(heavy_point, holonomic("rod", circle)), q, v);
  for (const double scale : {1e-6, 1e6}) {
    const auto s = scene(heavy_point, holonomic("rod", [=](const auto& x) { return scale * circle(x); }),
                         holonomic("the same rod", circle));
    const auto solution = constrained_acceleration(s, q, v);
    CHECK(solution.rank == 1);
    CHECK((solution.qddot - reference.qddot).norm() < rounding);
  }
}

TEST_CASE("dependence is judged on rows of one scale: a constraint in micrometres counts beside one in megametres said twice") {
  const auto s = scene(heavy_point, holonomic("side", [](const auto& q) { return 1e6 * q[0]; }),
                       holonomic("side again", [](const auto& q) { return 1e6 * q[0]; }),
                       holonomic("floor", [](const auto& q) { return 1e-6 * q[1]; }));
  const auto solution = constrained_acceleration(s, Vector2d(0, 0), Vector2d(0, 0));
  CHECK(solution.rank == 2);
  CHECK(solution.qddot.norm() < rounding);
  CHECK_THAT(1e-6 * solution.lambda[2], WithinAbs(g, rounding));
}

TEST_CASE("constraints that contradict each other are named") {
  const auto s = scene(heavy_point, holonomic("left", [](const auto& q) { return q[0]; }),
                       holonomic("moving left", [](const auto& q, const auto& t) { return q[0] - t * t; }));
  try {
    constrained_acceleration(s, Vector2d(0, 0), Vector2d(0, 0));
    FAIL("x = 0 and x = t² cannot both hold");
  } catch (const qdot::ConstraintError& e) {
    CHECK((e.constraint() == "left" || e.constraint() == "moving left"));
    CHECK_THAT(e.residual(), WithinAbs(1.0, 1e-9));  // half of the accelerations' difference of 2
    CHECK(std::string(e.what()).find("only 1 of 2 are independent") != std::string::npos);
  }
}

TEST_CASE("a massless coordinate is solved for when a constraint determines it") {
  // M = diag(1, 0), J = (0, 1), f = (1, 2), J q̈ = 3:  q̈ = (1, 3), λ = −2
  const auto s = scene(mechanical_system<2>([](const auto& v) { return 0.5 * v[0] * v[0] + 0.0 * v[1]; },
                                            [](const auto& q) { return -q[0] - 2.0 * q[1]; }),
                       holonomic("guide", [](const auto& q, const auto& t) { return q[1] - 1.5 * t * t; }));
  const auto solution = constrained_acceleration(s, Vector2d(0, 0), Vector2d(0, 0));
  CHECK((solution.qddot - Vector2d(1, 3)).norm() < rounding);
  CHECK_THAT(solution.lambda[0], WithinAbs(-2.0, rounding));
}

TEST_CASE("a massless coordinate that no constraint determines is named") {
  const auto s = scene(mechanical_system<2>([](const auto& v) { return 0.5 * v[0] * v[0] + 0.0 * v[1]; }).with_names({"x", "y"}),
                       holonomic("guide", [](const auto& q) { return q[0]; }));
  try {
    constrained_acceleration(s, Vector2d(0, 0), Vector2d(0, 0));
    FAIL("y has neither inertia nor a constraint");
  } catch (const qdot::SingularMassMatrix& e) {
    CHECK(std::string(e.what()).find("velocity along y has neither") != std::string::npos);
  }
}

TEST_CASE("the drive of a prescribed coordinate shows the force that it needs") {
  // A mass driven along x(t) = sin 2t needs m ẍ = −4 sin 2t.
  const auto s = scene(mechanical_system<1>([](const auto& v) { return 0.5 * 3.0 * v.squaredNorm(); }),
                       qdot::prescribed("motor", 0, [](const auto& t) {
                         using std::sin;
                         return sin(2.0 * t);
                       }));
  const double t = 0.4;
  const Vector<double, 1> q(std::sin(2 * t)), v(2 * std::cos(2 * t));
  CHECK_THAT(constrained_acceleration(s, q, v, t).lambda[0], WithinAbs(-12.0 * std::sin(2 * t), rounding));
}

TEST_CASE("a cylinder rolling down an incline is slowed by its friction") {
  // x = s along the incline, θ rolling: constraint ẋ − R θ̇ = 0. a = g sin α/(1 + κ), friction κ m g sin α/(1 + κ).
  const double alpha = 0.3, R = 0.7, m = 2.0, kappa = 0.5;
  const auto s = scene(mechanical_system<2>([=](const auto& v) { return 0.5 * m * (v[0] * v[0] + kappa * R * R * v[1] * v[1]); },
                                            [=](const auto& q) { return -m * g * std::sin(alpha) * q[0]; }),
                       qdot::nonholonomic("rolling", [=](const auto&, const auto& v) { return v[0] - R * v[1]; }));
  const auto solution = constrained_acceleration(s, Vector2d(0, 0), Vector2d(R, 1));
  CHECK_THAT(solution.qddot[0], WithinAbs(1.93270215156516, 1e-12));
  CHECK_THAT(-solution.lambda[0], WithinAbs(kappa * m * g * std::sin(alpha) / 1.5, rounding));
}

TEST_CASE("a skate feels only the force across its blade") {
  // Chaplygin sleigh with G a = 0.5 ahead of the blade, as the notes of the lecture write it:
  // v̇ = a ω², (I + m a²) ω̇ = −m a v ω for velocity v along the blade.
  const double m = 1.0, a = 0.5, I = 0.3;
  const auto s = scene(mechanical_system<3>([=](const auto& q, const auto& v) {
                         using std::cos;
                         using std::sin;
                         const auto vx = v[0] - a * sin(q[2]) * v[2];
                         const auto vy = v[1] + a * cos(q[2]) * v[2];
                         return 0.5 * m * (vx * vx + vy * vy) + 0.5 * I * v[2] * v[2];
                       }),
                       qdot::nonholonomic("blade", [](const auto& q, const auto& v) {
                         using std::cos;
                         using std::sin;
                         return v[1] * cos(q[2]) - v[0] * sin(q[2]);
                       }));
  const double theta = 0.4, v = 0.8, w = 1.3;
  const Vector3d a3 = acceleration(s, Vector3d(0, 0, theta), Vector3d(v * std::cos(theta), v * std::sin(theta), w));
  const double along = a3[0] * std::cos(theta) + a3[1] * std::sin(theta);
  CHECK_THAT(along, WithinAbs(a * w * w, rounding));
  CHECK_THAT(a3[2], WithinAbs(-m * a * v * w / (I + m * a * a), rounding));
}

TEST_CASE("accelerations satisfy the differentiated constraints") {
  const auto s = scene(heavy_point, holonomic("rod", [](const auto& q, const auto& t) { return circle(q) - 0.1 * t * t; }));
  const Vector2d q(0.6, -0.8), v(0.3, 0.9);
  const Vector2d a = acceleration(s, q, v, 0.7);
  // φ̈ = 2 v·v + 2 q·a − 0.2
  CHECK_THAT(2 * v.squaredNorm() + 2 * q.dot(a) - 0.2, WithinAbs(0.0, rounding));
}

TEST_CASE("the Jacobian of a constrained scene is the derivative of its accelerations") {
  // By hand for the circle: q̈ = f + 2 q λ, λ = −(v² + f·q)/(2 q²) with f = (0, −g).
  const auto form = first_order_form(scene(heavy_point, holonomic("rod", circle)));
  const Vector2d q(0.6, -0.8), v(0.8, 0.6);
  const auto by_hand = [](const auto& y) {
    using S = typename std::remove_cvref_t<decltype(y)>::Scalar;
    const S q2 = y[0] * y[0] + y[1] * y[1];
    const S factor = -(y[2] * y[2] + y[3] * y[3] - g * y[1]) / q2;
    return Vector<S, 2>(factor * y[0], S(-g) + factor * y[1]);
  };
  Eigen::Vector4d y;
  y << q, v;
  Eigen::MatrixXd J(4, 4);
  form.jacobian(0.0, y, J);
  CHECK((J.bottomRows(2) - qdot::jacobian(by_hand, y)).norm() < rounding);
}

TEST_CASE("projection finds the nearest state on the constraints and reports what moved") {
  const auto s = scene(heavy_point, holonomic("rod", circle));
  const auto result = consistent_state(s, qdot::State<2>{0.0, Vector2d(0.9, -1.2), Vector2d(1.0, 1.0)});
  // The nearest point of the circle is along the radius, the nearest velocity is the tangential part.
  CHECK((result.state.q - Vector2d(0.6, -0.8)).norm() < rounding);
  CHECK((result.state.qdot - 1.4 * Vector2d(0.8, 0.6)).norm() < rounding);
  CHECK_THAT(result.report.moved_q, WithinAbs(0.4, rounding));
  CHECK_THAT(result.report.residual_before, WithinAbs(1.25, rounding));
  CHECK(result.report.residual < 1e-15);
  CHECK(result.report.rank == 1);
}

TEST_CASE("projection moves a heavy coordinate less than a light one") {
  // x + y = 1 with masses 1 and 4 from (0, 0): moves in the ratio 4 to 1.
  const auto s = scene(mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + 4.0 * v[1] * v[1]); }),
                       holonomic("sum", [](const auto& q) { return q[0] + q[1] - 1.0; }));
  const auto result = consistent_state(s, qdot::State<2>{0.0, Vector2d(0, 0), Vector2d(1, 0)});
  CHECK((result.state.q - Vector2d(0.8, 0.2)).norm() < rounding);
  CHECK((result.state.qdot - Vector2d(0.2, -0.2)).norm() < rounding);
}

TEST_CASE("projection onto redundant constraints works, and onto contradicting ones is refused by name") {
  const auto twice = scene(heavy_point, holonomic("rod", circle), holonomic("again", circle));
  CHECK((consistent_state(twice, qdot::State<2>{0.0, Vector2d(0.9, -1.2), Vector2d(0, 0)}).state.q - Vector2d(0.6, -0.8)).norm() <
        rounding);
  const auto impossible = scene(heavy_point, holonomic("at one", [](const auto& q) { return q[0] - 1.0; }),
                                holonomic("at two", [](const auto& q) { return q[0] - 2.0; }));
  CHECK_THROWS_AS(consistent_state(impossible, qdot::State<2>{0.0, Vector2d(0, 0), Vector2d(0, 0)}), qdot::ConstraintError);
}

TEST_CASE("a moving constraint is met with its velocity") {
  const auto s = scene(heavy_point, qdot::prescribed("motor", 0, [](const auto& t) { return 3.0 * t; }));
  const auto result = consistent_state(s, qdot::State<2>{2.0, Vector2d(5.9, 1.0), Vector2d(0, 7)});
  CHECK((result.state.q - Vector2d(6, 1)).norm() < rounding);
  CHECK((result.state.qdot - Vector2d(3, 7)).norm() < rounding);
}

TEST_CASE("an initial state with NaN is refused") {
  const auto s = scene(heavy_point, holonomic("rod", circle));
  CHECK_THROWS_AS(consistent_state(s, qdot::State<2>{0.0, Vector2d(std::nan(""), 0), Vector2d(0, 0)}), qdot::InvalidValue);
}

}  // namespace
