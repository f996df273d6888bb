// SPDX-License-Identifier: MIT
//
// A user of effects and events: a block on a sloping track, with dry friction and a stop at its end, slides up and holds.
#include <cmath>

#include <qdot/effects/constraints.hpp>
#include <qdot/effects/contact.hpp>
#include <qdot/effects/dry_friction.hpp>
#include <qdot/effects/scene_form.hpp>
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/integrate/simulate.hpp>

int main() {
  const auto block = qdot::mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [](const auto& q) { return 2.0 * q[0] + 9.81 * q[1]; });
  const auto track = qdot::scene(block, qdot::holonomic("track", [](const auto& q) { return q[1]; }), qdot::dry_friction("block", 0, 3.0, 4.0),
                                 qdot::contact("stop", [](const auto& q) { return 1.0 - q[0]; }));
  const auto half = qdot::event("half", [](const auto& q, const auto&) { return q[0] - 0.05; });
  const auto run = qdot::simulate(track, qdot::State<2>{0.0, {0.0, 0.0}, {1.0, 0.0}}, 1.0, qdot::Dop853{},
                                  {.rtol = 1e-10, .atol = 1e-12, .output_times = {0.1}}, qdot::events(half));
  // Slope and friction brake by 2 + 3: it stops at 1/10 when t = 1/5, and passes the half of that when t = (1 − √½)/5. At t = 1/10 it is at 3/40, with ½.
  const bool sampled = std::abs(run.samples.y(0, 0) - 0.075) < 1e-9 && std::abs(run.samples.y(2, 0) - 0.5) < 1e-9;
  const bool right = run.events.size() == 2 && std::abs(run.events[0].t - (1.0 - std::sqrt(0.5)) / 5.0) < 1e-9 && std::abs(run.y[0] - 0.1) < 1e-9 && sampled;
  return right ? 0 : 1;
}
