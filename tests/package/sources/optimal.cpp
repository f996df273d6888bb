// SPDX-License-Identifier: MIT
#include <qdot/analysis/trajectory_optimization.hpp>

#include <cmath>

struct Point {
  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q) const { return 0.0 * q[0]; }
};

int main() {
  const auto pushed = scene(qdot::mechanical_system<1>(Point{}), qdot::input("push", 0));
  const auto way = trajectory_optimization(pushed, {.start = {0.0, {0.0}, {0.0}}, .end = {1.0, {1.0}, {0.0}}},
                                           qdot::least_integral([](const auto&, const auto&, const auto& u) { return u[0] * u[0]; }));
  return way.solved() && std::abs(way.cost - 12.0) < 1e-6 ? 0 : 1;
}
