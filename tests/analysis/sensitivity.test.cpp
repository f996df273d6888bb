// SPDX-License-Identifier: MIT
#include "qdot/analysis/sensitivity.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <type_traits>
#include <utility>

#include "catch2_bridge.hpp"
#include "qdot/analysis/adjoint.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/dry_friction.hpp"
#include "scenes/double_pendulum.hpp"
#include "systems/double_pendulum_of_parameters.hpp"

using qdot::Dop853;
using qdot::event;
using qdot::events;
using qdot::adjoint_sensitivities;
using qdot::Options;
using qdot::Outcome;
using qdot::problem;
using qdot::scene;
using qdot::sensitivities;
using qdot::State;

namespace {

const systems::DoublePendulumFamily energies_of;
const Options fine{.rtol = 1e-13, .atol = 1e-14};

// One coordinate; one type for all potentials, and one for all events and actions, for the compiler's sake.
struct Particle {
  double g = 0.0;                   // g q
  double k = 0.0, s = 0.0;          // ½ (k − 2s cos 2t) q²
  double pull = 0.0;                // −pull cos q
  double drive = 0.0;               // −drive q cos t
  double push = 0.0;                // −push q exp(−200 (t − 50)²)
  const double* switched = nullptr;  // −switched q
  double m = 1.0;

  auto T(const auto& v) const { return 0.5 * m * v[0] * v[0]; }
  auto V(const auto& q, const auto& t) const {
    using std::cos, std::exp;
    return (g - (switched != nullptr ? *switched : 0.0) - push * exp(-200.0 * (t - 50.0) * (t - 50.0))) * q[0] +
           0.5 * (k - 2 * s * cos(2.0 * t)) * q[0] * q[0] - pull * cos(q[0]) - drive * q[0] * cos(t);
  }
};
auto particle(Particle p) { return qdot::mechanical_system<1>(p); }

using V1 = qdot::Vector<double, 1>;
using Function = std::function<double(const V1&, const V1&)>;
using Action = std::function<void(State<1>&)>;
auto crossing(std::string name, Function g) { return event(std::move(name), std::move(g)); }
const auto place = [](const auto& q) { return q[0]; };
const Function height = [](const V1& q, const V1&) { return q[0]; }, velocity = [](const V1&, const V1& v) { return v[0]; };

// A floor that moves at the speed a.
struct Gap {
  double a = 0.0, t0 = 0.0;
  auto operator()(const auto& q, const auto& t) const { return q[0] - a * (t - t0); }
};
// A ball above it, p = (g, e, a, y₀, v₀, and something that nothing depends on).
using SixNumbers = qdot::Vector<double, 6>;
struct OverFloor {
  double t0 = 0.0;
  auto operator()(const SixNumbers& p) const {
    return problem(scene(particle({.g = p[0]}), qdot::contact("floor", Gap{p[2], t0}, qdot::restitution(p[1]))), State<1>{t0, {p[3]}, {p[4]}});
  }
};
const OverFloor over_floor;

// A weight on an arm and another one that slides on it, held by forces of many kinds.
struct Weights {
  double m = 1.3, g = 9.81;
  auto T(const auto& q, const auto& v) const {
    const auto r = 1.0 + q[1] * q[1];
    return 0.5 * m * (r * r * v[0] * v[0] + (1.0 + 4.0 * q[1] * q[1]) * v[1] * v[1]);
  }
  auto V(const auto& q) const {
    using std::atan, std::cos, std::cosh, std::exp, std::hypot, std::log, std::pow, std::sin, std::sqrt, std::tanh;
    return -(m * g) * (1.0 + q[1] * q[1]) * cos(q[0]) + sqrt(2.0 + sin(q[1])) + exp(-q[0]) + log(3.0 + q[1] * q[1]) + tanh(q[0]) * q[1] + cosh(q[1]) +
           pow(2.0 + cos(q[0]), 1.7) + hypot(1.0 + q[0] * q[0], q[1]) + atan(q[0] - q[1]);
  }
};

// A rotor on a spring in gravity, T = ½ l² v², V = ½ k q² − g l cos q, with parameters l and k.
template <class S>
struct Rotor {
  S l, k;
  double g;
  auto T(const auto& v) const { return 0.5 * l * l * v[0] * v[0]; }
  auto V(const auto& q) const {
    using std::cos;
    return 0.5 * k * q[0] * q[0] - g * l * cos(q[0]);
  }
};
struct RotorOf {
  double g;
  auto operator()(const auto& p) const { return Rotor<std::remove_cvref_t<decltype(p[0])>>{p[0], p[1], g}; }
};

}  // namespace

// Computed with heyoka's variational equations in long double; all digits shown there agree between 1e-18 and 1e-20 as tolerance.
TEST_CASE("the double pendulum's tangent at t = 3 has the digits of a computation in extended precision") {
  constexpr double error = 2e-11;
  Eigen::Matrix4d expected;
  expected << 0.42512535360011335, 0.32234325900511527, -0.11480303301727812, -0.32188377823700566,  //
      0.35375523822508861, -0.12147143371945361, 0.03465925719707716, 0.61006975762812077,           //
      3.55481773398585877, 2.52890401856926854, 0.87795461024674466, -0.09322081715396367,           //
      2.95323559692079771, -0.59978990735865972, 0.20286440439106009, 1.95089499890557590;
  const auto system = qdot::mechanical_system<2>(qdot::scenes::DoublePendulum{});
  const auto s = sensitivities(system, State<2>{0.0, {1.7, 1.7}, {0, 0}}, 3.0, Dop853{}, fine);
  REQUIRE(s.completed());
  CHECK((s.Phi - expected).cwiseAbs().maxCoeff() < error);
  CHECK(s.Phi_at(0.0).isIdentity(0.0));
}

