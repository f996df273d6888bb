#pragma once
// SPDX-License-Identifier: MIT
//
// A bob on a spring that swings in a plane, r from the pivot, θ from the downward vertical:
//
//     T = ½ m (ṙ² + r² θ̇²),      V = ½ k (r − l₀)² − m g r cos θ.
//
// At k = 3 m g / l₀ the spring beats twice as fast as the pendulum, and the energy wanders between the two.

#include <cmath>
#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct ElasticPendulum {
  double m = 1.0;    // mass of the bob
  double k = 29.43;  // stiffness of the spring
  double l0 = 1.0;   // its length at rest
  double g = 9.81;   // gravity

  constexpr auto T(const auto& q, const auto& qdot) const {
    return 0.5 * m * (qdot[0] * qdot[0] + q[0] * q[0] * qdot[1] * qdot[1]);
  }

  constexpr auto V(const auto& q) const {
    using std::cos;
    const auto stretch = q[0] - l0;
    return 0.5 * k * stretch * stretch - m * g * q[0] * cos(q[1]);
  }
};

inline Scene<ElasticPendulum, 2> elastic_pendulum() {
  return {
      .name = "elastic_pendulum",
      .title = "Elastic pendulum",
      .summary = "A bob on a spring, at the 2:1 resonance: the energy wanders from bouncing to swinging and back.",
      .parameters = {{"m", &ElasticPendulum::m, "kg", Range::positive, "mass of the bob"},
                     {"k", &ElasticPendulum::k, "N/m", Range::positive, "stiffness of the spring"},
                     {"l0", &ElasticPendulum::l0, "m", Range::non_negative, "length of the spring at rest"},
                     {"g", &ElasticPendulum::g, "m/s^2", Range::non_negative, "gravity"}},
      .coordinates = {{"r", "m"}, {"theta", "rad"}},
      .start = {1.7, 0.08},
      .t_end = 30.0,
      .drawing = {report::trail(1, 0, 3.0), report::spring(0, 1), report::pivot(0), report::disk(1)},
      .positions = [](const ElasticPendulum&, const Vector<double, 2>& q, double) -> std::vector<Point> {
        return {{0.0, 0.0}, {q[0] * std::sin(q[1]), -q[0] * std::cos(q[1])}};
      },
  };
}

}  // namespace qdot::scenes
