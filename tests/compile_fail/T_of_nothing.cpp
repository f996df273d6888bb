// SPDX-License-Identifier: MIT
//
// T takes no argument.
// message: qdot: the kinetic energy must be callable as T(qdot), T(q, qdot) or T(q, qdot, t)
#include <qdot/qdot.hpp>

int main() {
  const auto system = qdot::mechanical_system<2>(
      [] { return 0.5; },
      [](const auto& q) { return q.dot(q); });
  const Eigen::Vector2d q(0.1, 0.2), qdot(0.3, 0.4);
  return qdot::acceleration(system, q, qdot)[0] > 0.0 ? 1 : 0;
}
