// SPDX-License-Identifier: MIT
//
// A spring from a point in a plane to one in space.
// message: qdot: both ends of a spring, a damper, a rope or a tension must have as many coordinates
#include <qdot/effects/dissipation.hpp>
#include <qdot/effects/scene_form.hpp>

int main() {
  const auto point = qdot::mechanical_system<2>([](const auto& qdot) { return 0.5 * qdot.dot(qdot); });
  const auto held = scene(point, qdot::spring_damper([](const auto& q) { return q; }, Eigen::Vector3d(0, 0, 1), 1.0, 0.5));
  return acceleration(held, Eigen::Vector2d(1, 0), Eigen::Vector2d(0, 0))[0] < 0.0 ? 0 : 1;
}
