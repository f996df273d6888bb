// SPDX-License-Identifier: MIT
//
// Units: random scenes with lengths and angles, in units of 1, of molecules and of planets in SI. What is computed is the same number in each.

#include <cmath>
#include <cstdlib>
#include <random>

#include "catch2_bridge.hpp"
#include "../fuzz/seed.hpp"
#include "qdot/analysis/damped_modes.hpp"
#include "qdot/analysis/modes.hpp"
#include "qdot/analysis/sensitivity.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/taylor.hpp"

using namespace qdot;
using Eigen::Vector3d;

namespace {

// rtol = 1e-9 in each of some hundred steps; 300 scenes over three times as long came to less.
constexpr double adds_up = 1e-5;
constexpr double derivatives = 1e-4; // Φ, likewise, beside its largest entry
constexpr double exact = 1e-11;      // equilibria and what is linear at them: rounding times the condition of K

struct Units {
  double mass = 1.0, length = 1.0, time = 1.0;
  double energy() const { return mass * length * length / (time * time); }
};
constexpr Units systems_of_units[] = {{1e-26, 1e-10, 1e-13}, {1e30, 1e11, 1e7}};

// Two places x, y and an angle: masses that pull at each other, springs, a Morse bond and a pendulum.
struct Numbers {
  double m = 1.0, I = 1.0, together = 0.3, a = 1.0, b = 1.0, c = 0.5, d = 0.2, D = 1.0, e = 1.0, f = 0.1;
};
struct Scene3 {
  Numbers p;
  Units u;
  auto T(const auto& q, const auto& v) const {
    using std::cos;
    const double m = p.m * u.mass, L = u.length;
    return 0.5 * m * (v[0] * v[0] + v[1] * v[1]) + 0.5 * (p.I * u.mass * L * L) * v[2] * v[2] + (p.together * u.mass * L) * cos(q[2]) * v[0] * v[2];
  }
  auto V(const auto& q) const {
    using std::cos, std::exp, std::sin;
    const auto x = q[0] / u.length, y = q[1] / u.length;
    const auto bond = 1.0 - exp(-y);
    return u.energy() * (0.5 * p.a * x * x + 0.25 * p.c * x * x * x * x + p.d * x * y + 0.5 * p.b * y * y + p.D * bond * bond - p.e * cos(q[2]) +
                         p.f * x * sin(q[2]) + 0.3 * x);
  }
};
// a push sin(t/τ) along x
struct Push {
  Units u;
  double size = 0.0;
  auto operator()(const auto& q, const auto&, const auto& t) const {
    using std::sin;
    auto Q = q;
    Q[0] = (size * u.energy() / u.length) * sin(t / u.time);
    Q[1] = 0.0 * q[1];
    Q[2] = 0.0 * q[2];
    return Q;
  }
};

// y in units of 1.
Eigen::VectorXd plain(const Eigen::VectorXd& y, const Units& u) {
  const double speed = u.length / u.time;
  Eigen::VectorXd x(6);
  x << y[0] / u.length, y[1] / u.length, y[2], y[3] / speed, y[4] / speed, y[5] * u.time;
  return x;
}
Eigen::MatrixXd plain_slopes(const Eigen::MatrixXd& Phi, const Units& u) {
  const double speed = u.length / u.time;
  const Eigen::VectorXd unit = (Eigen::VectorXd(6) << u.length, u.length, 1.0, speed, speed, 1.0 / u.time).finished();
  return unit.cwiseInverse().asDiagonal() * Phi * unit.asDiagonal();
}

struct Found {
  Eigen::VectorXd by_dop853, by_taylor, pushed, equilibrium, squares, damped;
  Eigen::MatrixXd Phi;
};

Found found(const Numbers& p, const Units& u, double amplitude, const Vector3d& start, const Vector3d& speeds) {
  const auto system = mechanical_system<3>(Scene3{p, u});
  const double L = u.length, end = 3 * u.time;
  Found result;
  const Vector3d rest = equilibrium_near(system, Vector3d(start[0] * L, start[1] * L, start[2]));
  result.equilibrium = Vector3d(rest[0] / L, rest[1] / L, rest[2]);
  result.squares = normal_modes(system, rest).squared_frequencies * (u.time * u.time);
  // beside the equilibrium, by a part of what is natural
  const State<3> state{0.0,
                       {rest[0] + amplitude * start[0] * L, rest[1] + amplitude * start[1] * L, rest[2] + amplitude * start[2]},
                       amplitude / u.time * Vector3d(speeds[0] * L, speeds[1] * L, speeds[2])};
  const auto from_rest = [&](const Eigen::VectorXd& y) -> Eigen::VectorXd {
    Eigen::VectorXd x = plain(y, u);
    x.head(3) -= result.equilibrium;
    return x / amplitude;
  };
  const auto dop853 = simulate(system, state, end, Dop853{});
  const auto taylor = simulate(system, state, end, Taylor{});
  REQUIRE(dop853.completed());
  REQUIRE(taylor.completed());
  result.by_dop853 = from_rest(dop853.y);
  result.by_taylor = from_rest(taylor.y);
  const auto s = sensitivities(system, state, end, Dop853{});
  REQUIRE(s.completed());
  result.Phi = plain_slopes(s.Phi, u);
  // at rest with friction, and pushed
  const double drag = 0.2 * u.mass / u.time;
  const auto pushed = scene(system, viscous_damping(Vector3d(drag, drag, drag * L * L)), generalized_force(Push{u, amplitude}));
  const auto run = simulate(pushed, State<3>{0.0, rest, Vector3d::Zero()}, end, Dop853{});
  REQUIRE(run.completed());
  result.pushed = from_rest(run.y);
  const auto modes = damped_modes(linearization(scene(system, viscous_damping(Vector3d(drag, drag, drag * L * L))), State<3>{0.0, rest, Vector3d::Zero()}));
  result.damped = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(modes.modes.size()));
  for (std::size_t i = 0; i < modes.modes.size(); ++i) result.damped[static_cast<Eigen::Index>(i)] = std::abs(modes.modes[i].exponent) * u.time;
  return result;
}

