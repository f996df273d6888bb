// SPDX-License-Identifier: MIT
#include "catch2_bridge.hpp"

#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "error_message.hpp"
#include "hard/rolling_disk.hpp"
#include "qdot/analysis/damped_modes.hpp"
#include "qdot/analysis/linearization.hpp"
#include "qdot/analysis/lqr.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/dry_friction.hpp"
#include "qdot/effects/forces.hpp"
#include "scenes/cartpole.hpp"

using namespace qdot;
using Eigen::Vector2d;

namespace {

// Exact slopes and the solution of small systems.
constexpr double rounding = 1e-12;

constexpr double g = 9.81, l = 1.3, c = 0.4, omega_0 = 2.7470263;  // √(g/l) to eight digits

struct Mass {
  auto T(const auto& v) const { return 0.5 * v.squaredNorm(); }
  auto V(const auto& q) const { return g * q[1]; }
};
// A load cos t on a spring, or one that adds to its stiffness; known from 0 to 10.
struct Table {
  double load, stiffness;
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  template <class S>
  S V(const Vector<S, 1>& q, const S& t) const {
    using std::cos;
    if (t < 0.0 || t > 10.0) throw std::out_of_range("the table has no such time");
    return S(0.5 * (4.0 + stiffness * cos(t)) * q[0] * q[0] - load * cos(t) * q[0]);
  }
};
struct Rod {
  auto operator()(const auto& q) const { return 0.5 * (q[0] * q[0] + q[1] * q[1] - l * l); }
};

// A pendulum in Cartesian coordinates, its rod written down twice, drag, and a push along x.
auto cartesian_pendulum() {
  return scene(mechanical_system<2>(Mass{}).with_names({"x", "y"}), holonomic("rod", Rod{}),
               viscous_damping(Vector2d(c, c)), holonomic("again", Rod{}), input("push", 0));
}

struct Spring {
  double kappa;
  auto potential_term(const auto& q, const auto&) const { return 0.5 * kappa * q[0] * q[0]; }
};

}  // namespace

TEST_CASE("a pendulum in Cartesian coordinates has one position and one velocity, and x'' = -g/l x - c x' + u") {
  const auto s = cartesian_pendulum();
  const Linearization at = linearization(s, equilibrium_near(s, Vector2d(0.1, -1.0)));
  CHECK(at.states == std::vector<std::string>{"x", "xdot"});
  CHECK(at.inputs == std::vector<std::string>{"push"});
  CHECK((at.positions == 1 && at.velocities == 1));
  CHECK_THAT(at.A(0, 0), WithinAbs(0.0, rounding));
  CHECK_THAT(at.A(0, 1), WithinRel(1.0, rounding));
  CHECK_THAT(at.A(1, 0), WithinRel(-g / l, rounding));
  CHECK_THAT(at.A(1, 1), WithinRel(-c, rounding));
  CHECK_THAT(at.B(0, 0), WithinAbs(0.0, rounding));
  CHECK_THAT(at.B(1, 0), WithinRel(1.0, rounding));
  CHECK(at.drift.norm() < rounding);

  const DampedModes modes = damped_modes(at);
  REQUIRE(modes.modes.size() == 1);
  const DampedMode& mode = modes.modes[0];
  CHECK_THAT(mode.natural_frequency, WithinRel(std::sqrt(g / l), rounding));
  CHECK_THAT(mode.natural_frequency, WithinAbs(omega_0, 1e-7));
  CHECK_THAT(mode.damping_ratio, WithinRel(0.5 * c / std::sqrt(g / l), rounding));
  CHECK_THAT(mode.frequency(), WithinRel(std::sqrt(g / l - 0.25 * c * c), rounding));
  CHECK(std::abs(mode.shape[0] - 1.0) < rounding);
  CHECK(std::abs(mode.shape[1]) < rounding);
  CHECK(modes.stability == Stability::asymptotically_stable);
}

TEST_CASE("the frequency response of a pushed pendulum is 1/(w0^2 - w^2 + i c w), whatever is observed") {
  const auto s = cartesian_pendulum();
  const Linearization at = linearization(s, equilibrium_near(s, Vector2d(0.1, -1.0)));
  const auto x_and_more = observed(at, [](const auto& q, const auto& qdot, const auto& u) {
    using S = typename std::decay_t<decltype(q)>::Scalar;
    return Vector<S, 2>(q[0], 3.0 * qdot[0] + q[1] * q[1] + 2.0 * u[0]);
  });
  for (const double omega : {0.0, 1.0, 2.7, 50.0}) {
    const std::complex<double> G = 1.0 / std::complex<double>(g / l - omega * omega, c * omega);
    const Eigen::MatrixXcd response = frequency_response(x_and_more, omega);
    CHECK(std::abs(response(0, 0) - G) < rounding);
    CHECK(std::abs(response(1, 0) - (std::complex<double>(0.0, 3.0 * omega) * G + 2.0)) < 10.0 * rounding);
  }
}

