#pragma once
// SPDX-License-Identifier: MIT
//
// Two masses on a string over a pulley of radius R and moment of inertia I; x is how far m₁ has sunk:
//
//     T = ½ (m₁ + m₂ + I/R²) ẋ²,      V = −(m₁ − m₂) g x,      ẍ = (m₁ − m₂) g / (m₁ + m₂ + I/R²).

#include <cmath>
#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct Atwood {
  double m1 = 2.0;   // the mass that sinks
  double m2 = 1.0;   // the mass that rises
  double I = 0.005;  // moment of inertia of the pulley
  double R = 0.1;    // its radius
  double g = 9.81;   // gravity

  constexpr auto T(const auto& qdot) const { return 0.5 * (m1 + m2 + I / (R * R)) * qdot[0] * qdot[0]; }
  constexpr auto V(const auto& q) const { return -(m1 - m2) * g * q[0]; }
};

inline Scene<Atwood, 1> atwood() {
  return {
      .name = "atwood",
      .title = "Atwood's machine",
      .summary = "Two masses on a string over a pulley; the acceleration is constant.",
      .parameters = {{"m1", &Atwood::m1, "kg", Range::positive, "the mass that sinks"},
                     {"m2", &Atwood::m2, "kg", Range::positive, "the mass that rises"},
                     {"I", &Atwood::I, "kg m^2", Range::non_negative, "moment of inertia of the pulley"},
                     {"R", &Atwood::R, "m", Range::positive, "radius of the pulley"},
                     {"g", &Atwood::g, "m/s^2", Range::non_negative, "gravity"}},
      .coordinates = {{"x", "m"}},
      .start = {0.0},
      .t_end = 1.0,
      .drawing = {report::line({0, 2}), report::line({1, 3}), report::ellipse(4, 0, 5), report::line({4, 6}, 6),
                  report::pivot(4), report::disk(2, 0, 14), report::disk(3, 1, 11)},
      .positions = [](const Atwood& s, const Vector<double, 1>& q, double) -> std::vector<Point> {
        const double angle = -q[0] / s.R;
        return {{-s.R, 0.0}, {s.R, 0.0}, {-s.R, -1.0 - q[0]}, {s.R, -2.0 + q[0]}, {0.0, 0.0}, {0.0, s.R},
                {-s.R * std::cos(angle), s.R * std::sin(angle)}};
      },
  };
}

}  // namespace qdot::scenes