TEST_CASE("derivatives by the time of the start are the same without those by the start") {
  const auto system = qdot::mechanical_system<2>(Weights{});
  const State<2> start{0.0, {0.4, 0.9}, {0.3, -0.2}};
  const auto by_time = sensitivities(system, start, 2.0, Dop853{}, fine, {}, {.start = false, .start_time = true});
  const auto by_both = sensitivities(system, start, 2.0, Dop853{}, fine, {}, {.start_time = true});
  CHECK((by_time.Phi - by_both.d_start_time()).cwiseAbs().maxCoeff() < 1e-10);
}

TEST_CASE("a ball that bounces three times depends on g, e, h and the end as the closed form says") {
  constexpr double error = 1e-10;
  const auto by_action = [](const SixNumbers& p) {
    const auto ball = particle({.g = p[0]});
    const auto bounce = qdot::impact(ball, Gap{}, qdot::restitution(p[1]));
    return problem(ball, State<1>{0.0, {p[3]}, {p[4]}}, events(crossing("floor", height).falling().action(bounce)));
  };
  SixNumbers p;
  p << 9.8, 0.8, 0.0, 50.0, 0.0, 3.0;
  const auto check = [&](const auto& s) {
    INFO(s.message);
    REQUIRE(s.completed());
    REQUIRE(s.events.size() == 3);
    CHECK_THAT(s.y[0], WithinAbs(8.494217007606032792, error));
    CHECK_THAT(s.Phi(0, 0), WithinAbs(-7.277029744509896286, error));
    CHECK_THAT(s.Phi(0, 1), WithinAbs(314.568839957685554, 100 * error));
    CHECK_THAT(s.Phi(0, 3), WithinAbs(1.596182170076060328, error));
    CHECK_THAT(s.ydot[0], WithinAbs(-9.508652199492931147, error));
    CHECK(s.Phi.col(5).isZero(0.0));  // nothing depends on it
    // t₁ = √(2h/g)
    CHECK_THAT(s.events[0].time[0], WithinAbs(-0.5 * std::sqrt(2 * 50 / 9.8) / 9.8, error));
    CHECK_THAT(s.events[0].time[1], WithinAbs(0.0, error));
    CHECK_THAT(s.events[0].time[3], WithinAbs(0.5 * std::sqrt(2 / (9.8 * 50)), error));
  };
  check(sensitivities(by_action, p, 15.0, Dop853{}, fine));
  const auto s = sensitivities(over_floor, p, 15.0, Dop853{}, fine);
  check(s);
  const auto backwards = adjoint_sensitivities(over_floor, p, 15.0, qdot::end_value(place), Dop853{}, fine);
  REQUIRE(backwards.completed());
  CHECK_THAT(backwards.by_parameters[0], WithinAbs(-7.277029744509896286, error));
  CHECK_THAT(backwards.by_parameters[1], WithinAbs(314.568839957685554, 100 * error));
  CHECK_THAT(backwards.by_parameters[3], WithinAbs(1.596182170076060328, error));
  CHECK(backwards.by_parameters[5] == 0.0);
}

TEST_CASE("parameters of T and V have the same derivatives exactly and by a family") {
  constexpr double error = 1e-9;  // the family's, 1e-12 of ∂f/∂p, grown a hundredfold by the motion
  qdot::Vector<double, 5> p;
  p << 1.0, 0.7, 1.1, 0.9, 9.81;
  const State<2> start{0.0, {1.7, 1.2}, {0.3, -0.2}};
  const auto exactly = sensitivities(energies_of, p, start, 3.0, Dop853{}, fine);
  const auto by_family = sensitivities(
      [&](const qdot::Vector<double, 5>& x) {
        return problem(qdot::mechanical_system<2>(systems::DoublePendulumOf<double>{x[0], x[1], x[2], x[3], x[4]}), start);
      },
      p, 3.0, Dop853{}, fine);
  REQUIRE(exactly.completed());
  REQUIRE(by_family.completed());
  REQUIRE(exactly.d_parameters().cols() == 5);
  REQUIRE(by_family.Phi.cols() == 5);
  CHECK((exactly.d_parameters() - by_family.Phi).cwiseAbs().maxCoeff() < error);
  // Masses that all grow alike change nothing,
  CHECK((exactly.d_parameters().col(0) * p[0] + exactly.d_parameters().col(1) * p[1]).norm() < error);
  // nor does another unit of length, in which lengths and g grow alike.
  CHECK((exactly.d_parameters().rightCols(3) * p.tail(3)).norm() < error);
}

TEST_CASE("in coordinates and momenta the tangent of a free motion is symplectic") {
  const auto system = qdot::mechanical_system<2>(qdot::scenes::DoublePendulum{});
  const State<2> start{0.0, {1.7, 1.7}, {0.4, -0.3}};
  const auto s = sensitivities(system, start, 3.0, Dop853{}, fine);
  // ∂(q, p)/∂(q, q̇), the lower left block by a formula: p = M(q₀ − q₁) q̇.
  const auto momenta = [](const State<2>& at) {
    const double c = std::cos(at.q[0] - at.q[1]), d = std::sin(at.q[0] - at.q[1]);
    Eigen::Matrix4d P = Eigen::Matrix4d::Identity();
    P.bottomRightCorner<2, 2>() << 2, c, c, 1;
    P.bottomLeftCorner<2, 2>() << -d * at.qdot[1], d * at.qdot[1], -d * at.qdot[0], d * at.qdot[0];
    return P;
  };
  Eigen::Matrix4d J = Eigen::Matrix4d::Zero();
  J.topRightCorner<2, 2>().setIdentity();
  J.bottomLeftCorner<2, 2>() = -Eigen::Matrix2d::Identity();
  for (const double t : {1.0, 2.2, 3.0}) {
    const Eigen::Matrix4d A = momenta(s.at(t)) * s.Phi_at(t) * momenta(start).inverse();
    CHECK((A.transpose() * J * A - J).cwiseAbs().maxCoeff() < 1e-10);
  }
}

