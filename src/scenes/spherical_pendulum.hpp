#pragma once
// SPDX-License-Identifier: MIT
//
// A bob on a massless rod that swings in space; θ from the downward vertical, φ around it:
//
//     T = ½ m l² (θ̇² + sin² θ φ̇²),      V = −m g l cos θ.
//
// φ does not occur in L, so p_φ = m l² sin² θ φ̇ is conserved. At the poles sin θ = 0 the coordinates fail: M is singular there.

#include <cmath>
#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct SphericalPendulum {
  double m = 1.0;   // mass of the bob
  double l = 1.0;   // length of the rod
  double g = 9.81;  // gravity

  constexpr auto T(const auto& q, const auto& qdot) const {
    using std::sin;
    const auto s = sin(q[0]);
    return 0.5 * m * l * l * (qdot[0] * qdot[0] + s * s * qdot[1] * qdot[1]);
  }

  constexpr auto V(const auto& q) const {
    using std::cos;
    return -m * g * l * cos(q[0]);
  }
};

inline Scene<SphericalPendulum, 2> spherical_pendulum() {
  return {
      .name = "spherical_pendulum",
      .title = "Spherical pendulum",
      .summary = "A bob on a massless rod that swings in space: a rosette around the vertical.",
      .parameters = {{"m", &SphericalPendulum::m, "kg", Range::positive, "mass of the bob"},
                     {"l", &SphericalPendulum::l, "m", Range::positive, "length of the rod"},
                     {"g", &SphericalPendulum::g, "m/s^2", Range::non_negative, "gravity"}},
      .coordinates = {{"theta", "rad"}, {"phi", "rad"}},
      .start = {1.2, 0.0, 0.0, 1.0},
      .t_end = 20.0,
      .drawing = report::in_space({report::ellipse(0, 2, 3), report::ellipse(0, 2, 4), report::trail(1, 0, 4.0), report::line({0, 1}),
                                   report::pivot(0), report::disk(1)}),
      .positions = [](const SphericalPendulum& s, const Vector<double, 2>& q, double) -> std::vector<Point> {
        const double rho = s.l * std::sin(q[0]);
        return {{0.0, 0.0, 0.0}, {rho * std::cos(q[1]), rho * std::sin(q[1]), -s.l * std::cos(q[0])}, {s.l, 0.0, 0.0}, {0.0, s.l, 0.0}, {0.0, 0.0, s.l}};
      },
  };
}

}  // namespace qdot::scenes
