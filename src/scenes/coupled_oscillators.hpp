#pragma once
// SPDX-License-Identifier: MIT
//
// Two equal masses between walls, joined by a third spring:
//
//     T = ½ m (ẋ² + ẏ²),      V = ½ k (x² + y²) + ½ κ (x − y)².
//
// The modes x = y and x = −y have ω² = k/m and (k + 2κ)/m. A weak joint makes the motion beat from one mass to the other.

#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct CoupledOscillators {
  double m = 1.0;      // each mass
  double k = 4.0;      // springs at the walls
  double kappa = 0.4;  // spring between the masses

  constexpr auto T(const auto& qdot) const { return 0.5 * m * (qdot[0] * qdot[0] + qdot[1] * qdot[1]); }

  constexpr auto V(const auto& q) const {
    const auto d = q[0] - q[1];
    return 0.5 * k * (q[0] * q[0] + q[1] * q[1]) + 0.5 * kappa * d * d;
  }
};

inline Scene<CoupledOscillators, 2> coupled_oscillators() {
  return {
      .name = "coupled_oscillators",
      .title = "Coupled oscillators",
      .summary = "Two equal masses between walls, joined by a weak spring: the motion beats from one to the other.",
      .parameters = {{"m", &CoupledOscillators::m, "kg", Range::positive, "each mass"},
                     {"k", &CoupledOscillators::k, "N/m", Range::positive, "springs at the walls"},
                     {"kappa", &CoupledOscillators::kappa, "N/m", Range::non_negative, "spring between the masses"}},
      .coordinates = {{"x", "m"}, {"y", "m"}},
      .start = {1.0, 0.0},
      .t_end = 35.0,
      .drawing = [](const CoupledOscillators&) -> Drawing {
        return {.shapes = {report::spring(0, 1), report::spring(1, 2), report::spring(2, 3), report::box(1, 0.5, 0.5, 0),
                           report::box(2, 0.5, 0.5, 1)},
                .backdrop = {{{-4.0, 0.6}, {-4.0, -0.25}, {4.0, -0.25}, {4.0, 0.6}}}};
      },
      .positions = [](const CoupledOscillators&, const Vector<double, 2>& q, double) -> std::vector<Point> {
        return {{-4.0, 0.0}, {q[0] - 1.4, 0.0}, {q[1] + 1.4, 0.0}, {4.0, 0.0}};
      },
  };
}

}  // namespace qdot::scenes
