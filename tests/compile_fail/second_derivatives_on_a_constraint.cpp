// SPDX-License-Identifier: MIT
// message: qdot: second derivatives of a motion take no constraints, contacts or dry friction; difference sensitivities()
#include <qdot/analysis/second_sensitivity.hpp>
#include <qdot/qdot.hpp>

int main() {
  const auto point = qdot::mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); }, [](const auto& q) { return 9.81 * q[1]; });
  const auto rod = qdot::scene(point, qdot::holonomic("rod", [](const auto& q) { return q[0] * q[0] + q[1] * q[1] - 1.0; }));
  return qdot::second_sensitivities(rod, qdot::State<2>{0.0, {0.0, -1.0}, {1.0, 0.0}}, 1.0, qdot::Taylor{}).completed() ? 0 : 1;
}
