// SPDX-License-Identifier: MIT
//
// V branches on its numbers, which lanes of a pack cannot do apart.
// message: qdot: lanes of a pack cannot branch apart
#include <qdot/mechanics/accelerations.hpp>

int main() {
  const auto V = [](const auto& q) {
    if (q[0] < 0.0) return -q[0];
    return 2.0 * q[0];
  };
  const qdot::Pack<4> q(0.5);
  const Eigen::Matrix<qdot::Pack<4>, 1, 1> x(q);
  return V(x)[0] > 0.0 ? 1 : 0;
}
