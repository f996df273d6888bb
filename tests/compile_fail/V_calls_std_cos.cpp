// SPDX-License-Identifier: MIT
//
// V calls std::cos itself.
// message: no matching function for call to
// message: and for functions say `using std::cos;` and then `cos(q[0])`, since std::cos itself takes nothing but numbers
#include <qdot/qdot.hpp>

int main() {
  const auto pendulum = qdot::mechanical_system<1>([](const auto& qdot) { return 0.5 * qdot.dot(qdot); },
                                                   [](const auto& q) { return -9.81 * std::cos(q[0]); });
  return pendulum.dof() == 1 ? 0 : 1;
}
