#pragma once
// SPDX-License-Identifier: MIT
//
// A bead on a hoop that is turned about its vertical diameter at a given rate Ω; θ from the lowest point:
//
//     T = ½ m R² (θ̇² + Ω² sin² θ),      V = −m g R cos θ.
//
// T has a term of degree 0 in θ̇, so T + V is not conserved (the motor does work), but Jacobi's h = θ̇ ∂L/∂θ̇ − L is.
// Above Ω² = g/R the lowest point is unstable and the bead rests at cos θ = g/(Ω² R).

#include <cmath>
#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct BeadOnHoop {
  double m = 1.0;      // mass of the bead
  double R = 1.0;      // radius of the hoop
  double g = 9.81;     // gravity
  double Omega = 5.0;  // angular velocity of the hoop

  constexpr auto T(const auto& q, const auto& qdot) const {
    using std::sin;
    const auto s = sin(q[0]);
    return 0.5 * m * R * R * (qdot[0] * qdot[0] + Omega * Omega * s * s);
  }

  constexpr auto V(const auto& q) const {
    using std::cos;
    return -m * g * R * cos(q[0]);
  }
};

inline Scene<BeadOnHoop, 1> bead_on_hoop() {
  return {
      .name = "bead_on_hoop",
      .title = "Bead on a rotating hoop",
      .summary = "A bead on a hoop that a motor turns about the vertical: T + V varies, Jacobi's energy stays.",
      .parameters = {{"m", &BeadOnHoop::m, "kg", Range::positive, "mass of the bead"},
                     {"R", &BeadOnHoop::R, "m", Range::positive, "radius of the hoop"},
                     {"g", &BeadOnHoop::g, "m/s^2", Range::non_negative, "gravity"},
                     {"Omega", &BeadOnHoop::Omega, "rad/s", Range::any, "angular velocity of the hoop"}},
      .coordinates = {{"theta", "rad"}},
      .start = {0.3},
      .t_end = 10.0,
      .drawing = report::in_space({report::line({3, 4}, 6), report::ellipse(0, 2, 3), report::trail(1, 0, 1.5), report::disk(1)}),
      .positions = [](const BeadOnHoop& s, const Vector<double, 1>& q, double t) -> std::vector<Point> {
        const double c = s.R * std::cos(s.Omega * t), sn = s.R * std::sin(s.Omega * t);
        return {{0.0, 0.0, 0.0}, {c * std::sin(q[0]), sn * std::sin(q[0]), -s.R * std::cos(q[0])}, {c, sn, 0.0}, {0.0, 0.0, s.R}, {0.0, 0.0, -s.R}};
      },
  };
}

}  // namespace qdot::scenes
