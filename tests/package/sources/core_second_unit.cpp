// SPDX-License-Identifier: MIT
#include <qdot/qdot.hpp>

double energy_in_second_unit() {
  const auto free_point = qdot::mechanical_system<1>([](const auto& qdot) { return 0.5 * qdot[0] * qdot[0]; },
                                                     [](const auto& q) { return 0.5 * q[0] * q[0]; });
  const Eigen::Matrix<double, 1, 1> q(1.0), qdot(1.0);
  return qdot::energy(free_point, q, qdot);
}
