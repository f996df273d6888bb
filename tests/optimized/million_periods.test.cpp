// SPDX-License-Identifier: MIT
//
// A million periods of a pendulum, in its angle and in Cartesian coordinates on a rod: what is left of energy, phase and rod. And a
// thousand, of the rod and of a planet by all splitting methods. Here, where the optimizer is on.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/gauss.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"
#include "qdot/integrate/symplectic.hpp"
#include "qdot/integrate/taylor.hpp"

using namespace qdot;

namespace {

// Of a pendulum of length 1 from 1 rad at g = 9.81: 4 K(sin² ½)/√g, in 19 digits.
constexpr double period = 2.139137600558688845;
constexpr double periods = 1e6;

struct Left {
  double energy, phase;  // relative to the depth g(1 − cos 1); in rad of the small oscillation
};

const double well = 9.81 * (1.0 - std::cos(1.0));

auto angle() {
  return mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; },
                              [](const auto& q) {
                                using std::cos;
                                return -9.81 * cos(q[0]);
                              });
}

template <class Method>
Left swing(const Method& method, const Options& options) {
  using V1 = Vector<double, 1>;
  const auto system = angle();
  const State<1> start{0.0, V1(1.0), V1(0.0)};
  const auto run = simulate(system, start, periods * period, method, options);
  INFO(run.message);
  REQUIRE(run.completed());
  const State<1> end = run.state();
  // Near the turning point θ̇ = −g sin 1 · δt.
  const Left left{std::abs(energy(system, end) - energy(system, start)) / well, std::abs(end.qdot[0]) / (9.81 * std::sin(1.0)) * std::sqrt(9.81)};
  return left;
}

TEST_CASE("a million periods of a pendulum keep their energy", "[long]") {
  const auto check = [](const Left& left, double energy, double phase) {
    CHECK(left.energy < energy);
    CHECK(left.phase < phase);
  };
  // An explicit method loses energy at each step, and phase with the square of time; the others have only rounding to add up.
  const long most = 100'000'000;
  check(swing(Dop853{}, {.rtol = 1e-11, .atol = 1e-12, .max_steps = most, .energy_drift_limit = 1e9, .keep_trajectory = false}),
        1e-6, 0.2);  // 1.8e-7 and 0.043 were seen
  check(swing(Taylor{}, {.rtol = 1e-14, .atol = 1e-15, .max_steps = most, .energy_drift_limit = 1e9, .keep_trajectory = false}),
        2e-10, 5e-5);  // 2.1e-11 and 4.6e-6
  check(swing(Gauss{.step = period / 20, .stages = 4}, {.max_steps = most, .keep_trajectory = false}), 4e-10, 1e-3);  // 3.9e-11 and 1.3e-4
}

void stays_on_the_rod(double count, double most_drift, const Options& options) {
  const auto rod = scene(mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return 9.81 * q[1]; }),
                         holonomic("rod", [](const auto& q) { return q.squaredNorm() - 1.0; }));
  const State<2> start{0.0, Eigen::Vector2d(std::sin(1.0), -std::cos(1.0)), Eigen::Vector2d(0.0, 0.0)};
  const auto run = simulate(rod, start, count * period, Dop853{}, options);
  INFO(run.message);
  REQUIRE(run.completed());
  const State<2> end = run.state();
  const double drift = std::abs(energy(rod, end.q, end.qdot) - energy(rod, start.q, start.qdot)) / well;
  CHECK(drift < most_drift);
  CHECK(std::abs(end.q.norm() - 1.0) < 1e-15);
  CHECK(run.statistics.constraint_residual < 1e-15);
  CHECK(run.statistics.constraint_velocity < 4e-15);
}

TEST_CASE("a million periods of a pendulum in Cartesian coordinates stay on the rod", "[long]") {
  stays_on_the_rod(periods, 1e-4,  // 3.2e-5 was seen
                   {.rtol = 1e-10, .atol = 1e-11, .max_steps = 100'000'000, .energy_drift_limit = 1e9, .keep_trajectory = false});
}

TEST_CASE("a thousand periods neither drift off the circle nor gain energy") {
  // Local errors of 1e-9 in 30 000 steps, all of one sign.
  stays_on_the_rod(1000, 3e-5 / well, {.keep_trajectory = false});
}

TEST_CASE("the energy error of a Kepler orbit does not grow over a thousand periods") {
  const auto kepler = mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); },
                                           [](const auto& q) {
                                             using std::sqrt;
                                             return -1.0 / sqrt(q[0] * q[0] + q[1] * q[1]);
                                           });
  const State<2> perihelion{0.0, {0.4, 0.0}, {0.0, 2.0}};  // e = 0.6, period 2π, H = −1/2
  using enum SplittingScheme;
  const std::pair<SplittingScheme, double> steps[] = {{verlet, 0.02},        {yoshida_4, 0.02},     {mclachlan_atela_4, 0.04}, {blanes_moan_4, 0.06},
                                                      {kahan_li_6, 0.06}, {blanes_moan_6, 0.06}, {kahan_li_8, 0.06}};
  for (const auto& [scheme, h] : steps) {
    double early = 0.0, late = 0.0;
    const double t_end = 1000 * 2 * std::numbers::pi;
    simulate(kepler, perihelion, t_end, Splitting{.step = h, .scheme = scheme}, {.keep_trajectory = false}, [&](const StepView& step) {
      const double error = std::abs(energy(kepler, State<2>{0.0, step.q(), step.qdot()}) + 0.5);
      if (step.t() < 0.1 * t_end) early = std::max(early, error);
      if (step.t() > 0.9 * t_end) late = std::max(late, error);
    });
    INFO(detail::splitting(scheme).name << " early " << early << ", late " << late);
    CHECK(late < 1.5 * early);
    CHECK(early < 0.05);
  }
}

}  // namespace
