#pragma once
// SPDX-License-Identifier: MIT
//
// A bead on a cycloid, x = R (θ + sin θ), y = R (1 − cos θ), the curve on which every swing takes the same time:
//
//     T = m R² (1 + cos θ) θ̇²,      V = m g R (1 − cos θ),      period 4π √(R/g) at every amplitude.

#include <cmath>
#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct Cycloid {
  double m = 1.0;   // mass
  double R = 0.5;   // radius of the rolling circle
  double g = 9.81;  // gravity

  constexpr auto T(const auto& q, const auto& qdot) const {
    using std::cos;
    return m * R * R * (1.0 + cos(q[0])) * qdot[0] * qdot[0];
  }

  constexpr auto V(const auto& q) const {
    using std::cos;
    return m * g * R * (1.0 - cos(q[0]));
  }
};

inline Scene<Cycloid, 1> cycloid() {
  return {
      .name = "cycloid",
      .title = "Bead on a cycloid",
      .summary = "A bead on the curve whose swings take the same time at every amplitude.",
      .parameters = {{"m", &Cycloid::m, "kg", Range::positive, "mass"},
                     {"R", &Cycloid::R, "m", Range::positive, "radius of the rolling circle"},
                     {"g", &Cycloid::g, "m/s^2", Range::non_negative, "gravity"}},
      .coordinates = {{"theta", "rad"}},
      .start = {2.2},
      .t_end = 8.0,
      .drawing = [](const Cycloid& s) -> Drawing {
        Drawing drawing{.shapes = {report::disk(0)}, .backdrop = {{}}};
        for (int k = -60; k <= 60; ++k) {
          const double theta = 3.141592653589793 * k / 60;
          drawing.backdrop[0].push_back({s.R * (theta + std::sin(theta)), s.R * (1 - std::cos(theta))});
        }
        return drawing;
      },
      .positions = [](const Cycloid& s, const Vector<double, 1>& q, double) -> std::vector<Point> {
        return {{s.R * (q[0] + std::sin(q[0])), s.R * (1 - std::cos(q[0]))}};
      },
  };
}

}  // namespace qdot::scenes
