#pragma once
// SPDX-License-Identifier: MIT
//
// A round body that rolls down an incline: s along the incline, θ its turn, moment of inertia κ m R² (hoop 1, disk ½, ball 2/5):
//
//     T = ½ m ṡ² + ½ κ m R² θ̇²,   V = −m g s sin α,      φ = s − R θ = 0.
//
// It goes with s̈ = g sin α/(1+κ); the multiplier is the friction, −κ m g sin α/(1+κ).

#include <cmath>
#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct RollingHoop {
  double m = 1.0;      // mass
  double R = 0.2;      // radius
  double kappa = 1.0;  // moment of inertia over m R²
  double alpha = 0.3;  // angle of the incline
  double g = 9.81;     // gravity

  constexpr auto T(const auto& qdot) const { return 0.5 * m * (qdot[0] * qdot[0] + kappa * R * R * qdot[1] * qdot[1]); }
  constexpr auto V(const auto& q) const { return -m * g * std::sin(alpha) * q[0]; }
};

inline Scene<RollingHoop, 2> rolling_hoop() {
  return {
      .name = "rolling_hoop",
      .title = "Hoop on an incline",
      .summary = "A hoop that rolls down an incline; the multiplier of rolling is the friction.",
      .parameters = {{"m", &RollingHoop::m, "kg", Range::positive, "mass"},
                     {"R", &RollingHoop::R, "m", Range::positive, "radius"},
                     {"kappa", &RollingHoop::kappa, "", Range::positive, "moment of inertia over m R^2"},
                     {"alpha", &RollingHoop::alpha, "rad", Range::any, "angle of the incline"},
                     {"g", &RollingHoop::g, "m/s^2", Range::non_negative, "gravity"}},
      .coordinates = {{"s", "m"}, {"theta", "rad"}},
      .start = {0.0, 0.0},
      .t_end = 2.0,
      .drawing = [](const RollingHoop& p) -> Drawing {
        const double reach = 4.0;
        return {.shapes = {report::ellipse(0, 1, 2), report::line({0, 1}, 0)},
                .backdrop = {{{-0.2 * std::cos(p.alpha), 0.2 * std::sin(p.alpha)}, {reach * std::cos(p.alpha), -reach * std::sin(p.alpha)}}}};
      },
      .positions = [](const RollingHoop& p, const Vector<double, 2>& q, double) -> std::vector<Point> {
        const Point G{q[0] * std::cos(p.alpha) + p.R * std::sin(p.alpha), -q[0] * std::sin(p.alpha) + p.R * std::cos(p.alpha)};
        const double c = p.R * std::cos(q[1] + p.alpha), s = p.R * std::sin(q[1] + p.alpha);
        return {G, {G.x + c, G.y - s}, {G.x + s, G.y + c}};
      },
  };
}

}  // namespace qdot::scenes
