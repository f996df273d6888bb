// SPDX-License-Identifier: MIT
//
// T takes vectors of double.
// message: qdot: the kinetic energy T must return the scalar type of its arguments: not a double (take `const auto& q`
#include <qdot/qdot.hpp>

int main() {
  const auto system = qdot::mechanical_system<2>(
      [](const Eigen::Vector2d& q, const Eigen::Vector2d& qdot) { return 0.5 * (1.0 + q[0] * q[0]) * qdot.dot(qdot); },
      [](const auto& q) { return q.dot(q); });
  const Eigen::Vector2d q(0.1, 0.2), qdot(0.3, 0.4);
  return qdot::acceleration(system, q, qdot)[0] > 0.0 ? 1 : 0;
}
