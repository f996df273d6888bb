#pragma once
// SPDX-License-Identifier: MIT
//
// A bob on a rope, the pivot at the origin and y upwards:
//
//     T = ½ m (ẋ² + ẏ²),   V = m g y,      √(x² + y²) ≤ l .
//
// Thrown from the bottom with 2 g l < v₀² < 5 g l it rises above the pivot until the tension m (g cos θ + v²/l) is gone, at cos θ
// = (2 − v₀²/gl)/3 from the bottom. There the rope goes slack and the bob flies a parabola until the rope jerks.

#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct RopePendulum {
  double m = 1.0;   // mass of the bob
  double l = 1.0;   // length of the rope
  double g = 9.81;  // gravity
  double e = 0.0;   // restitution of the taut rope

  constexpr auto T(const auto& qdot) const { return 0.5 * m * (qdot[0] * qdot[0] + qdot[1] * qdot[1]); }
  constexpr auto V(const auto& q) const { return m * g * q[1]; }
};

inline Scene<RopePendulum, 2> rope_pendulum() {
  return {
      .name = "rope_pendulum",
      .title = "Pendulum on a rope",
      .summary = "A bob on a rope that can only pull: thrown hard enough it leaves its circle, flies, and is caught by the rope.",
      .parameters = {{"m", &RopePendulum::m, "kg", Range::positive, "mass of the bob"},
                     {"l", &RopePendulum::l, "m", Range::positive, "length of the rope"},
                     {"g", &RopePendulum::g, "m/s^2", Range::non_negative, "gravity"},
                     {"e", &RopePendulum::e, "", Range::non_negative, "restitution of the rope when it jerks"}},
      .coordinates = {{"x", "m"}, {"y", "m"}},
      .start = [](const RopePendulum& s) { return State<2>{0.0, {0.0, -s.l}, {5.5, 0.0}}; },
      .t_end = 5.0,
      .drawing = {report::trail(1, 0, 1.0), report::line({0, 1}), report::pivot(0), report::disk(1)},
      .positions = [](const RopePendulum&, const Vector<double, 2>& q, double) -> std::vector<Point> {
        return {{0.0, 0.0}, {q[0], q[1]}};
      },
  };
}

}  // namespace qdot::scenes
