// SPDX-License-Identifier: MIT
//
// The third coordinate of a system of two.
// message: qdot: the prescribed coordinate must be one of the system's, counted from 0
#include <qdot/effects/constraints.hpp>
#include <qdot/effects/scene_form.hpp>

int main() {
  const auto system = qdot::mechanical_system<2>([](const auto& qdot) { return 0.5 * qdot.dot(qdot); });
  const auto driven = scene(system, qdot::prescribed<2>("motor", [](const auto& t) { return t; }));
  return driven.dof() == 2 ? 0 : 1;
}