// x'' + (a − 2q cos 2t) x = 0: traces by mpmath with 30 digits.
TEST_CASE("the monodromy matrix of Mathieu's equation has the trace that is known") {
  struct {
    double a, q, trace;
  } const known[] = {{1, 1, -4.396667734798867851}, {2, 1, -1.554649354176467812}, {-0.2, 1, -1.175676878379037784},
                     {0.5, 2, -14.00643323264104821}, {10, 5, -2.523257698715790277}};
  for (const auto& [a, q, trace] : known) {
    const auto s = sensitivities(particle({.k = a, .s = q}), State<1>{0.0, {0.3}, {0.1}}, std::numbers::pi, Dop853{}, fine);
    CHECK_THAT(s.Phi.trace(), WithinAbs(trace, 1e-11));
  }
}

// t_M = π/(2√k), and the amplitude 1/√k.
TEST_CASE("the time and the place of an oscillator's first turn depend on its stiffness as the closed form says") {
  const double k = 0.456;
  const auto s = sensitivities(RotorOf{0.0}, Eigen::Vector2d(1.0, k), State<1>{0.0, {0.0}, {1.0}}, 100.0, Dop853{}, fine,
                               events(crossing("turn", velocity).stop()), {.start = false});
  REQUIRE(s.outcome == Outcome::stopped_by_event);
  REQUIRE(s.events.size() == 1);
  CHECK_THAT(s.events[0].time[1], WithinAbs(-2.550601538829664222, 1e-11));
  CHECK_THAT(s.Phi_of_event(0, 1), WithinAbs(-0.5 * std::pow(k, -1.5), 1e-11));
  CHECK_THAT(s.Phi_of_event(1, 1), WithinAbs(0.0, 1e-11));
}

// T = 4 K(sin(A/2)) for g = l: digits by the arithmetic-geometric mean and its derivative.
TEST_CASE("a pendulum's period depends on its amplitude as the elliptic integral says") {
  const auto s = sensitivities(particle({.pull = 1.0}), State<1>{0.0, {1.3}, {0.0}}, 9.0, Dop853{}, fine, events(crossing("half a period", velocity).rising()));
  REQUIRE(s.events.size() == 1);
  CHECK_THAT(2 * s.events[0].t, WithinAbs(7.019250311844546549770542, 1e-11));
  CHECK_THAT(2 * s.events[0].time[0], WithinAbs(1.258165472401305335, 1e-10));
}

TEST_CASE("an impact on a moving floor depends on everything as the closed form says") {
  // y = y₀ + v₀ t − g t²/2 meets the floor a t once before T = 1.
  const auto closed_form = [](const auto& p) {
    using std::sqrt;
    const auto &g = p[0], &e = p[1], &a = p[2], &y0 = p[3], &v0 = p[4];
    const double T = 1.0;
    const auto t1 = ((v0 - a) + sqrt((v0 - a) * (v0 - a) + 2.0 * g * y0)) / g;
    const auto v = a - e * (v0 - g * t1 - a);
    qdot::Vector<std::remove_cvref_t<decltype(t1)>, 3> y;
    y << a * t1 + v * (T - t1) - 0.5 * g * (T - t1) * (T - t1), v - g * (T - t1), t1;
    return y;
  };
  SixNumbers p;
  p << 9.81, 0.7, 0.4, 1.0, 0.5, 0.0;
  const auto s = sensitivities(over_floor, p, 1.0, Dop853{}, fine);
  const auto expected = qdot::value_and_jacobian(closed_form, p);
  REQUIRE(s.completed());
  REQUIRE(s.events.size() == 1);
  CHECK((s.y.head(2) - expected.value.head<2>()).norm() < 1e-12);
  CHECK((s.Phi.topRows(2) - expected.jacobian.topRows<2>()).cwiseAbs().maxCoeff() < 1e-10);
  CHECK((s.events[0].time - expected.jacobian.row(2).transpose()).cwiseAbs().maxCoeff() < 1e-11);
  const auto backwards = adjoint_sensitivities(over_floor, p, 1.0, qdot::end_value(place), Dop853{}, fine);
  REQUIRE(backwards.completed());
  CHECK((backwards.by_parameters - expected.jacobian.row(0).transpose()).cwiseAbs().maxCoeff() < 1e-10);

  const double t0 = 1.7e9, grain = 2.4e-7;  // of the time there: when it hits is not known better
  const auto late = sensitivities(OverFloor{t0}, p, t0 + 1.0, Dop853{}, fine);
  REQUIRE(late.completed());
  CHECK((late.Phi.topRows(2) - expected.jacobian.topRows<2>()).cwiseAbs().maxCoeff() < 10 * grain);
}

TEST_CASE("no step passes over a push that comes when nothing has moved for long") {
  const auto s = sensitivities(particle({.push = 1.0}), State<1>{0.0, {0.0}, {0.0}}, 100.0, Dop853{}, fine);
  REQUIRE(s.completed());
  const double reached = std::sqrt(std::numbers::pi / 200);
  CHECK_THAT(s.y[1], WithinAbs(reached, 1e-11));
  CHECK_THAT(s.y[0], WithinAbs(50 * reached, 1e-9));
}

