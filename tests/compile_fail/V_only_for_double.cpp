// SPDX-License-Identifier: MIT
//
// V takes a vector of double.
// message: qdot: the potential energy V must return the scalar type of its argument: not a double (take `const auto& q`
#include <qdot/qdot.hpp>

int main() {
  const auto system = qdot::mechanical_system<2>(
      [](const auto& q, const auto& qdot) { return 0.5 * (1.0 + q[0] * q[0]) * qdot.dot(qdot); },
      [](const Eigen::Vector2d& q) { return q.dot(q); });
  const Eigen::Vector2d q(0.1, 0.2), qdot(0.3, 0.4);
  return qdot::acceleration(system, q, qdot)[0] > 0.0 ? 1 : 0;
}