TEST_CASE("at the top the same pendulum is unstable with the exponents of x'' = g/l x - c x'") {
  const auto s = cartesian_pendulum();
  const DampedModes modes = damped_modes(linearization(s, equilibrium_near(s, Vector2d(0.1, 1.2))));
  CHECK(modes.stability == Stability::unstable);
  CHECK_THAT(modes.growth, WithinRel(-0.5 * c + std::sqrt(0.25 * c * c + g / l), rounding));
  CHECK(std::string(description(modes.stability)) == "unstable");
}

TEST_CASE("a state off its constraints, or one that does not stay, is refused by name") {
  const auto s = cartesian_pendulum();
  CHECK_THROWS_WITH(linearization(s, State<2>{0.0, {0.0, -1.4}, {0.0, 0.0}}),
                    "linearization: the state must satisfy its constraints, but 'rod' is off by 0.135 at t = 0; take "
                    "it from consistent_state() or equilibrium_near()");
  CHECK_THROWS_WITH(linearization(s, State<2>{0.0, {0.0, -l}, {0.0, 0.5}}),
                    "linearization: the state must satisfy its constraints, but the velocity of 'rod' is off by -0.65 "
                    "at t = 0; take it from consistent_state() or "
                    "equilibrium_near()");
  CHECK_THROWS_WITH(linearization(s, State<2>{0.0, {0.0, NAN}, {0.0, 0.5}}),
                    "linearization: the state must be finite, but y is not; give every entry a number");
  const Linearization aside = linearization(s, State<2>{0.0, {l * 0.6, -l * 0.8}, {0.0, 0.0}});
  CHECK_THAT(aside.drift.norm(),
             WithinRel(g * 0.6, rounding) || WithinRel(g * 0.6 * 0.8, rounding));  // along the tangent, seen in x
  CHECK_THROWS_AS(damped_modes(aside), InvalidValue);
  const Eigen::MatrixXd Q = Eigen::MatrixXd::Identity(2, 2), R = Eigen::MatrixXd::Identity(1, 1);
  CHECK_THROWS_AS(lqr(aside, Q, R), InvalidValue);
}

TEST_CASE("a table of time is asked for no moment that it refuses in the end: A of a load that changes, and of a stiffness") {
  for (const double t : {0.0, 9.5, 10.0}) {
    const Linearization loaded = linearization(mechanical_system<1>(Table{1.0, 0.0}), State<1>{t, {0.3}, {0.0}});
    CHECK(loaded.A == (Eigen::MatrixXd(2, 2) << 0, 1, -4, 0).finished());
    CHECK(loaded.autonomous);
    CHECK_THAT(loaded.drift[1], WithinAbs(std::cos(t) - 1.2, rounding));
    const Linearization shaken = linearization(mechanical_system<1>(Table{0.0, 1.0}), State<1>{t, {0.3}, {0.0}});
    CHECK_THAT(shaken.A(1, 0), WithinRel(-4.0 - std::cos(t), rounding));
    CHECK(!shaken.autonomous);
    CHECK_THROWS_AS(damped_modes(shaken), InvalidValue);
  }
}

TEST_CASE("a spring of rest length 0 is linear at its anchor, and one of rest length 1 has no stiffness there") {
  const auto place = [](const auto& q) { return vector(q[0], q[1]); };
  const auto anchored = [&](double length) {
    return scene(mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return 0.0 * q[0]; }),
                 spring_damper(place, Vector<double, 2>(0.0, 0.0), 4.0, length));
  };
  const auto linear = anchored(0.0);
  const Linearization at = linearization(linear, equilibrium_near(linear, Vector2d(0.3, 0.1)));
  for (Eigen::Index i = 0; i < 2; ++i)
    for (Eigen::Index j = 0; j < 2; ++j) CHECK_THAT(at.A(2 + i, j), WithinAbs(i == j ? -4.0 : 0.0, rounding));
  CHECK_THROWS_WITH(linearization(anchored(1.0), State<2>{0.0, {0.0, 0.0}, {0.0, 0.0}}),
                    Catch::Matchers::StartsWith("the derivatives of accelerations must be finite, but "));
}

