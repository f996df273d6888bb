#pragma once
// SPDX-License-Identifier: MIT
//
// A crank r at angle θ, a connecting rod l at angle −β, and a slider at x: three coordinates, two constraints, one degree of freedom,
//
//     r cos θ + l cos β − x = 0,      r sin θ − l sin β = 0.
//
// Crank and rod are uniform, masses m₁ and m₂, the slider has mass m₃; the plane is horizontal. Closed form:
// x = r cos θ + √(l² − r² sin² θ).

#include <cmath>
#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct SliderCrank {
  double r = 0.3;   // crank
  double l = 0.8;   // connecting rod
  double m1 = 1.0;  // mass of the crank
  double m2 = 1.0;  // mass of the rod
  double m3 = 2.0;  // mass of the slider

  // The rod's middle is half-way between the crank's pin and the slider's pin.
  constexpr auto T(const auto& q, const auto& qdot) const {
    using std::cos, std::sin;
    const auto vx = -r * sin(q[0]) * qdot[0] - 0.5 * l * sin(q[1]) * qdot[1];
    const auto vy = r * cos(q[0]) * qdot[0] - 0.5 * l * cos(q[1]) * qdot[1];
    return 0.5 * (m1 * r * r / 3.0 * qdot[0] * qdot[0] + m2 * (vx * vx + vy * vy) + m2 * l * l / 12.0 * qdot[1] * qdot[1] +
                  m3 * qdot[2] * qdot[2]);
  }
  constexpr auto V(const auto& q) const { return 0.0 * q[0]; }
};

inline Scene<SliderCrank, 3> slider_crank() {
  return {
      .name = "slider_crank",
      .title = "Slider and crank",
      .summary = "A crank drives a slider through a connecting rod: three coordinates and two constraints.",
      .parameters = {{"r", &SliderCrank::r, "m", Range::positive, "length of the crank"},
                     {"l", &SliderCrank::l, "m", Range::positive, "length of the connecting rod"},
                     {"m1", &SliderCrank::m1, "kg", Range::non_negative, "mass of the crank"},
                     {"m2", &SliderCrank::m2, "kg", Range::non_negative, "mass of the connecting rod"},
                     {"m3", &SliderCrank::m3, "kg", Range::positive, "mass of the slider"}},
      .coordinates = {{"theta", "rad"}, {"beta", "rad"}, {"x", "m"}},
      .start = [](const SliderCrank& s) { return State<3>{0.0, {0.0, 0.0, s.r + s.l}, {10.0, 10.0 * s.r / s.l, 0.0}}; },
      .t_end = 5.0,
      .drawing = [](const SliderCrank& s) -> Drawing {
        return {.shapes = {report::line({0, 1}, 0), report::line({1, 2}), report::box(2, 0.5 * s.r, 0.35 * s.r, 1), report::pivot(0),
                           report::disk(1, 0, 5)},
                .backdrop = {{{s.l - 1.4 * s.r, -0.18 * s.r}, {s.l + 1.4 * s.r, -0.18 * s.r}}}};
      },
      .positions = [](const SliderCrank& s, const Vector<double, 3>& q, double) -> std::vector<Point> {
        return {{0.0, 0.0}, {s.r * std::cos(q[0]), s.r * std::sin(q[0])}, {q[2], 0.0}};
      },
  };
}

}  // namespace qdot::scenes
