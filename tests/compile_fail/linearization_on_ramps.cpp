// SPDX-License-Identifier: MIT
// message: qdot: equilibria and linearizations hold their inputs: put input(…) in place of interpolated(input(…))
#include <qdot/analysis/linearization.hpp>
#include <qdot/qdot.hpp>

int main() {
  const auto system = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return q[0] * q[0]; });
  const auto driven = scene(system, qdot::interpolated(qdot::input("motor", 0)));
  return qdot::linearization(driven, qdot::State<1>{0.0, {0.0}, {0.0}}).A.size() > 0 ? 0 : 1;
}
