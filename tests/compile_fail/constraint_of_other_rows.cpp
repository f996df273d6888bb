// SPDX-License-Identifier: MIT
//
// Two rows where three are declared.
// message: qdot: this constraint returns another number of rows than it declares
#include <qdot/effects/constraints.hpp>
#include <qdot/effects/scene_form.hpp>

int main() {
  const auto system = qdot::mechanical_system<2>([](const auto& qdot) { return 0.5 * qdot.dot(qdot); });
  const auto held = scene(system, qdot::holonomic<3>("grip", [](const auto& q) { return qdot::vector(q[0], q[1]); }));
  return held.dof() == 2 ? 0 : 1;
}
