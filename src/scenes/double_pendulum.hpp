#pragma once
// SPDX-License-Identifier: MIT
//
// Two bobs on two massless rods, both angles from the downward vertical:
//
//     T = ½ (m₁+m₂) l₁² θ̇₁² + ½ m₂ l₂² θ̇₂² + m₂ l₁ l₂ θ̇₁ θ̇₂ cos(θ₁−θ₂),
//     V = −(m₁+m₂) g l₁ cos θ₁ − m₂ g l₂ cos θ₂.
//
// Small swings have ω² l/g = 2 ∓ √2 for equal masses and lengths; large ones are chaotic.

#include <cmath>
#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct DoublePendulum {
  double m1 = 1.0;  // mass of the inner bob
  double m2 = 1.0;  // mass of the outer bob
  double l1 = 1.0;  // length of the inner rod
  double l2 = 1.0;  // length of the outer rod
  double g = 9.81;  // gravity

  constexpr auto T(const auto& q, const auto& qdot) const {
    using std::cos;
    return 0.5 * (m1 + m2) * l1 * l1 * qdot[0] * qdot[0] + 0.5 * m2 * l2 * l2 * qdot[1] * qdot[1] +
           m2 * l1 * l2 * qdot[0] * qdot[1] * cos(q[0] - q[1]);
  }

  constexpr auto V(const auto& q) const {
    using std::cos;
    return -(m1 + m2) * g * l1 * cos(q[0]) - m2 * g * l2 * cos(q[1]);
  }
};

inline Scene<DoublePendulum, 2> double_pendulum() {
  return {
      .name = "double_pendulum",
      .title = "Double pendulum",
      .summary = "Two bobs on two massless rods; both angles are measured from the downward vertical. Large swings are chaotic.",
      .parameters = {{"m1", &DoublePendulum::m1, "kg", Range::positive, "mass of the inner bob"},
                     {"m2", &DoublePendulum::m2, "kg", Range::positive, "mass of the outer bob"},
                     {"l1", &DoublePendulum::l1, "m", Range::positive, "length of the inner rod"},
                     {"l2", &DoublePendulum::l2, "m", Range::positive, "length of the outer rod"},
                     {"g", &DoublePendulum::g, "m/s^2", Range::non_negative, "gravity"}},
      .coordinates = {{"theta1", "rad"}, {"theta2", "rad"}},
      .start = {1.7, 1.7},
      .t_end = 20.0,
      .drawing = {report::trail(2, 1, 2.5), report::line({0, 1, 2}), report::pivot(0), report::disk(1, 0),
                  report::disk(2, 1)},
      .positions = [](const DoublePendulum& s, const Vector<double, 2>& q, double) -> std::vector<Point> {
        const Point inner{s.l1 * std::sin(q[0]), -s.l1 * std::cos(q[0])};
        return {{0.0, 0.0}, inner, {inner.x + s.l2 * std::sin(q[1]), inner.y - s.l2 * std::cos(q[1])}};
      },
  };
}

}  // namespace qdot::scenes
