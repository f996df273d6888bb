// SPDX-License-Identifier: MIT
//
// What every registry's test of its package compiles and runs: a pendulum at 90° falls with g/l.
#include <cmath>
#include <cstdio>

#include <qdot/mechanics/equations_of_motion.hpp>
#include <qdot/mechanics/system.hpp>
#include <qdot/version.hpp>

int main() {
  const auto system = qdot::mechanical_system<1>([](const auto&, const auto& qdot) { return 0.5 * qdot[0] * qdot[0]; },
                                                 [](const auto& q) {
                                                   using std::cos;
                                                   return -9.81 * cos(q[0]);
                                                 });
  const qdot::State<1> s{0.0, {std::acos(0.0)}, {0.0}};
  const double falls = acceleration(system, s)[0];
  std::printf("qdot %d.%d.%d: %.6f\n", qdot::version_major, qdot::version_minor, qdot::version_patch, falls);
  return std::abs(falls + 9.81) < 1e-12 ? 0 : 1;
}
