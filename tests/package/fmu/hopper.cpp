// SPDX-License-Identifier: MIT
//
// Two motions with closed forms beside each other: a ball over a floor that is pushed, and a bead on a spring that hardens.
#include <qdot/effects/contact.hpp>
#include <qdot/effects/input.hpp>
#include <scenes/own_scene.hpp>
using namespace qdot::scenes;

struct Hopper {
  double m = 2.0, g = 9.81, e = 0.5, k = 3.0;
  auto T(const auto& qdot) const { return 0.5 * m * (qdot[0] * qdot[0] + qdot[1] * qdot[1]); }
  auto V(const auto& q) const { return m * g * q[0] + 0.25 * k * q[1] * q[1] * q[1] * q[1]; }
};

OwnScene qdot_scene() {
  return runnable_with(
      [](const Hopper& s) {
        return std::tuple(qdot::contact("floor", [](const auto& q) { return q[0]; }, qdot::restitution(s.e)), qdot::input("push", 0));
      },
      Scene<Hopper, 2>{.summary = "A ball that bounces & a bead on a spring.",
                       .parameters = {{"m", &Hopper::m, "kg", Range::positive, "mass of each"},
                                      {"g", &Hopper::g, "m/s^2", Range::between(0, 100), "gravity"},
                                      {"e", &Hopper::e, "", Range::between(0, 1), "restitution"},
                                      {"k", &Hopper::k, "N/m^3", Range::positive, "stiffness"}},
                       .coordinates = {{"h", "m"}, {"x", "m"}},
                       .start = {1.25, 1.0},
                       .t_end = 2},
      optional_effect<Hopper>("drag", 0.5, "N s/m", Range::non_negative, "force per velocity of the bead",
                              [](const Hopper&, double c) { return qdot::viscous_damping(qdot::Vector<double, 2>(0.0, c)); }));
}