TEST_CASE("a cart under an inverted pendulum: A and B of the textbook, and a regulator that holds it up") {
  const scenes::Cartpole p{};
  const auto system = mechanical_system<2>(p).with_names({"x", "theta"});
  const State<2> up{0.0, {0.0, std::numbers::pi}, {0.0, 0.0}};
  const Linearization at = linearization(system, up, input("push", 0));
  CHECK_THAT(at.A(2, 1), WithinRel(p.m / p.M * p.g, rounding));
  CHECK_THAT(at.A(3, 1), WithinRel((p.M + p.m) * p.g / (p.M * p.l), rounding));
  CHECK_THAT(at.B(2, 0), WithinRel(1.0 / p.M, rounding));
  CHECK_THAT(at.B(3, 0), WithinRel(1.0 / (p.M * p.l), rounding));
  CHECK(damped_modes(at).stability == Stability::unstable);
  const Eigen::MatrixXd Q = Eigen::MatrixXd::Identity(4, 4), R = Eigen::MatrixXd::Identity(1, 1);
  const Lqr held = lqr(at, Q, R);
  CHECK(held.exponents.real().maxCoeff() < -0.1);
  CHECK(held.residual < 1e-12);
  Linearization closed = at;
  closed.A -= at.B * held.K;
  CHECK(damped_modes(closed).stability == Stability::asymptotically_stable);
  // hanging down without a regulator, the pendulum swings for ever and the cart rolls away
  const DampedModes down = damped_modes(linearization(system, State<2>{0.0, {1.0, 0.0}, {0.0, 0.0}}, input("push", 0)));
  CHECK(down.stability == Stability::drifting);
  CHECK_THAT(down.modes.back().frequency(), WithinRel(std::sqrt((p.M + p.m) * p.g / (p.M * p.l)), rounding));
  CHECK_THROWS_AS(linearization(system, up, input("push", 2)), InvalidValue);
}

TEST_CASE("an upright disk rolls straight on if v^2 > g r/3, with five positions and three velocities") {
  const hard::RollingDisk disk;  // J. Neimark, N. Fufaev, Dynamics of Nonholonomic Systems, 1972
  const auto rolling = scene(mechanical_system<5>(disk).with_names({"x", "y", "phi", "delta", "psi"}),
                             nonholonomic("no slip", [r = disk.r](const auto& q, const auto& v) {
                               using std::cos, std::sin;
                               using S = std::decay_t<decltype(v[0] * cos(q[2]))>;
                               return Vector<S, 2>(v[0] - r * cos(q[2]) * v[4], v[1] - r * sin(q[2]) * v[4]);
                             }));
  for (const double part : {0.99, 1.01}) {
    const double v = std::sqrt(part * g * disk.r / 3.0);
    const Linearization at = linearization(
        rolling, State<5>{0.0, Vector<double, 5>::Zero(), (Vector<double, 5>() << v, 0, 0, 0, v / disk.r).finished()});
    CHECK((at.positions == 5 && at.velocities == 3 && at.A.rows() == 8));
    const DampedModes modes = damped_modes(at);
    // a heading that is a little different leads ever farther away, stable or not
    CHECK(modes.stability == (part < 1.0 ? Stability::unstable : Stability::drifting));
    // lean: δ'' = (4/5)(g/r − 3 v²/r²) δ for the thin disk
    const double squared = 0.8 * (g / disk.r - 3.0 * v * v / (disk.r * disk.r));
    const std::complex<double> lean = modes.modes.back().exponent;
    CHECK(std::abs(lean * lean - squared) < 1e-9);
  }
}

TEST_CASE("an input that is given later leaves the scene's potentials as they were: x'' = -(k + kappa) x + u") {
  const auto s = scene(mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; },
                                            [](const auto& q) { return 2.0 * q[0] * q[0]; })
                           .with_names({"x"}),
                       Spring{5.0});
  const Linearization at = linearization(s, equilibrium_near(s, Vector<double, 1>(0.3)), input("push", 0));
  CHECK_THAT(at.A(1, 0), WithinRel(-9.0, rounding));
  CHECK_THAT(at.B(1, 0), WithinRel(1.0, rounding));
  CHECK(at.states[0] == "x");
}