TEST_CASE("a block that friction brings to rest keeps the derivatives of where it stopped, and one that sticks and slips has those of differences") {
  const auto family = [](const Eigen::Vector4d& p) {  // stiffness, friction, drive, and velocity at the start
    return problem(scene(particle({.k = p[0], .drive = p[2]}), qdot::dry_friction("floor", 0, p[1], 1.3 * p[1])), State<1>{0.0, {0.0}, {p[3]}});
  };
  const double v0 = 2.0, F = 1.5;
  const auto stops = sensitivities(family, Eigen::Vector4d(0.0, F, 0.0, v0), 5.0, Dop853{}, fine);
  REQUIRE(stops.completed());
  REQUIRE(stops.events.size() == 1);
  CHECK_THAT(stops.y[0], WithinAbs(v0 * v0 / (2 * F), 1e-12));
  CHECK_THAT(stops.Phi(0, 1), WithinAbs(-v0 * v0 / (2 * F * F), 1e-11));
  CHECK_THAT(stops.Phi(0, 3), WithinAbs(v0 / F, 1e-11));
  CHECK(stops.Phi.row(1).norm() < 1e-12);
  CHECK_THAT(stops.events[0].time[3], WithinAbs(1 / F, 1e-11));

  const Eigen::Vector4d p(4.0, 0.9, 3.5, 0.2);
  const auto s = sensitivities(family, p, 12.0, Dop853{}, fine);
  REQUIRE(s.completed());
  REQUIRE(s.events.size() >= 4);
  constexpr double h = 2e-4;
  const Eigen::Vector4d along(1.0, 0.5, -0.7, 0.3);
  const auto sum = [&](int k) {
    const auto end = [&](double d) { return Eigen::Vector2d(sensitivities(family, Eigen::Vector4d(p + d * along), 12.0, Dop853{}, fine).y.head(2)); };
    return Eigen::Vector2d(end(k * h) - end(-k * h));
  };
  const Eigen::Vector2d slope = (45 * sum(1) - 9 * sum(2) + sum(3)) / (60 * h);
  CHECK((s.Phi.topRows(2) * along - slope).norm() < 1e-7);  // noise of 1e-12 over h, grown by the motion
  const auto backwards = adjoint_sensitivities(family, p, 12.0, qdot::end_value(place), Dop853{}, fine);
  INFO(backwards.message);
  REQUIRE(backwards.completed());
  CHECK((backwards.by_parameters - s.Phi.row(0).transpose()).norm() < 1e-10);
}

TEST_CASE("a block that sticks as it begins depends on its mass, its spring and its friction as the closed form says") {
  using D = qdot::Dual<double, 5>;
  constexpr double differenced = 1e-9;  // order six over a hundredth of F_s, which t₁ = acos(…) is not far from the end of
  const double drive = 2.0, T = 3.3;
  const Eigen::VectorXd nominal{{1.5, 2.0, 2.1, 2.7, 0.7}};  // mass, stiffness, friction that slides and that sticks, start
  const auto family = [drive](const Eigen::VectorXd& p) {
    return problem(scene(particle({.k = p[1], .drive = drive, .m = p[0]}), qdot::dry_friction("floor", 0, p[2], p[3])), State<1>{0.0, {p[4]}, {0.0}});
  };
  const auto s = sensitivities(family, nominal, T, Dop853{}, fine);
  INFO(s.message);
  REQUIRE(s.completed());
  REQUIRE(s.events.size() == 1);
  const auto x = [&nominal](int j) { return D::variable(nominal[j], j); };
  const D m = x(0), k = x(1), slides = x(2), q0 = x(4), w = sqrt(k / m), swing = drive / (k - m);
  const D t1 = acos((k * q0 - x(3)) / drive), s1 = T - t1;  // where drive cos t − k q₀ = −F_s
  const D q = swing * std::cos(T) + slides / k + (q0 - swing * cos(t1) - slides / k) * cos(w * s1) + swing * sin(t1) / w * sin(w * s1);
  CHECK_THAT(s.y[0], WithinAbs(q.value, 1e-12));
  for (Eigen::Index j = 0; j < 5; ++j) {
    CHECK_THAT(s.Phi(0, j), WithinAbs(q.tangent[static_cast<std::size_t>(j)], differenced));
    CHECK_THAT(s.events[0].time[j], WithinAbs(t1.tangent[static_cast<std::size_t>(j)], 1e-10));
  }
}

