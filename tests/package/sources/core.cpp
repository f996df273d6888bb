// SPDX-License-Identifier: MIT
//
// A user of the core: a pendulum's acceleration is −(g/l) sin φ.
#include <qdot/qdot.hpp>

#include <cmath>

double energy_in_second_unit();

int main() {
  const double m = 2.0, l = 0.5, g = 9.81, phi = 0.3;
  const auto pendulum = qdot::mechanical_system<1>([=](const auto& qdot) { return 0.5 * m * l * l * qdot[0] * qdot[0]; },
                                                   [=](const auto& q) {
                                                     using std::cos;
                                                     return -m * g * l * cos(q[0]);
                                                   });
  const Eigen::Matrix<double, 1, 1> q(phi), qdot(1.0);
  const double acceleration = qdot::acceleration(pendulum, q, qdot)[0];
  const bool right = std::abs(acceleration + g / l * std::sin(phi)) < 1e-14 && std::abs(energy_in_second_unit() - 1.0) < 1e-14;
  return right ? 0 : 1;
}
