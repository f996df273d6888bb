#pragma once
// SPDX-License-Identifier: MIT
//
// The pendulum in Cartesian coordinates, the pivot at the origin and y upwards: a free bob, and a rod that holds it,
//
//     T = ½ m (ẋ² + ẏ²),   V = m g y,      φ = ½ (x² + y² − l²) = 0 .
//
// J = (x, y), so the rod's force on the bob is λ (x, y), and its tension −λ l = m (g cos θ + v²/l).

#include <cmath>
#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct CartesianPendulum {
  double m = 1.0;   // mass of the bob
  double l = 1.0;   // length of the rod
  double g = 9.81;  // gravity

  constexpr auto T(const auto& qdot) const { return 0.5 * m * (qdot[0] * qdot[0] + qdot[1] * qdot[1]); }
  constexpr auto V(const auto& q) const { return m * g * q[1]; }
};

inline Scene<CartesianPendulum, 2> cartesian_pendulum() {
  return {
      .name = "cartesian_pendulum",
      .title = "Pendulum in Cartesian coordinates",
      .summary = "A bob in a plane, held to a circle by a constraint; the multiplier shows the tension of the rod.",
      .parameters = {{"m", &CartesianPendulum::m, "kg", Range::positive, "mass of the bob"},
                     {"l", &CartesianPendulum::l, "m", Range::positive, "length of the rod"},
                     {"g", &CartesianPendulum::g, "m/s^2", Range::non_negative, "gravity"}},
      .coordinates = {{"x", "m"}, {"y", "m"}},
      .start = [](const CartesianPendulum& s) { return State<2>{0.0, {s.l * std::sin(1.0), -s.l * std::cos(1.0)}, {0.0, 0.0}}; },
      .t_end = 10.0,
      .drawing = {report::trail(1, 0, 1.0), report::line({0, 1}), report::pivot(0), report::disk(1)},
      .positions = [](const CartesianPendulum&, const Vector<double, 2>& q, double) -> std::vector<Point> {
        return {{0.0, 0.0}, {q[0], q[1]}};
      },
  };
}

}  // namespace qdot::scenes
