#pragma once
// SPDX-License-Identifier: MIT
//
// A planet in the field of a fixed sun, in units where its mass is 1:
//
//     T = ½ (ẋ² + ẏ²),      V = −μ / √(x² + y²).
//
// The orbit is a conic section; an ellipse with semi-major axis a closes after 2π √(a³/μ). The start has a = 1, e = 0.6.

#include <cmath>
#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct Kepler {
  double mu = 1.0;  // gravitational parameter

  constexpr auto T(const auto& qdot) const { return 0.5 * (qdot[0] * qdot[0] + qdot[1] * qdot[1]); }

  constexpr auto V(const auto& q) const {
    using std::sqrt;
    return -mu / sqrt(q[0] * q[0] + q[1] * q[1]);
  }
};

inline Scene<Kepler, 2> kepler() {
  return {
      .name = "kepler",
      .title = "Kepler's problem",
      .summary = "A planet in the field of a fixed sun, from the perihelion of an ellipse with semi-major axis 1 and eccentricity 0.6.",
      .parameters = {{"mu", &Kepler::mu, "", Range::positive, "gravitational parameter"}},
      .coordinates = {{"x", ""}, {"y", ""}},
      .start = [](const Kepler& s) { return State<2>{0.0, {0.4, 0.0}, {0.0, 2.0 * std::sqrt(s.mu)}}; },
      .t_end = 12.566370614359172,
      .time_unit = "",
      .energy_unit = "",
      .drawing = {report::trail(1), report::disk(0, 4, 12), report::disk(1, 0, 7)},
      .positions = [](const Kepler&, const Vector<double, 2>& q, double) -> std::vector<Point> {
        return {{0.0, 0.0}, {q[0], q[1]}};
      },
  };
}

}  // namespace qdot::scenes
