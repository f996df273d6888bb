// SPDX-License-Identifier: MIT
//
// A start, a state and a run that do not fit their system.
// message: qdot: q and qdot must have one entry for each coordinate of the system
// message: qdot: the start is a State of another number of coordinates than the system has
// message: qdot: simulate() needs a method after t_end
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/integrate/simulate.hpp>

int main() {
  const auto free = qdot::mechanical_system<2>([](const auto& qdot) { return 0.5 * qdot.dot(qdot); });
  const qdot::State<3> three{0.0, {1.0, 2.0, 3.0}, {0.0, 0.0, 0.0}};
  const bool moves = acceleration(free, three.q, three.qdot)[0] > 0.0;
  simulate(free, three, 1.0, qdot::Dop853{});
  simulate(free, qdot::State<2>{0.0, {1.0, 2.0}, {0.0, 0.0}}, 1.0, {.rtol = 1e-6});
  return moves;
}
