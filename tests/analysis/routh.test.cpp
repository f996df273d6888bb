// SPDX-License-Identifier: MIT
#include "catch2_bridge.hpp"

#include <cmath>

#include "qdot/analysis/routh.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "scenes/heavy_top.hpp"

using namespace qdot;
using Catch::Matchers::StartsWith;

namespace {

// Both motions are integrated with tolerances of 1e-13.
constexpr double of_runs = 1e-10;
constexpr double rounding = 1e-13;
const Options tight{.rtol = 1e-13, .atol = 1e-13};

// A cart of mass M on a belt of speed c, with a pendulum (m, l) on it; x is seen from the belt, and is cyclic unless there is a spring k.
struct Cart {
  double M = 1.4, m = 0.3, l = 0.8, g = 9.81, c = 0.0, k = 0.0;
  auto T(const auto& q, const auto& v) const {
    using std::cos;
    const auto xdot = v[0] + c;
    return 0.5 * (M + m) * xdot * xdot + m * l * cos(q[1]) * xdot * v[1] + 0.5 * m * l * l * v[1] * v[1];
  }
  auto V(const auto& q) const {
    using std::cos;
    return 0.5 * k * q[0] * q[0] - m * g * l * cos(q[1]);
  }
};
auto cart(Cart given) { return mechanical_system<2>(given).with_names({"x", "theta"}); }

}  // namespace

TEST_CASE("the reduced motion of a heavy top is the full one, and its ignored angles are found again") {
  const scenes::HeavyTop top;
  const auto full = mechanical_system<3>(top).with_names({"theta", "phi", "psi"});
  const State<3> start{0.0, {0.6, 0.2, -0.4}, {0.3, 0.5, 8.0}};
  const auto reduced = routh_reduction<1, 2>(full, start);
  CHECK(reduced.system.coordinate_name(0) == "theta");
  const auto a = simulate(full, start, 5.0, Dop853{}, tight);
  const auto b = simulate(reduced.scene(), reduced.start, 5.0, Dop853{}, tight);
  REQUIRE(a.completed());
  REQUIRE(b.completed());
  for (const double t : {1.1, 3.3, 5.0}) {
    const State<3> x = a.trajectory.at(t), y = reduced.full_state(t, b.trajectory.y(t));
    for (int i = 0; i < 3; ++i) {
      CHECK_THAT(y.q[i], WithinAbs(x.q[i], of_runs));
      CHECK_THAT(y.qdot[i], WithinAbs(x.qdot[i], of_runs));
    }
  }
}

TEST_CASE("the potential of a reduced heavy top is the effective potential of the textbook") {
  const scenes::HeavyTop top;
  const State<3> start{0.0, {0.6, 0.2, -0.4}, {0.3, 0.5, 8.0}};
  const auto reduced = routh_reduction<1, 2>(mechanical_system<3>(top), start);
  const double spin = top.I3 * (8.0 + 0.5 * std::cos(0.6)), turn = top.I1 * std::sin(0.6) * std::sin(0.6) * 0.5 + spin * std::cos(0.6);
  CHECK_THAT(reduced.momenta[0], WithinRel(turn, rounding));
  CHECK_THAT(reduced.momenta[1], WithinRel(spin, rounding));
  for (const double theta : {0.2, 0.9, 2.7}) {
    const double c = std::cos(theta), s = std::sin(theta), d = turn - spin * c;
    const Vector<double, 1> q(theta), qdot(1.7);
    CHECK_THAT(potential_energy(reduced.system, q),
               WithinRel(0.5 * d * d / (top.I1 * s * s) + 0.5 * spin * spin / top.I3 + top.m * top.g * top.l * c, rounding));
    CHECK_THAT(kinetic_energy(reduced.system, q, qdot), WithinRel(0.5 * top.I1 * 1.7 * 1.7, rounding));
    CHECK_THAT(reduced.ignored_velocities({0.0, {theta}, {1.7}})[0], WithinRel(d / (top.I1 * s * s), rounding));
  }
}

TEST_CASE("a steady precession, I1 cos(theta) phidot^2 - p_psi phidot + m g l = 0, rests in the effective potential") {
  const scenes::HeavyTop top;
  const double theta = 0.6, spin = 7.0, c = std::cos(theta), weight = top.m * top.g * top.l;
  for (const double sign : {-1.0, 1.0}) {  // slow and fast
    const double phidot = (spin + sign * std::sqrt(spin * spin - 4.0 * top.I1 * c * weight)) / (2.0 * top.I1 * c);
    const auto reduced = routh_reduction<1, 2>(mechanical_system<3>(top), State<3>{0.0, {theta, 0.2, -0.4}, {0.0, phidot, spin / top.I3 - phidot * c}});
    CHECK_THAT(acceleration(reduced.system, reduced.start.q, reduced.start.qdot)[0], WithinAbs(0.0, 1e-12));
  }
}

TEST_CASE("where velocities are coupled, a reduced system has the inertia that is left and the accelerations of the full one") {
  for (const double belt : {0.0, 0.7}) {
    const Cart given{.c = belt};
    const auto full = cart(given);
    const State<2> start{0.0, {0.3, 0.9}, {-0.4, 1.3}};
    const auto reduced = routh_reduction<0>(full, start);
    const double total = given.M + given.m, coupling = given.m * given.l * std::cos(0.9);
    const double beta = total * (belt - 0.4) + coupling * 1.3;
    CHECK_THAT(reduced.momenta[0], WithinRel(beta, rounding));
    // R = ½ (m l² − (m l cos θ)²/(M + m)) θ̇² + β m l cos θ θ̇/(M + m) + m g l cos θ − β²/(2 (M + m)) + β c
    const double T = 0.5 * (given.m * given.l * given.l - coupling * coupling / total) * 1.3 * 1.3 + beta * coupling * 1.3 / total;
    const double V = 0.5 * beta * beta / total - given.g * coupling - beta * belt;
    const auto& [t, q, qdot] = reduced.start;
    CHECK_THAT(lagrangian(reduced.system, q, qdot, t), WithinRel(T - V, rounding));
    CHECK_THAT(acceleration(reduced.system, q, qdot, t)[0], WithinRel(acceleration(full, start.q, start.qdot)[1], rounding));
    CHECK_THAT(reduced.ignored_velocities(reduced.start)[0], WithinRel(-0.4, rounding));
  }
}

TEST_CASE("a coordinate that is not cyclic is not ignored") {
  CHECK_THROWS_WITH(routh_reduction<0>(cart({.k = 2.0}), State<2>{0.0, {0.5, 0.9}, {0.0, 0.0}}),
                    StartsWith("routh_reduction: L must not depend on a coordinate that is to be ignored, but dL/dx is -1 at x = 0.5, the start"));
  // where the slope is zero at the start by chance, it is not beside it
  CHECK_THROWS_WITH(routh_reduction<0>(cart({.k = 2.0}), State<2>{0.0, {0.0, 0.9}, {0.0, 0.0}}),
                    StartsWith("routh_reduction: L must not depend on a coordinate that is to be ignored, but dL/dx is "));
}