double apart(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return (a - b).cwiseAbs().maxCoeff() / b.cwiseAbs().maxCoeff(); }

}  // namespace

TEST_CASE("equilibria, modes, motions and their derivatives are the same numbers in all units") {
  const char* many = std::getenv("QDOT_SCENES");
  std::mt19937_64 random(fuzz::seed());
  const auto uniform = [&](double from, double to) { return from + (to - from) * static_cast<double>(random() >> 11) * 0x1p-53; };
  for (int k = 0; k < (many != nullptr ? std::atoi(many) : 2); ++k) {
    const Numbers p{uniform(0.5, 2), uniform(0.5, 2), uniform(-0.4, 0.4), uniform(0.5, 3), uniform(0.2, 2),
                    uniform(0, 1),      uniform(-0.3, 0.3), uniform(0.5, 2),     uniform(0.5, 2), uniform(-0.3, 0.3)};
    const Vector3d start(uniform(-0.5, 0.5), uniform(-0.3, 0.5), uniform(-0.6, 0.6)), speeds(uniform(-0.5, 0.5), uniform(-0.5, 0.5), uniform(-0.5, 0.5));
    const double amplitude = k % 3 == 0 ? 1e-3 : k % 3 == 1 ? 1.0 : 0.1;
    const Found right = found(p, {}, amplitude, start, speeds);
    for (const Units& u : systems_of_units) {
      INFO(fuzz::seed_text() << ", scene " << k << ", units " << u.mass << " " << u.length << " " << u.time);
      const Found got = found(p, u, amplitude, start, speeds);
      CHECK(apart(got.equilibrium, right.equilibrium) < exact);
      CHECK(apart(got.squares, right.squares) < exact);
      CHECK(apart(got.damped, right.damped) < 1e3 * exact);
      CHECK(apart(got.by_dop853, right.by_dop853) < adds_up);
      CHECK(apart(got.by_taylor, right.by_dop853) < adds_up);
      CHECK(apart(got.pushed, right.pushed) < adds_up);
      CHECK(apart(got.Phi, right.Phi) < derivatives);
    }
  }
}
