// SPDX-License-Identifier: MIT
//
// Integers where real numbers are meant.
// message: qdot: these numbers are integers, and so would be all that is computed from them
// message: require_sizes
// message: integers.cpp:17
// message: integers.cpp:18
#include <qdot/mechanics/energy.hpp>
#include <qdot/mechanics/equations_of_motion.hpp>
#include <qdot/mechanics/rotation.hpp>

int main() {
  const auto ball = qdot::mechanical_system<2>([](const auto& qdot) { return 0.5 * qdot.dot(qdot); }, [](const auto& q) { return 9.81 * q[1]; });
  const Eigen::Vector2i q(0, 1);
  const Eigen::Matrix<short, 2, 1> steps(0, 1);
  const bool falls = acceleration(ball, q, q)[1] < 0;
  const bool rises = qdot::gradient([](const auto& x) { return x[0] * x[1]; }, steps)[0] > 0;
  const bool turned = qdot::euler_rotation_313(1L, 0L, 0L)(0, 0) < 1;
  return falls + rises + turned;
}
