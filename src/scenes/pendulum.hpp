#pragma once
// SPDX-License-Identifier: MIT
//
// A bob on a massless rod, θ from the downward vertical:
//
//     T = ½ m l² θ̇²,   V = −m g l cos θ,   θ̈ = −(g/l) sin θ.
//
// Its period is 4 √(l/g) K(sin² ½θ₀), with the complete elliptic integral K of the parameter.

#include <cmath>
#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct Pendulum {
  double m = 1.0;   // mass of the bob
  double l = 1.0;   // length of the rod
  double g = 9.81;  // gravity

  constexpr auto T(const auto& qdot) const { return 0.5 * m * l * l * qdot[0] * qdot[0]; }

  constexpr auto V(const auto& q) const {
    using std::cos;
    return -m * g * l * cos(q[0]);
  }
};

inline Scene<Pendulum, 1> pendulum() {
  return {
      .name = "pendulum",
      .title = "Pendulum",
      .summary = "A bob on a massless rod, swinging in a plane; the angle is measured from the downward vertical.",
      .parameters = {{"m", &Pendulum::m, "kg", Range::positive, "mass of the bob"},
                     {"l", &Pendulum::l, "m", Range::positive, "length of the rod"},
                     {"g", &Pendulum::g, "m/s^2", Range::non_negative, "gravity"}},
      .coordinates = {{"theta", "rad"}},
      .start = {2.5},
      .t_end = 10.0,
      .drawing = {report::trail(1, 0, 1.0), report::line({0, 1}), report::pivot(0), report::disk(1)},
      .positions = [](const Pendulum& s, const Vector<double, 1>& q, double) -> std::vector<Point> {
        return {{0.0, 0.0}, {s.l * std::sin(q[0]), -s.l * std::cos(q[0])}};
      },
  };
}

}  // namespace qdot::scenes