namespace {

using One = qdot::Vector<double, 1>;

// A mass on a floor, held along it by a spring and a damper: x'' = −k x − c x' + u.
auto on_floor(double load) {
  return scene(qdot::mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); },
                                          [load](const auto& q) { return 2.0 * q[0] * q[0] + load * q[1]; }),
               qdot::contact("floor", [](const auto& q) { return q[1]; }), qdot::viscous_damping(Vector2d(0.5, 0.0)));
}

}  // namespace

TEST_CASE("a clutch that sticks makes one inertia of two: the train swings with sqrt(k (1/J1 + 1/J2))") {
  // J1 = 2 behind the clutch, J2 = 10, k = 1000
  const auto train = scene(qdot::mechanical_system<3>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1] + 10.0 * v[2] * v[2]); },
                                                      [](const auto& q) {
                                                        const auto d = q[1] - q[2];
                                                        return 500.0 * d * d;
                                                      }),
                           qdot::dry_friction("clutch", [](const auto&, const auto& v) { return v[0] - v[1]; }, 50.0));
  const State<3> rest{0.0, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
  const auto linear = linearization(train, rest);
  CHECK(linear.positions == 3);
  CHECK(linear.velocities == 2);
  const auto modes = qdot::damped_modes(linear);
  CHECK_THAT(modes.exponents.cwiseAbs().maxCoeff(), WithinAbs(std::sqrt(600.0), 1e-9));
  // The spring's torque on the stuck pair is half of 1000 d: at d = 0.1 the clutch holds with 50, which is all that it can.
  CHECK(qdot::error_message([&] { linearization(train, State<3>{0.0, {0.0, 0.1, 0.0}, {0.0, 0.0, 0.0}}); })
            .find("'clutch' holds with 50 of at most 50; take a state off this edge") != std::string::npos);
  // It slides: three inertias, of which the spring joins two, 1 and 10.
  const auto slips = linearization(train, State<3>{0.0, {0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}});
  CHECK(slips.velocities == 3);
  CHECK_THAT(slips.A.eigenvalues().cwiseAbs().maxCoeff(), WithinAbs(std::sqrt(1100.0), 1e-9));
}

TEST_CASE("what lies on a floor has modes and a regulator along it, and none where it is hardly pressed or just hit") {
  const State<2> rest{0.0, {0.0, 0.0}, {0.0, 0.0}};
  const auto linear = linearization(on_floor(9.81), rest, qdot::input("push", 0));
  REQUIRE(linear.A.rows() == 2);
  CHECK_THAT(linear.A(1, 0), WithinAbs(-4.0, 1e-12));
  CHECK_THAT(linear.A(1, 1), WithinAbs(-0.5, 1e-12));
  CHECK_THAT(linear.B(1, 0), WithinAbs(1.0, 1e-12));
  const auto modes = qdot::damped_modes(linear);
  REQUIRE(modes.modes.size() == 1);
  CHECK_THAT(modes.modes[0].natural_frequency, WithinAbs(2.0, 1e-12));
  CHECK_THAT(modes.modes[0].damping_ratio, WithinAbs(0.125, 1e-12));
  const Eigen::MatrixXd Q = Eigen::MatrixXd::Identity(2, 2), R = Eigen::MatrixXd::Identity(1, 1);
  const auto feedback = qdot::lqr(linear, Q, R);
  const double k0 = -4.0 + std::sqrt(17.0), k1 = -0.5 + std::sqrt(0.25 + 1.0 + 2.0 * k0);  // Riccati's equation by hand
  CHECK_THAT(feedback.K(0, 0), WithinAbs(k0, 1e-10));
  CHECK_THAT(feedback.K(0, 1), WithinAbs(k1, 1e-10));
  const auto message = [&](double load, const State<2>& at) { return qdot::error_message([&] { linearization(on_floor(load), at); }); };
  CHECK(message(0.0, rest).find("'floor' touches without being pressed, with 0 as the rate of its gap") != std::string::npos);
  CHECK(message(9.81, State<2>{0.0, {0.0, 0.0}, {0.0, -1.0}}).find("'floor' touches without being pressed, with -1 as") != std::string::npos);
  CHECK(qdot::error_message([&] {
          qdot::detail::linearization_of(on_floor(0.0), 0.0, rest.q, rest.qdot, One(1.0));
        }).find("'floor' is closed with a reaction of 0") != std::string::npos);
  CHECK(linearization(on_floor(9.81), State<2>{0.0, {0.0, 1.0}, {0.0, 0.0}}).A.rows() == 4);  // in the air
}