TEST_CASE("a block on a moving belt that slips, sticks and slips depends on everything as the closed form says") {
  constexpr double error = 1e-10;
  using D = qdot::Dual<double, 4>;
  const Eigen::Vector4d nominal(4.0, 1.3, 0.35, 1.7);  // stiffness, friction, speed of the belt, start
  const auto family = [](const Eigen::VectorXd& p) {
    const double belt = p[2];
    return problem(scene(particle({.k = p[0]}),
                         qdot::dry_friction("belt", [belt](const auto&, const auto& v) { return v[0] - belt; }, p[1])),
                   State<1>{0.0, {p[3]}, {0.0}});
  };
  const double T = 9.0;
  const auto s = sensitivities(family, Eigen::VectorXd(nominal), T, Dop853{}, fine);
  REQUIRE(s.completed());
  REQUIRE(s.events.size() == 4);

  // Arcs of circles about ±F/k while it slips; it is as fast as the belt at t₁ and t₂, sticks at t₃ and slips at t₄.
  const auto x = [&nominal](int j) { return D::variable(nominal[j], j); };
  const D k = x(0), F = x(1), belt = x(2), w = sqrt(k), centre = F / k, A = x(3) - centre;
  const D t1 = (std::numbers::pi + asin(belt / (w * A))) / w;
  const D a = centre + A * cos(w * t1) + centre, t2 = t1 - 2.0 * atan2(a * w, belt) / w;
  const D b = -centre - a - centre, t3 = t2 + (2 * std::numbers::pi - 2.0 * atan2(b * w, belt)) / w;
  const D t4 = t3 + b / belt;
  const D q = centre + belt / w * sin(w * (T - t4)), v = belt * cos(w * (T - t4));
  CHECK_THAT(s.y[0], WithinAbs(q.value, error));
  CHECK_THAT(s.y[1], WithinAbs(v.value, error));
  for (std::size_t j = 0; j < 4; ++j) {
    const auto column = static_cast<Eigen::Index>(j);
    CHECK_THAT(s.Phi(0, column), WithinAbs(q.tangent[j], error));
    CHECK_THAT(s.Phi(1, column), WithinAbs(v.tangent[j], error));
    CHECK_THAT(s.events[3].time[column], WithinAbs(t4.tangent[j], error));
  }
  const auto backwards = adjoint_sensitivities(family, Eigen::VectorXd(nominal), T, qdot::end_value(place), Dop853{}, fine);
  INFO(backwards.message);
  REQUIRE(backwards.completed());
  for (int j = 0; j < 4; ++j) CHECK_THAT(backwards.by_parameters[j], WithinAbs(q.tangent[static_cast<std::size_t>(j)], error));
}

TEST_CASE("equations that an event switches have continuous states and a jump of Φ") {
  double gravity = 0.0;  // begins at x = 1
  const auto system = particle({.switched = &gravity});
  const double v0 = 0.8, x0 = 0.1, T = 3.0, t1 = (1 - x0) / v0;
  const auto s =
      sensitivities(system, State<1>{0.0, {x0}, {v0}}, T, Dop853{}, fine,
                    events(crossing("field", [](const V1& q, const V1&) { return q[0] - 1.0; }).rising().action(Action([&gravity](State<1>&) {
                      gravity = 2.0;
                    })),
                           crossing("half way", [](const V1& q, const V1&) { return q[0] - 0.5; })));
  REQUIRE(s.completed());
  REQUIRE(s.events.size() == 2);
  CHECK(s.events[0].time.size() == 0);  // the equations of then are gone
  CHECK_THAT(s.events[1].time[0], WithinAbs(-1 / v0, 1e-11));
  // x = 1 + v₀ (T − t₁) + (T − t₁)², v = v₀ + 2 (T − t₁)
  const double dt_dx = -1 / v0, dt_dv = -(1 - x0) / (v0 * v0), late = T - t1;
  Eigen::Matrix2d expected;
  expected << -(v0 + 2 * late) * dt_dx, late - (v0 + 2 * late) * dt_dv, -2 * dt_dx, 1 - 2 * dt_dv;
  CHECK((s.Phi - expected).cwiseAbs().maxCoeff() < 1e-11);
  CHECK((s.Phi_before(s.events[1].t) - (Eigen::Matrix2d() << 1, t1, 0, 1).finished()).cwiseAbs().maxCoeff() < 1e-11);
  gravity = 0.0;
  const auto backwards = adjoint_sensitivities(
      system, State<1>{0.0, {x0}, {v0}}, T, qdot::end_value(place), Dop853{}, fine,
      events(crossing("field", [](const V1& q, const V1&) { return q[0] - 1.0; }).rising().action(Action([&gravity](State<1>&) {
        gravity = 2.0;
      })),
             crossing("half way", [](const V1& q, const V1&) { return q[0] - 0.5; })));
  CHECK(backwards.outcome == Outcome::not_differentiable);
  CHECK(backwards.message.find("an action changes what functors read") != std::string::npos);
}

TEST_CASE("behind an event that switches them, traced equations of a number of coordinates known at run time are the new ones") {
  double gravity = 0.0;  // begins at x = 1
  const auto system = qdot::mechanical_system(1, Particle{.switched = &gravity});
  const double v0 = 0.8, x0 = 0.1, T = 3.0, t1 = (1 - x0) / v0, late = T - t1;
  using V = Eigen::VectorXd;
  const auto s = sensitivities(
      system, State<qdot::Dynamic>{0.0, {x0}, {v0}}, T, Dop853{}, fine,
      events(crossing("field", [](const V& q, const V&) { return q[0] - 1.0; }).rising().action([&gravity](State<qdot::Dynamic>&) {
        gravity = 2.0;
      })));
  REQUIRE(s.completed());
  CHECK_THAT(s.y[0], WithinAbs(1 + v0 * late + late * late, 1e-11));
  const double dt_dx = -1 / v0, dt_dv = -(1 - x0) / (v0 * v0);  // as above
  Eigen::Matrix2d expected;
  expected << -(v0 + 2 * late) * dt_dx, late - (v0 + 2 * late) * dt_dv, -2 * dt_dx, 1 - 2 * dt_dv;
  CHECK((s.Phi - expected).cwiseAbs().maxCoeff() < 1e-11);
}

