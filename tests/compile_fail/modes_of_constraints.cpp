// SPDX-License-Identifier: MIT
//
// Normal modes of a scene with a constraint.
// message: ask damped_modes(linearization(scene, equilibrium_near(scene, q)))
#include <qdot/effects/constraints.hpp>
#include <qdot/qdot.hpp>

int main() {
  const auto system = qdot::mechanical_system<2>([](const auto& qdot) { return 0.5 * qdot.dot(qdot); }, [](const auto& q) { return 9.81 * q[1]; });
  const auto held = scene(system, qdot::holonomic("rod", [](const auto& q) { return q.squaredNorm() - 1.0; }));
  return qdot::normal_modes(held, Eigen::Vector2d(0.0, -1.0)).shapes.size() > 0 ? 0 : 1;
}
