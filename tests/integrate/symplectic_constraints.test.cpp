// SPDX-License-Identifier: MIT
//
// Rattle: what a symplectic method on constraints owes.
#include <algorithm>
#include <cmath>

#include "../catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/rattle.hpp"
#include "qdot/integrate/simulate.hpp"

namespace {

using namespace qdot;
using Eigen::Vector2d;
using Eigen::Vector3d;

const Options bare_run{.keep_trajectory = false};

// Rounding of φ and J q̇ at lengths of one and speeds of 3.
constexpr double rounding = 1e-14;

const auto pendulum = scene(mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return 9.81 * q[1]; }),
                            holonomic("rod", [](const auto& q) { return q.squaredNorm() - 1.0; }));
const State<2> released{0.0, Vector2d(std::sin(1.0), -std::cos(1.0)), Vector2d(0.0, 0.0)};
constexpr double period = 2.13913760055869;  // from 1 rad: 4 √(l/g) K(sin² ½)

TEST_CASE("Rattle keeps a pendulum on its circle and converges with its order, forward and backward in time") {
  for (const int order : {2, 4, 6, 8})
    for (const double direction : {1.0, -1.0}) {
      const auto error = [&](int steps) {
        const auto run = simulate(pendulum, released, direction * period, Rattle{.step = period / steps, .order = order}, bare_run);
        REQUIRE(run.completed());
        CHECK(run.statistics.steps == steps);
        CHECK(run.statistics.constraint_residual < rounding);
        CHECK(run.statistics.constraint_velocity < rounding);
        return run.y.tail(2).norm();  // after a period at rest again; the place would show the square of the error in phase
      };
      const int steps = order == 2 ? 40 : order == 8 ? 20 : 30;
      const double coarse = error(steps), fine = error(2 * steps);
      INFO("order " << order << ", errors " << coarse << ", " << fine);
      CHECK(std::log2(coarse / fine) > order - 0.6);
      CHECK(std::log2(coarse / fine) < order + 1.6);
    }
}

double energy_of(const Eigen::Ref<const Eigen::VectorXd>& y) { return 0.5 * y.tail(2).squaredNorm() + 9.81 * y[1]; }

// Largest energy error in the first and in the last tenth of a run.
std::pair<double, double> energy_errors(double periods, const Rattle& method) {
  double early = 0.0, late = 0.0;
  const double t_end = periods * period, E = -9.81 * std::cos(1.0);
  const auto run = simulate(pendulum, released, t_end, method, bare_run, [&](const StepView& step) {
    const double error = std::abs(energy_of(step.y()) - E);
    if (step.t() < 0.1 * t_end) early = std::max(early, error);
    if (step.t() > 0.9 * t_end) late = std::max(late, error);
  });
  REQUIRE(run.completed());
  CHECK(run.statistics.constraint_residual < rounding);
  return {early, late};
}

TEST_CASE("over five hundred periods the energy error does not grow") {
  const auto [early, late] = energy_errors(500, {.step = period / 25, .order = 2});
  CHECK(early < 0.2);
  CHECK(late < 1.05 * early);
}

TEST_CASE("over ten thousand periods neither, nor over a thousand with order 4", "[long]") {
  const auto [early_2, late_2] = energy_errors(10000, {.step = period / 25, .order = 2});
  CHECK(late_2 < 1.05 * early_2);
  const auto [early_4, late_4] = energy_errors(1000, {.step = period / 50, .order = 4});
  CHECK(early_4 < 1e-3);
  CHECK(late_4 < 1.05 * early_4);
}

TEST_CASE("forth and back Rattle returns to rounding") {
  for (const int order : {2, 4}) {
    const Rattle method{.step = 0.02, .order = order};
    const auto forth = simulate(pendulum, released, 10.0, method, bare_run);
    const auto back = simulate(pendulum, forth.state(), 0.0, method, bare_run);
    REQUIRE(back.completed());
    CHECK((back.y.head(2) - released.q).norm() < 1e-12);
    CHECK(back.y.tail(2).norm() < 1e-12);
  }
}

TEST_CASE("a spherical pendulum keeps its angular momentum to rounding") {
  const auto sphere = scene(mechanical_system<3>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return 9.81 * q[2]; }),
                            holonomic("rod", [](const auto& q) { return 0.5 * (q.squaredNorm() - 1.0); }));
  const auto run = simulate(sphere, State<3>{0.0, Vector3d(0.6, 0.0, -0.8), Vector3d(0.0, 1.5, 0.0)}, 100.0, Rattle{.step = 0.05, .order = 2}, bare_run);
  REQUIRE(run.completed());
  CHECK_THAT(run.y[0] * run.y[4] - run.y[1] * run.y[3], WithinAbs(0.9, 1e-12));  // 2000 steps
}

TEST_CASE("constraints that move are followed with order 2, and a row given twice counts once") {
  // q₀ = sin t pulls q₁ by a spring: q₁ = (sin t − t cos t)/2.
  const auto pulled = scene(mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); },
                                                 [](const auto& q) { return 0.5 * (q[0] - q[1]) * (q[0] - q[1]); }),
                            prescribed("slide", 0, [](const auto& t) {
                              using std::sin;
                              return sin(t);
                            }),
                            prescribed("again", 0, [](const auto& t) {
                              using std::sin;
                              return sin(t);
                            }));
  const auto error = [&](double h) {
    const auto run = simulate(pulled, State<2>{0.0, {0, 0}, {1, 0}}, 3.0, Rattle{.step = h, .order = 2}, bare_run);
    REQUIRE(run.completed());
    return std::abs(run.y[1] - 0.5 * (std::sin(3.0) - 3.0 * std::cos(3.0)));
  };
  CHECK(error(0.05) < 1e-2);
  CHECK_THAT(std::log2(error(0.1) / error(0.05)), WithinAbs(2.0, 0.1));
}

TEST_CASE("steps that are far too long end with their name, and orders that are not here are refused") {
  const auto run = simulate(pendulum, State<2>{0.0, Vector2d(0, -1), Vector2d(6, 0)}, 100.0, Rattle{.step = 5.0, .order = 2});
  CHECK_FALSE(run.completed());
  CHECK(run.message.find("rattle took no step from t = 0") != std::string::npos);
  CHECK_THROWS_WITH(simulate(pendulum, released, 1.0, Rattle{.order = 3}), "order must be 2, 4, 6 or 8, but is 3; 4 is usual");
}

}  // namespace
