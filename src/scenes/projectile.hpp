#pragma once
// SPDX-License-Identifier: MIT
//
// The material point in a potential: with V = m g z Lagrange's equations are Newton's, m r̈ = −m g e_z, and the motion is the
// parabola z = z₀ + ż₀ t − g t²/2.

#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct Projectile {
  double m = 1.0;   // mass
  double g = 9.81;  // gravity

  constexpr auto T(const auto& qdot) const {
    return 0.5 * m * (qdot[0] * qdot[0] + qdot[1] * qdot[1] + qdot[2] * qdot[2]);
  }

  constexpr auto V(const auto& q) const { return m * g * q[2]; }
};

inline Scene<Projectile, 3> projectile() {
  return {
      .name = "projectile",
      .title = "Projectile",
      .summary = "A material point thrown in a uniform gravity field; its path is a parabola.",
      .parameters = {{"m", &Projectile::m, "kg", Range::positive, "mass"},
                     {"g", &Projectile::g, "m/s^2", Range::non_negative, "gravity"}},
      .coordinates = {{"x", "m"}, {"y", "m"}, {"z", "m"}},
      .start = {0.0, 0.0, 0.0, 10.0, 4.0, 14.0},
      .t_end = 2.8,
      .drawing = report::in_space({report::trail(0), report::trail(1, 6), report::disk(1, 6, 4), report::disk(0)}),
      .positions = [](const Projectile&, const Vector<double, 3>& q, double) -> std::vector<Point> {
        return {{q[0], q[1], q[2]}, {q[0], q[1], 0.0}};  // the point, and its shadow on the ground
      },
  };
}

}  // namespace qdot::scenes
