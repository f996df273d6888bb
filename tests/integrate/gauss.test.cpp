// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "../catch2_bridge.hpp"
#include "qdot/integrate/gauss.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "scenes/double_pendulum.hpp"

namespace {

using namespace qdot;

// Unit masses and lengths, absolute angles: T mixes positions and velocities.
const auto double_pendulum = mechanical_system<2>(scenes::DoublePendulum{.g = 1.0});
const State<2> release{0.0, {0.9, -0.4}, {0.3, 0.5}};

TEST_CASE("the nodes integrate polynomials of degree 2s − 1, and the stages those of degree s − 1") {
  for (const int s : {1, 2, 3, 4, 8}) {
    const detail::GaussTable table(s);
    for (int degree = 0; degree < 2 * s; ++degree)
      CHECK_THAT((table.b.array() * table.c.array().pow(degree)).sum(), WithinAbs(1.0 / (degree + 1), 1e-15));
    for (int i = 0; i < s; ++i)
      for (int degree = 0; degree < s; ++degree)
        CHECK_THAT((table.a.row(i).transpose().array() * table.c.array().pow(degree)).sum(),
                   WithinAbs(std::pow(table.c[i], degree + 1) / (degree + 1), 1e-15));
    for (int i = 0; i < s; ++i)  // the condition for being symplectic
      for (int j = 0; j < s; ++j)
        CHECK_THAT(table.b[i] * table.a(i, j) + table.b[j] * table.a(j, i) - table.b[i] * table.b[j], WithinAbs(0.0, 1e-16));
  }
  CHECK_THAT(detail::GaussTable(2).c[0], WithinAbs(0.5 - std::sqrt(3.0) / 6, 1e-16));
}

TEST_CASE("s stages converge with order 2s, forward and backward in time") {
  for (const double t_end : {2.0, -2.0}) {
    const Eigen::VectorXd exact = simulate(double_pendulum, release, t_end, Dop853{}, {.rtol = 1e-14, .atol = 1e-15}).y;
    for (const int s : {1, 2, 3, 4}) {
      const auto error = [&](double h) { return (simulate(double_pendulum, release, t_end, Gauss{.step = h, .stages = s}).y - exact).norm(); };
      const double h = s == 1 ? 0.05 : 0.1;
      const double order = std::log2(error(h) / error(h / 2));
      INFO(s << " stages to t = " << t_end << ", errors " << error(h) << ", " << error(h / 2));
      CHECK(order > 2 * s - 0.7);
      CHECK(order < 2 * s + 1.5);
    }
  }
}

TEST_CASE("the energy error does not grow, where a method that is not symplectic loses energy") {
  double early = 0.0, late = 0.0;
  const double t_end = 500.0, E = energy(double_pendulum, release);
  const auto run = simulate(double_pendulum, release, t_end, Gauss{.step = 0.1, .stages = 2}, {.keep_trajectory = false},
                            [&](const StepView& step) {
                              const double error = std::abs(energy(double_pendulum, State<2>{0.0, step.q(), step.qdot()}) - E);
                              if (step.t() < 0.1 * t_end) early = std::max(early, error);
                              if (step.t() > 0.9 * t_end) late = std::max(late, error);
                            });
  CHECK(run.completed());
  CHECK(early < 1e-3);
  CHECK(late < 2 * early);
}

TEST_CASE("angular momentum is kept to rounding, in polar coordinates as well") {
  const auto planet = mechanical_system<2>([](const auto& q, const auto& v) { return 0.5 * (v[0] * v[0] + q[0] * q[0] * v[1] * v[1]); },
                                           [](const auto& q) { return -1.0 / q[0]; });
  const State<2> start{0.0, {1.0, 0.0}, {0.1, 1.1}};
  const auto run = simulate(planet, start, 200.0, Gauss{.step = 0.05, .stages = 3});
  CHECK(run.completed());
  CHECK_THAT(run.y[0] * run.y[0] * run.y[3], WithinAbs(1.1, 1e-13));
  CHECK_THAT(energy(planet, run.state()), WithinAbs(energy(planet, start), 1e-8));
}

TEST_CASE("forth and back returns to rounding") {
  const Gauss method{.step = 0.05, .stages = 4};
  const auto forth = simulate(double_pendulum, release, 10.0, method);
  const auto back = simulate(double_pendulum, forth.state(), 0.0, method);
  CHECK((back.y - Eigen::Vector4d(0.9, -0.4, 0.3, 0.5)).norm() < 1e-11);  // the motion amplifies rounding
}

TEST_CASE("kinetic energies that are not quadratic, and drives, are followed as well") {
  const auto relativistic = mechanical_system<1>(
      [](const auto&, const auto& v, const auto&) {
        using std::sqrt;
        return 1.0 - sqrt(1.0 - v[0] * v[0]);
      },
      [](const auto& q, const auto& t) {
        using std::sin;
        return 0.5 * q[0] * q[0] - 0.1 * q[0] * sin(t);
      });
  const State<1> start{0.2, Vector<double, 1>(0.5), Vector<double, 1>(0.3)};
  const Eigen::VectorXd exact = simulate(relativistic, start, 5.0, Dop853{}, {.rtol = 1e-13, .atol = 1e-14}).y;
  CHECK((simulate(relativistic, start, 5.0, Gauss{.step = 0.05, .stages = 4}).y - exact).norm() < 1e-10);
}

TEST_CASE("an iteration that diverges is named as what it is, and T is not blamed for it") {
  // The iteration for the stages of an oscillator contracts by about (h λ)² times the square of the stages' own matrix: h λ = 16 is too
  // much for one to three stages, 64 for six.
  const auto stiff = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 5e3 * q[0] * q[0]; });
  for (const int stages : {1, 3, 6})
    for (const double h_lambda : {16.0, 64.0, 1e5}) {
      if (stages == 6 && h_lambda < 20) continue;
      const auto run = simulate(stiff, State<1>{0.0, Vector<double, 1>(1.0), Vector<double, 1>(0.0)}, h_lambda,
                                Gauss{.step = h_lambda / 100, .stages = stages});
      CAPTURE(stages, h_lambda);
      CHECK(run.outcome == Outcome::corrector_failure);
      CHECK(run.message.find("the iteration for the stages diverged: the step is too long") != std::string::npos);
      CHECK(run.message.find("M(") == std::string::npos);
      CHECK(run.y[0] == 1.0);
    }
}

TEST_CASE("steps that are far too long end with their name") {
  const auto run = simulate(double_pendulum, State<2>{0.0, {2.0, 2.5}, {9.0, -9.0}}, 100.0, Gauss{.step = 10.0, .stages = 4});
  CHECK_FALSE(run.completed());
  CHECK(run.message.find("gauss") != std::string::npos);
  CHECK_THROWS_WITH(simulate(double_pendulum, release, 1.0, Gauss{.stages = 9}),
                    "stages must lie between 1 and 8, but is 9; s stages make order 2s; 2 to 4 are usual");
}

}  // namespace
