// SPDX-License-Identifier: MIT
//
// A formula must take every scalar, and here it does not take any time but a double.
// message: qdot: the function of an event that is a formula must take every scalar, the time included
#include <qdot/qdot.hpp>

int main() {
  const auto oscillator = qdot::mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; },
                                                     [](const auto& q) { return 0.5 * q[0] * q[0]; });
  const auto g = [](const auto& q, const auto&, double t) { return q[0] - t; };
  const auto run = qdot::simulate(oscillator, qdot::State<1>{0.0, qdot::vector(1.0), qdot::vector(0.0)}, 1.0, qdot::Dop853{}, {},
                                  qdot::events(qdot::event("g", g).formula()));
  return run.completed() ? 0 : 1;
}
