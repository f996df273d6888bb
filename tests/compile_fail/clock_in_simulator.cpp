// SPDX-License-Identifier: MIT
// message: qdot: whoever owns a simulator owns its clock: advance to the times of every(), and act there
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/integrate/simulator.hpp>

int main() {
  const auto system = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [](const auto& q) { return q[0] * q[0]; });
  const qdot::State<1> start{0.0, {1.0}, {0.0}};
  qdot::Simulator plant(system, start, qdot::Dop853{}, {}, qdot::events(qdot::every("tick", 0.1)));
}
