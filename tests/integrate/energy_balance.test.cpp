// SPDX-License-Identifier: MIT
#include "qdot/integrate/energy_balance.hpp"

#include <cmath>

#include "catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/dissipation.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/simulate.hpp"

using qdot::Dop853;
using qdot::scene;
using qdot::State;

namespace {

using Eigen::Vector2d;
using V1 = qdot::Vector<double, 1>;
const qdot::Options fine{.rtol = 1e-12, .atol = 1e-13};
constexpr double closes = 1e-10;  // the balance of motions with errors of 1e-12 a step

template <class Sys, int n>
qdot::EnergyBalance balance(const Sys& system, const State<n>& start, double t_end, const qdot::Options& options = fine) {
  auto meter = energy_balance(system);
  REQUIRE(simulate(system, start, t_end, Dop853{}, options, meter).completed());
  return meter.balance();
}

const auto mass = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; },
                                             [](const auto& q) { return 9.81 * q[0]; });

}  // namespace

TEST_CASE("what damping and a drive do to the energy is the work that is reported") {
  const auto damped = scene(mass, qdot::viscous_damping(V1(0.4)),
                            qdot::generalized_force([](const auto&, const auto&, const auto& t) {
                              using std::sin;
                              return 3.0 * sin(t);
                            }));
  const auto b = balance(damped, State<1>{0.0, V1(0.0), V1(2.0)}, 10.0);
  CHECK(b.largest_change > 1.0);
  CHECK(b.residual < closes);
  CHECK_THAT(b.work, WithinAbs(b.final - b.initial, closes));
  CHECK(b.impacts == 0.0);
}

TEST_CASE("a bouncing ball loses its energy in impacts, dry friction by work") {
  const auto ball = scene(mass, qdot::contact("floor", [](const auto& q) { return q[0]; }, qdot::restitution(0.6)));
  const auto bounced = balance(ball, State<1>{0.0, V1(1.0), V1(0.0)}, 3.0);
  CHECK_THAT(bounced.impacts, WithinAbs(-9.81, closes));
  CHECK(std::abs(bounced.work) < closes);
  CHECK(bounced.residual < closes);
  const auto block = scene(qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; },
                                                      [](const auto& q) { return 2.0 * q[0] * q[0]; }),
                           qdot::dry_friction("block", 0, 0.3));
  const auto slid = balance(block, State<1>{0.0, V1(1.0), V1(0.0)}, 15.0);
  // The way is 1.85 + 1.55 + 1.25 + 0.95 + 0.65 + 0.35 + 0.05.
  CHECK_THAT(slid.work, WithinAbs(-0.3 * 6.65, closes));
  CHECK(std::abs(slid.impacts) < closes);
  CHECK(slid.residual < closes);
}

TEST_CASE("constraints that move do work, and time in the energies changes h") {
  const auto free = qdot::mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); });
  const auto dragged = scene(free, qdot::prescribed("slide", 0, [](const auto& t) { return t * t; }));
  CHECK_THAT(balance(dragged, State<2>{0.0, Vector2d(0, 0), Vector2d(0, 1)}, 1.0).work, WithinAbs(2.0, closes));
  const auto stiffening = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; },
                                                     [](const auto& q, const auto& t) { return 0.5 * (1.0 + t) * q[0] * q[0]; });
  const auto b = balance(stiffening, State<1>{0.0, V1(1.0), V1(0.0)}, 5.0);
  CHECK(b.largest_change > 0.5);
  CHECK(b.residual < closes);
}

TEST_CASE("the balance does not close for a run that gains energy from its errors") {
  const auto b = balance(scene(mass, qdot::contact("floor", [](const auto& q) { return q[0]; }, qdot::restitution(1.0)),
                               qdot::generalized_force([](const auto& q, const auto&, const auto&) {
                                 using std::sin;
                                 return 30.0 * sin(20.0 * q[0]);
                               })),
                         State<1>{0.0, V1(1.0), V1(0.0)}, 5.0, {.rtol = 1e-2, .atol = 1e-2});
  CHECK(b.residual > 1e-4);
}
