#pragma once
// SPDX-License-Identifier: MIT
//
// The lecture's rod on a pivot O with a ring that slides on it; r from O, φ from the horizontal, I_O = M L²/3:
//
//     T = ½ I_O φ̇² + ½ m (ṙ² + r² φ̇²),      V = (m r + ½ M L) g sin φ.
//
// Lagrange's equations are then  r̈ = r φ̇² − g sin φ  and  (I_O + m r²) φ̈ + 2 m r ṙ φ̇ + (m r + ½ M L) g cos φ = 0.
// By itself the rod is taken as endless: past r = L the ring keeps sliding on its prolongation. `--with end_stop` puts a stop at
// its end, `--with open_end` ends the run where the ring leaves it.

#include <cmath>
#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct RodAndRing {
  double M = 2.0;   // mass of the rod
  double L = 1.5;   // length of the rod
  double m = 0.3;   // mass of the ring
  double g = 9.81;  // gravity

  constexpr auto T(const auto& q, const auto& qdot) const {
    const double I_O = M * L * L / 3.0;
    return 0.5 * I_O * qdot[1] * qdot[1] + 0.5 * m * (qdot[0] * qdot[0] + q[0] * q[0] * qdot[1] * qdot[1]);
  }

  constexpr auto V(const auto& q) const {
    using std::sin;
    return (m * q[0] + 0.5 * M * L) * g * sin(q[1]);
  }
};

inline Scene<RodAndRing, 2> rod_and_ring() {
  return {
      .name = "rod_and_ring",
      .title = "Rod with a sliding ring",
      .summary = "A rod turns about its end in a vertical plane while a ring slides on it without friction; the angle is measured from the horizontal.",
      .parameters = {{"M", &RodAndRing::M, "kg", Range::positive, "mass of the rod"},
                     {"L", &RodAndRing::L, "m", Range::positive, "length of the rod"},
                     {"m", &RodAndRing::m, "kg", Range::positive, "mass of the ring"},
                     {"g", &RodAndRing::g, "m/s^2", Range::non_negative, "gravity"}},
      .coordinates = {{"r", "m"}, {"phi", "rad"}},
      .start = {0.4, 0.2, 0.1, 1.0},
      .t_end = 1.0,
      .drawing = {report::trail(2, 1), report::line({1, 2}, 6), report::line({0, 1}), report::pivot(0),
                  report::disk(2, 1)},
      .positions = [](const RodAndRing& s, const Vector<double, 2>& q, double) -> std::vector<Point> {
        const double c = std::cos(q[1]), sn = std::sin(q[1]);
        return {{0.0, 0.0}, {s.L * c, s.L * sn}, {q[0] * c, q[0] * sn}};
      },
  };
}

}  // namespace qdot::scenes
