#pragma once
// SPDX-License-Identifier: MIT
//
// A star in a galaxy's plane, reduced to its essence: V = ½ (x² + y²) + λ (x² y − y³/3). For λ = 1 orbits are bound below
// E = 1/6; from about E = 1/12 upwards regular ones and chaotic ones lie side by side.

#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct HenonHeiles {
  double lambda = 1.0;  // strength of the cubic terms

  constexpr auto T(const auto& qdot) const { return 0.5 * (qdot[0] * qdot[0] + qdot[1] * qdot[1]); }

  constexpr auto V(const auto& q) const {
    const auto x2 = q[0] * q[0];
    const auto y2 = q[1] * q[1];
    return 0.5 * (x2 + y2) + lambda * (x2 * q[1] - y2 * q[1] / 3.0);
  }
};

inline Scene<HenonHeiles, 2> henon_heiles() {
  return {
      .name = "henon_heiles",
      .title = "Hénon and Heiles",
      .summary = "A star in a galaxy's plane; regular and chaotic orbits of the same energy lie side by side.",
      .parameters = {{"lambda", &HenonHeiles::lambda, "", Range::any, "strength of the cubic terms"}},
      .coordinates = {{"x", ""}, {"y", ""}},
      .start = {0.0, 0.1, 0.49, 0.0},
      .t_end = 100.0,
      .time_unit = "",
      .energy_unit = "",
      .drawing = {report::trail(0, 0, 40.0), report::disk(0, 0, 6)},
      .positions = [](const HenonHeiles&, const Vector<double, 2>& q, double) -> std::vector<Point> {
        return {{q[0], q[1]}};
      },
  };
}

}  // namespace qdot::scenes
