#pragma once
// SPDX-License-Identifier: MIT
//
// A symmetric top whose tip is held at O, in Euler's angles: θ of the axis from the upward vertical, φ of the axis around it,
// ψ of the body around its axis. I₁ and I₃ are taken about O, l is the distance from O to the centre of mass:
//
//     T = ½ I₁ (θ̇² + sin² θ φ̇²) + ½ I₃ (ψ̇ + φ̇ cos θ)²,      V = m g l cos θ.
//
// φ and ψ do not occur in L. The start is the cuspidal motion: the axis is let go at rest. At θ = 0 these angles fail.

#include <cmath>
#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct HeavyTop {
  double I1 = 1.0;  // moment of inertia across the axis, about O
  double I3 = 0.7;  // moment of inertia about the axis
  double m = 1.0;   // mass
  double g = 9.81;  // gravity
  double l = 0.2;   // from O to the centre of mass

  constexpr auto T(const auto& q, const auto& qdot) const {
    using std::cos, std::sin;
    const auto s = sin(q[0]);
    const auto spin = qdot[2] + qdot[1] * cos(q[0]);
    return 0.5 * I1 * (qdot[0] * qdot[0] + s * s * qdot[1] * qdot[1]) + 0.5 * I3 * spin * spin;
  }

  constexpr auto V(const auto& q) const {
    using std::cos;
    return m * g * l * cos(q[0]);
  }
};

inline Scene<HeavyTop, 3> heavy_top() {
  return {
      .name = "heavy_top",
      .title = "Heavy symmetric top",
      .summary = "A spinning top with its tip held, let go with its axis at rest: it nutates between two angles and precesses in cusps.",
      .parameters = {{"I1", &HeavyTop::I1, "kg m^2", Range::positive, "moment of inertia across the axis"},
                     {"I3", &HeavyTop::I3, "kg m^2", Range::positive, "moment of inertia about the axis"},
                     {"m", &HeavyTop::m, "kg", Range::positive, "mass"},
                     {"g", &HeavyTop::g, "m/s^2", Range::non_negative, "gravity"},
                     {"l", &HeavyTop::l, "m", Range::non_negative, "distance from the tip to the centre of mass"}},
      .coordinates = {{"theta", "rad"}, {"phi", "rad"}, {"psi", "rad"}},
      .start = {0.6, 0.0, 0.0, 0.0, 0.0, 8.0},
      .t_end = 10.0,
      .drawing = report::in_space({report::trail(1, 1, 6.0), report::ellipse(2, 3, 4, 0), report::line({2, 3}, 0), report::line({0, 1}),
                                   report::pivot(0), report::disk(1, 1, 4)}),
      .positions = [](const HeavyTop&, const Vector<double, 3>& q, double) -> std::vector<Point> {
        const double ct = std::cos(q[0]), st = std::sin(q[0]), cp = std::cos(q[1]), sp = std::sin(q[1]);
        const auto at = [&](double along, double radius, double angle) {  // in the body: along the axis, then around it
          const double u = radius * std::cos(angle), v = radius * std::sin(angle);
          return Point{along * st * sp + u * cp - v * sp * ct, -along * st * cp + u * sp + v * cp * ct, along * ct + v * st};
        };
        constexpr double quarter = 1.5707963267948966;
        return {{0.0, 0.0, 0.0}, at(1.0, 0.0, 0.0), at(0.6, 0.0, 0.0), at(0.6, 0.45, q[2]), at(0.6, 0.45, q[2] + quarter)};
      },
  };
}

}  // namespace qdot::scenes
