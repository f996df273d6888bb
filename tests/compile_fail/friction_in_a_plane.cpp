// SPDX-License-Identifier: MIT
//
// message: the sliding velocity of dry friction must be one number, or a vector of two or three whose size is known at compile time
#include <qdot/effects/dry_friction.hpp>
#include <qdot/effects/scene_form.hpp>
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/integrate/simulate.hpp>

int main() {
  using namespace qdot;
  const auto puck = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); });
  const auto table = dry_friction("table", [](const auto&, const auto& v) { return (v * v.transpose()).eval(); }, 2.0);
  return simulate(scene(puck, table), State<2>{0.0, {0.0, 0.0}, {3.0, 4.0}}, 3.0, Dop853{}).completed() ? 0 : 1;
}
