// SPDX-License-Identifier: MIT
//
// Gauss steps on scenes of effects: forces, states of their own, terms in L.
#include <cmath>

#include "../catch2_bridge.hpp"
#include "driven_cart.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/gauss.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"

namespace {

using namespace qdot;
using Eigen::Vector2d;

const Options bare_run{.keep_trajectory = false};

constexpr double gamma_ = 0.1, stiffness = 1.0;  // ẍ + 2γ ẋ + k x = 0
const auto oscillator = scene(mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; },
                                                   [](const auto& q) { return 0.5 * stiffness * q[0] * q[0]; }),
                              viscous_damping(Vector<double, 1>(2 * gamma_)));
const State<1> plucked{0.0, Vector<double, 1>(1.0), Vector<double, 1>(0.0)};

Vector2d damped(double t) {
  const double w = std::sqrt(stiffness - gamma_ * gamma_);
  return std::exp(-gamma_ * t) * Vector2d(std::cos(w * t) + gamma_ / w * std::sin(w * t), -stiffness / w * std::sin(w * t));
}

TEST_CASE("with damping s stages converge with order 2s, forward and backward in time") {
  for (const double t_end : {4.0, -4.0})
    for (const int s : {1, 2, 3, 4}) {
      const auto error = [&](double h) {
        return (simulate(oscillator, plucked, t_end, Gauss{.step = h, .stages = s}, bare_run).y - damped(t_end)).norm();
      };
      const double h = s < 3 ? 0.2 : 0.5;
      const double order = std::log2(error(h) / error(h / 2));
      INFO(s << " stages to t = " << t_end << ", errors " << error(h) << ", " << error(h / 2));
      CHECK(order > 2 * s - 0.4);
      CHECK(order < 2 * s + 0.6);
    }
}

TEST_CASE("forth and back returns to rounding, with friction too") {
  const Gauss method{.step = 0.1, .stages = 3};
  const auto forth = simulate(oscillator, plucked, 10.0, method);
  const auto back = simulate(oscillator, forth.state(), 0.0, method);
  CHECK((back.y - Vector2d(1.0, 0.0)).norm() < 1e-14);
}

TEST_CASE("a motion that has come to rest stays there, where forces balance") {
  const auto held = scene(oscillator.system(), viscous_damping(Vector<double, 1>(2.0)),
                          generalized_force([](const auto& q, const auto&) { return 0.3 + 0.0 * q[0]; }));
  const auto run = simulate(held, plucked, 200.0, Gauss{.step = 0.1, .stages = 2}, bare_run);
  CHECK(run.completed());
  CHECK_THAT(run.y[0], WithinAbs(0.3, 1e-14));
  CHECK_THAT(run.y[1], WithinAbs(0.0, 1e-14));
}

// ẍ = z, ż = −x: from (1, −1, 1) all three are ±exp(−t), and other solutions of the three dimensions grow.
const auto chase = scene(mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 0.0 * q[0]; }),
                         controller([](const auto&, const auto&, const auto& z, const auto&) { return z; },
                                    [](const auto& q, const auto&, const auto&, const auto&) { return (-q).eval(); }, Vector<double, 1>(1.0)));

TEST_CASE("states of a controller have the order of the motion, and their dense output is as good") {
  const State<1> start{0.0, Vector<double, 1>(1.0), Vector<double, 1>(-1.0)};
  const auto run_with = [&](double h, double t_end) { return simulate(chase, start, t_end, Gauss{.step = h, .stages = 3}); };
  for (const double t_end : {2.0, -2.0}) {
    const Eigen::Vector3d exact = std::exp(-t_end) * Eigen::Vector3d(1, -1, 1);
    const double coarse = (run_with(0.5, t_end).y - exact).norm(), fine = (run_with(0.25, t_end).y - exact).norm();
    INFO("errors " << coarse << ", " << fine);
    CHECK(std::log2(coarse / fine) > 5.6);
    CHECK(std::log2(coarse / fine) < 6.6);
  }
  const auto run = run_with(0.125, 2.0);
  for (const double t : {0.06, 0.7, 1.93}) {
    const Eigen::VectorXd y = run.trajectory.y(t);
    CHECK_THAT(y[2], WithinAbs(std::exp(-t), 1e-9));  // h⁶/46080 of the sixth derivative
    CHECK_THAT(y[0], WithinAbs(std::exp(-t), 1e-9));
  }
}

// A charge in E along x and B along z, from rest: a cycloid.
TEST_CASE("a velocity-dependent potential is part of L, and its energy is kept") {
  constexpr double E = 0.7, B = 1.3;
  const auto charge = scene(mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return -E * q[0]; }),
                            velocity_potential([](const auto& q, const auto& v) { return -0.5 * B * (q[0] * v[1] - q[1] * v[0]); }));
  const double t = 30.0;
  const auto run = simulate(charge, State<2>{0.0, {0, 0}, {0, 0}}, t, Gauss{.step = 0.1, .stages = 4}, bare_run);
  REQUIRE(run.completed());
  CHECK_THAT(run.y[0], WithinAbs(E / (B * B) * (1 - std::cos(B * t)), 1e-9));
  CHECK_THAT(run.y[1], WithinAbs(-E / B * (t - std::sin(B * t) / B), 1e-9));
  CHECK_THAT(0.5 * run.y.tail(2).squaredNorm() - E * run.y[0], WithinAbs(0.0, 1e-13));  // a quadratic invariant
}

TEST_CASE("many effects together move as they do by Dop853 at a tight tolerance") {
  const auto driven = test::driven_cart();
  const State<2> start{0.0, {0.0, 0.5}, {0.0, 0.1}};
  const Eigen::VectorXd exact = simulate(driven, start, 2.0, Dop853{}, {.rtol = 1e-13, .atol = 1e-14, .keep_trajectory = false}).y;
  const auto error = [&](double h) { return (simulate(driven, start, 2.0, Gauss{.step = h, .stages = 3}, bare_run).y - exact).norm(); };
  const double coarse = error(0.04), fine = error(0.02);
  INFO("errors " << coarse << ", " << fine);
  CHECK(fine < 1e-8);
  CHECK(std::log2(coarse / fine) > 5.3);
}

}  // namespace