TEST_CASE("derivatives that are left out of the control of errors take the steps of the motion alone") {
  const auto system = qdot::mechanical_system<2>(qdot::scenes::DoublePendulum{});
  const State<2> start{0.0, {1.7, 1.7}, {0, 0}};
  const Options options{.rtol = 1e-10, .atol = 1e-12};
  const auto s = sensitivities(system, start, 3.0, Dop853{}, options, {}, {.controlled = false});
  const auto alone = qdot::simulate(system, start, 3.0, Dop853{}, options);
  const auto controlled = sensitivities(system, start, 3.0, Dop853{}, options), exact = sensitivities(system, start, 3.0, Dop853{}, fine);
  REQUIRE(s.completed());
  CHECK(s.run.statistics.steps == alone.statistics.steps);
  CHECK(controlled.run.statistics.steps > alone.statistics.steps);
  CHECK((s.y - alone.y).norm() < 1e-12);
  CHECK((s.Phi - exact.Phi).cwiseAbs().maxCoeff() < 1e-8);
}

TEST_CASE("the time at which a motion begins has a column of its own") {
  const double t0 = 0.4, T = 2.0;  // x = cos t₀ − cos t − sin t₀ (t − t₀)
  const auto s = sensitivities(particle({.drive = 1.0}), State<1>{t0, {0.0}, {0.0}}, T, Dop853{}, fine, {}, {.start = true, .start_time = true});
  REQUIRE(s.Phi.cols() == 3);
  CHECK_THAT(s.d_start_time()(0, 0), WithinAbs(-std::cos(t0) * (T - t0), 1e-12));
  CHECK_THAT(s.d_start_time()(1, 0), WithinAbs(-std::cos(t0), 1e-12));
}

TEST_CASE("on a constraint Φ maps tangent vectors to tangent vectors, as the motion in an angle does") {
  const double g = 9.81, l = 0.8, angle = 0.9, rate = 1.1, T = 2.0;
  const auto constrained = [=](const qdot::Vector<double, 1>& p) {
    const auto plane = qdot::mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); }, [=](const auto& q) { return g * q[1]; });
    const auto length = [r = p[0]](const auto& q) { return q[0] * q[0] + q[1] * q[1] - r * r; };
    return problem(scene(plane, qdot::holonomic("rod", length)),
                   State<2>{0.0, {p[0] * std::sin(angle), -p[0] * std::cos(angle)}, {p[0] * rate * std::cos(angle), p[0] * rate * std::sin(angle)}});
  };
  const qdot::Vector<double, 1> p(l);
  const auto s = sensitivities(constrained, p, T, Dop853{}, fine, {.start = true});
  const auto expected = sensitivities(RotorOf{g}, Eigen::Vector2d(l, 0.0), State<1>{0.0, {angle}, {rate}}, T, Dop853{}, fine,
                                      events(crossing("never", [](const V1&, const V1&) { return 1.0; }).stop()));
  REQUIRE(s.completed());
  // (x, y, ẋ, ẏ) of (θ, θ̇, l), and its derivatives.
  const auto plane_of = [](const auto& a) {
    using std::cos, std::sin;
    qdot::Vector<std::remove_cvref_t<decltype(a[0])>, 4> y;
    y << a[2] * sin(a[0]), -a[2] * cos(a[0]), a[2] * a[1] * cos(a[0]), a[2] * a[1] * sin(a[0]);
    return y;
  };
  const auto at_start = qdot::jacobian(plane_of, Eigen::Vector3d(angle, rate, l)),
             at_end = qdot::jacobian(plane_of, Eigen::Vector3d(expected.y[0], expected.y[1], l));
  const Eigen::Matrix<double, 4, 3> along = (Eigen::Matrix<double, 4, 3>() << s.d_start() * at_start.leftCols<2>(), s.d_parameters()).finished();
  CHECK((along.leftCols(2) - at_end.leftCols<2>() * expected.d_start()).cwiseAbs().maxCoeff() < 1e-9);
  CHECK((along.col(2) - at_end.leftCols<2>() * expected.d_parameters().col(0) - at_end.col(2)).cwiseAbs().maxCoeff() < 1e-9);
  // x δx + y δy = 0, and its rate
  const auto tangent = [](const Eigen::VectorXd& y, const Eigen::MatrixXd& Phi) {
    const double first = (y.head(2).transpose() * Phi.topLeftCorner(2, 4)).cwiseAbs().maxCoeff();
    const double second = (y.head(2).transpose() * Phi.bottomLeftCorner(2, 4) + y.segment(2, 2).transpose() * Phi.topLeftCorner(2, 4)).cwiseAbs().maxCoeff();
    return std::max(first, second);
  };
  CHECK(tangent(s.y, s.Phi) < 1e-14);
  CHECK(tangent(s.run.trajectory.y(1.234), s.Phi_at(1.234)) < 1e-10);
}

