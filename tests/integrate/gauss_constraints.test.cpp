// SPDX-License-Identifier: MIT
//
// Gauss steps on constraints, by projection after each step.
#include <cmath>

#include "../catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/contact.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/gauss.hpp"
#include "qdot/integrate/simulate.hpp"

namespace {

using namespace qdot;
using Eigen::Vector2d;

const Options bare_run{.keep_trajectory = false};

const auto pendulum = scene(mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return 9.81 * q[1]; }),
                            holonomic("rod", [](const auto& q) { return q.squaredNorm() - 1.0; }));
constexpr double period = 2.13913760055869;  // from 1 rad: 4 √(l/g) K(sin² ½)

TEST_CASE("constraints are kept to rounding, with the order of the method") {
  const State<2> released{0.0, Vector2d(std::sin(1.0), -std::cos(1.0)), Vector2d(0.0, 0.0)};
  for (const int s : {2, 3}) {
    const auto run_with = [&](int steps) { return simulate(pendulum, released, period, Gauss{.step = period / steps, .stages = s}, bare_run); };
    const auto fine = run_with(80);
    REQUIRE(fine.completed());
    CHECK(fine.statistics.constraint_residual < 1e-14);
    CHECK(fine.statistics.constraint_velocity < 1e-14);
    const double coarse_error = (run_with(40).y.head(2) - released.q).norm(), fine_error = (fine.y.head(2) - released.q).norm();
    INFO(s << " stages, errors " << coarse_error << ", " << fine_error);
    CHECK(std::log2(coarse_error / fine_error) > 2 * s - 0.7);
  }
}

TEST_CASE("contacts that switch are stepped from bounce to bounce") {
  const auto ball = scene(mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return 9.81 * q[0]; }),
                          contact("floor", [](const auto& q) { return q[0]; }, restitution(0.8)));
  // Falls √(2/g), then flies 2 · 0.8 √(2/g) and 2 · 0.64 √(2/g); the end is the summit of the third flight, 0.8⁴ high.
  const double fall = std::sqrt(2 / 9.81);
  const auto run = simulate(ball, State<1>{0.0, Vector<double, 1>(1.0), Vector<double, 1>(0.0)}, fall * (1 + 1.6 + 0.64), Gauss{.step = 0.01, .stages = 1});
  REQUIRE(run.completed());
  CHECK(run.events.size() == 2);
  CHECK_THAT(run.y[0], WithinAbs(std::pow(0.8, 4), 1e-12));
  CHECK_THAT(run.y[1], WithinAbs(0.0, 1e-12));
}

}  // namespace
