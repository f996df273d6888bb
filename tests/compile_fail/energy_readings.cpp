// SPDX-License-Identifier: MIT
//
// Energies that can be read in two ways, or whose time is a double.
// message: qdot: the kinetic energy can be called as T(qdot) and as T(q, qdot), and nothing tells which is meant
// message: qdot: what the kinetic energy T takes after q and qdot is the time, which carries derivatives as they do
// message: qdot: what the potential energy V takes after q is the time, which carries derivatives as q does
// message: qdot: the functor that places the bodies can be called as place(q, bodies) and with a third argument
// message: qdot: the functor that places the bodies takes the time as a double
#include <qdot/mechanics/kinematic_system.hpp>

int main() {
  const auto sum = [](const auto& first, const auto&...) { return 0.5 * first.dot(first); };
  const auto free = [](const auto& qdot) { return 0.5 * qdot.dot(qdot); };
  const auto T = [](const auto& q, const auto& qdot, double t = 0.0) { return (0.5 + t) * qdot.dot(qdot) + 0.0 * q[0]; };
  const auto V = [](const auto& q, double t = 0.0) { return -t * q[0]; };
  const auto place = [](const auto& q, auto& bodies, double t = 0.0) { bodies.point_mass(1.0 + t, q); };
  const auto shaken = [](const auto& q, double t, auto& bodies) { bodies.point_mass(1.0 + t, q); };
  return static_cast<int>(qdot::mechanical_system<2>(sum).dof() + qdot::mechanical_system<2>(T).dof() + qdot::mechanical_system(2, free, V).dof() +
                          qdot::kinematic_system<2>(place).dof() + qdot::kinematic_system<2>(shaken).dof());
}