// Example idasSlCrank_FSA_dns of SUNDIALS' IDAS; digits by the reduced equations of one coordinate in extended precision, with which the six digits that
// IDAS prints agree.
TEST_CASE("a slider-crank's mean kinetic energy depends on spring and damper as IDAS's example says") {
  const double a = 0.5;
  const auto family = [=](const Eigen::Vector2d& p) {
    const auto bodies = qdot::mechanical_system<3>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1] + 2.0 * v[2] * v[2]); });  // q, x, p
    const auto loop = [=](const auto& q) {
      using std::cos, std::sin;
      qdot::Vector<std::remove_cvref_t<decltype(q[0])>, 2> phi;
      phi << q[1] - cos(q[2]) - a * cos(q[0]), -sin(q[2]) - a * sin(q[0]);
      return phi;
    };
    const auto force = [=](const auto& q, const auto& v, const auto& z, const auto&) {
      using std::cos, std::sin, std::sqrt;
      using S = std::remove_cvref_t<decltype(q[0] + z[0])>;
      const auto s21 = sin(q[2] - q[0]), reach = cos(q[2]) + a * cos(q[0]);
      const auto length = sqrt(q[1] * q[1] - q[1] * reach + (1.0 + a * a) / 4.0 + a * cos(q[2] - q[0]) / 2.0);
      qdot::Vector<S, 3> slope, Q;  // of the length
      slope << (q[1] * a * sin(q[0]) + 0.5 * a * s21) / (2.0 * length), (2.0 * q[1] - reach) / (2.0 * length),
          (q[1] * sin(q[2]) - 0.5 * a * s21) / (2.0 * length);
      const auto tension = p[0] * (length - 1.0) + p[1] * (slope[0] * v[0] + slope[1] * v[1] + slope[2] * v[2]);
      for (int i = 0; i < 3; ++i) Q[i] = -tension * slope[i];
      Q[1] = Q[1] + 1.0;
      Q[2] = Q[2] - sin(q[2]);
      return Q;
    };
    const auto energy = [](const auto&, const auto& v, const auto& z, const auto&) {
      std::remove_cvref_t<decltype(z)> rate = z;
      rate[0] = 0.5 * (v[0] * v[0] + v[1] * v[1] + 2.0 * v[2] * v[2]);
      return rate;
    };
    const double rod = std::asin(-a);
    return problem(scene(bodies, qdot::holonomic("loop", loop), qdot::controller(force, energy, qdot::Vector<double, 1>(0.0))),
                   State<3>{0.0, {std::numbers::pi / 2, std::cos(rod), rod}, {0, 0, 0}});
  };
  const auto s = sensitivities(family, Eigen::Vector2d(1.0, 1.0), 10.0, Dop853{}, fine);
  INFO(s.message);
  REQUIRE(s.completed());
  constexpr double error = 1e-10;
  CHECK_THAT(s.y[0], WithinAbs(1.2756758486502394, error));
  CHECK_THAT(s.y[3], WithinAbs(-0.2399149971960007, error));
  CHECK_THAT(s.y[6], WithinAbs(3.3366067994827844, error));
  CHECK_THAT(s.Phi(6, 0), WithinAbs(0.3334481061284379, error));
  CHECK_THAT(s.Phi(6, 1), WithinAbs(-0.3637540339709498, error));
  CHECK_THAT(s.Phi(0, 0), WithinAbs(-0.1739779292603175, error));
  CHECK_THAT(s.Phi(0, 1), WithinAbs(-0.2687606670918820, error));
  const auto mean = qdot::integral([](const auto&, const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1] + 2.0 * v[2] * v[2]); });
  const auto backwards = adjoint_sensitivities(family, Eigen::Vector2d(1.0, 1.0), 10.0, mean, Dop853{}, fine);
  INFO(backwards.message);
  REQUIRE(backwards.completed());
  CHECK_THAT(backwards.value, WithinAbs(3.3366067994827844, error));
  CHECK_THAT(backwards.by_parameters[0], WithinAbs(0.3334481061284379, error));
  CHECK_THAT(backwards.by_parameters[1], WithinAbs(-0.3637540339709498, error));
}

TEST_CASE("where there is no derivative none is made up, and what was found before is returned") {
  const auto ball = particle({.g = 9.81});
  const State<1> start{0.0, {1.0}, {0.0}};
  const auto refused = [](const auto& s, const char* why) {
    INFO(s.message);
    CHECK(s.outcome == Outcome::not_differentiable);
    CHECK(s.message.find(why) != std::string::npos);
    CHECK(s.t > 0.4);
    CHECK_THAT(s.Phi(0, 1), WithinAbs(s.t, 1e-9));  // of the free fall up to there
  };
  const Action push = [](State<1>& s) { s.qdot[0] = 1.0; };
  // The top of a throw, 0.1 v₀²/g below: touched, or missed.
  const State<1> up{0.0, {0.0}, {9.81}};
  refused(sensitivities(ball, up, 2.0, Dop853{}, {},
                        events(crossing("lid", [](const V1& q, const V1&) { return q[0] - 4.905 + 1e-13; }).action(push))),
          "'lid' only grazes zero");
  refused(sensitivities(
              ball, start, 2.0, Dop853{}, {},
              events(crossing("floor", height).action(push),
                     crossing("time", [](const V1& q, const V1&) { return 2.0 * q[0]; }).action(Action([](State<1>& s) { s.qdot[0] *= -0.5; })))),
          "'time' coincides with 'floor'");
  refused(sensitivities(ball, start, 2.0, Dop853{}, {},
                        events(crossing("floor", height).action(Action([](State<1>& s) { s.qdot[0] = s.qdot[0] < -4.42944691807002 ? 1.0 : 2.0; })))),
          "has no derivative with respect to");
  int count = 0;
  refused(sensitivities(ball, start, 2.0, Dop853{}, {},
                        events(crossing("floor", height).action(Action([&count](State<1>& s) { s.qdot[0] = 1.0 + (count++ % 2); })))),
          "something else each time");
}

