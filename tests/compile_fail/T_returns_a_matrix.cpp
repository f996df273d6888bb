// SPDX-License-Identifier: MIT
//
// T returns a 1×1 matrix.
// message: qdot: the kinetic energy T must return the scalar type of its arguments
#include <qdot/qdot.hpp>

int main() {
  const auto system = qdot::mechanical_system<2>(
      [](const auto&, const auto& qdot) { return (0.5 * qdot.transpose() * qdot).eval(); },
      [](const auto& q) { return q.dot(q); });
  const Eigen::Vector2d q(0.1, 0.2), qdot(0.3, 0.4);
  return qdot::acceleration(system, q, qdot)[0] > 0.0 ? 1 : 0;
}