// y = e v (t − t₁) − g (t − t₁)²/2 behind a bounce at t₁ = √(2h/g) with v = √(2gh): ∂y/∂e = v (t − t₁), ∂v/∂h = g/v and ∂t₁/∂h = 1/v.
TEST_CASE("what happens in one moment and does not act on each other has a derivative") {
  const auto balls = qdot::mechanical_system<2>([](const auto& u) { return 0.5 * u.squaredNorm(); }, [](const auto& q) { return 9.81 * q.sum(); });
  const double h = 1.0, e = 0.8, t = 0.8, v = std::sqrt(2 * 9.81 * h), late = t - v / 9.81, dt = 1 / v;
  const double by_e = v * late, by_h = e * (9.81 / v) * late - e * v * dt + 9.81 * late * dt;
  CHECK_THAT(by_e, WithinAbs(1.543557534, 1e-9));
  CHECK_THAT(by_h, WithinAbs(0.589201781, 1e-9));
  const Eigen::Vector4d p(h, h, e, e);
  const auto right = [&](const auto& s) {
    INFO(s.message);
    REQUIRE(s.completed());
    CHECK_THAT(s.Phi(0, 0), WithinAbs(by_h, 1e-8));
    CHECK_THAT(s.Phi(0, 1), WithinAbs(0.0, 1e-8));
    CHECK_THAT(s.Phi(0, 2), WithinAbs(by_e, 1e-8));
    CHECK_THAT(s.Phi(1, 3), WithinAbs(by_e, 1e-8));
    CHECK_THAT(s.Phi(1, 1), WithinAbs(by_h, 1e-8));
    REQUIRE(s.events.size() == 2);
    for (int ball : {0, 1}) {
      CHECK_THAT(s.events[static_cast<std::size_t>(ball)].time[ball], WithinAbs(dt, 1e-8));
      CHECK_THAT(s.events[static_cast<std::size_t>(ball)].time[1 - ball], WithinAbs(0.0, 1e-8));
    }
  };
  const auto gap = [](int i) { return [i](const auto& q) { return q[i]; }; };
  const auto two = [&](const Eigen::Vector4d& at) {
    return problem(scene(balls, qdot::contact("first", gap(0), qdot::restitution(at[2])), qdot::contact("second", gap(1), qdot::restitution(at[3]))),
                   State<2>{0.0, {at[0], at[1]}, {0.0, 0.0}});
  };
  right(sensitivities(two, p, t, Dop853{}, fine));
  const auto back = adjoint_sensitivities(two, p, t, qdot::end_value([](const auto& q) { return q[0] + 2.0 * q[1]; }), Dop853{}, fine);
  REQUIRE(back.completed());
  CHECK_THAT(back.by_parameters[2], WithinAbs(by_e, 1e-8));
  CHECK_THAT(back.by_parameters[1], WithinAbs(2 * by_h, 1e-8));
  // A contact and a kick that has nothing to do with it.
  const auto kicked = [&](const Eigen::Vector4d& at) {
    return problem(scene(balls, qdot::contact("first", gap(0), qdot::restitution(at[2]))),
                   State<2>{0.0, {at[0], at[1]}, {0.0, 0.0}},
                   events(event("kick", gap(1)).falling().action([e2 = at[3]](State<2>& s) { s.qdot[1] *= -e2; })));
  };
  const auto s = sensitivities(kicked, p, t, Dop853{}, fine);
  INFO(s.message);
  REQUIRE(s.completed());
  CHECK_THAT(s.Phi(0, 2), WithinAbs(by_e, 1e-8));
  CHECK_THAT(s.Phi(1, 3), WithinAbs(by_e, 1e-8));
  CHECK_THAT(s.Phi(1, 1), WithinAbs(by_h, 1e-8));
}

TEST_CASE("what is wrong with a question about sensitivities is said before the first step") {
  const auto ball = particle({.g = 9.81});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto message = [](const auto& ask) -> std::string {
    try {
      ask();
    } catch (const qdot::Error& error) {
      return error.what();
    }
    return "";
  };
  CHECK(message([&] { sensitivities(ball, State<1>{0.0, {nan}, {0.0}}, 1.0, Dop853{}); }) == "q0 must be finite at the start, but is nan; give it a number");
  CHECK(message([&] {
          sensitivities(ball, State<1>{0.0, {1.0}, {0.0}}, 1.0, Dop853{}, {}, {}, {.start = false, .start_time = false});
        }).find("must be with respect to something") != std::string::npos);
  CHECK(message([&] {
          sensitivities(ball, State<1>{0.0, {1.0}, {0.0}}, 1.0, Dop853{}, {},
                        events(crossing("a", height).action(Action()), crossing("a", velocity)));
        }).find("two are called 'a'") != std::string::npos);
  SixNumbers p;
  p << 9.81, 1.0, 0.0, 1.0, 0.0, std::numeric_limits<double>::infinity();
  CHECK(message([&] { sensitivities(over_floor, p, 1.0, Dop853{}); }) == "parameter 5 must be finite, but is inf; give it a number");
  p[1] = 2.0;
  CHECK(message([&] { sensitivities(over_floor, p, 1.0, Dop853{}); }).starts_with("a coefficient of restitution must lie between 0 and 1"));
  CHECK(message([&] {
          sensitivities(particle({.g = 9.81}), qdot::FirstOrderState{0.0, Eigen::Vector3d::Zero()}, 1.0, Dop853{});
        }).starts_with("y must have 2 entries"));
}

TEST_CASE("at the edge of what a parameter may be, its derivative comes from the side where there are members") {
  SixNumbers p;  // e = 1 once: v⁺ = e g t₁, and ∂h/∂e = g t₁ (T − t₁)
  p << 9.81, 1.0, 0.0, 1.0, 0.0, 0.0;
  const double t1 = std::sqrt(2 / 9.81);
  const auto s = sensitivities(over_floor, p, 1.0, Dop853{}, fine);
  REQUIRE(s.completed());
  CHECK_THAT(s.Phi(0, 1), WithinAbs(9.81 * t1 * (1.0 - t1), 1e-10));
}
