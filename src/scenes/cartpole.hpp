#pragma once
// SPDX-License-Identifier: MIT
//
// A cart that rolls on a straight track with a pendulum hung on it; θ from the downward vertical:
//
//     T = ½ (M+m) ẋ² + m l ẋ θ̇ cos θ + ½ m l² θ̇²,      V = −m g l cos θ.
//
// x does not occur in L: the horizontal momentum (M+m) ẋ + m l θ̇ cos θ is conserved.

#include <cmath>
#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct Cartpole {
  double M = 2.0;   // mass of the cart
  double m = 1.0;   // mass of the bob
  double l = 1.0;   // length of the pole
  double g = 9.81;  // gravity

  constexpr auto T(const auto& q, const auto& qdot) const {
    using std::cos;
    return 0.5 * (M + m) * qdot[0] * qdot[0] + m * l * qdot[0] * qdot[1] * cos(q[1]) +
           0.5 * m * l * l * qdot[1] * qdot[1];
  }

  constexpr auto V(const auto& q) const {
    using std::cos;
    return -m * g * l * cos(q[1]);
  }
};

inline Scene<Cartpole, 2> cartpole() {
  return {
      .name = "cartpole",
      .title = "Cart and pole",
      .summary = "A cart on a straight track with a pendulum hung on it; the horizontal momentum is conserved.",
      .parameters = {{"M", &Cartpole::M, "kg", Range::positive, "mass of the cart"},
                     {"m", &Cartpole::m, "kg", Range::positive, "mass of the bob"},
                     {"l", &Cartpole::l, "m", Range::positive, "length of the pole"},
                     {"g", &Cartpole::g, "m/s^2", Range::non_negative, "gravity"}},
      .coordinates = {{"x", "m"}, {"theta", "rad"}},
      .start = {0.0, 2.8},
      .t_end = 10.0,
      .drawing = [](const Cartpole& s) -> Drawing {
        return {.shapes = {report::box(0, 0.6 * s.l, 0.3 * s.l), report::trail(1, 0, 1.5), report::line({0, 1}),
                           report::pivot(0), report::disk(1)},
                .backdrop = {{{-1.5 * s.l, -0.15 * s.l}, {1.5 * s.l, -0.15 * s.l}}}};
      },
      .positions = [](const Cartpole& s, const Vector<double, 2>& q, double) -> std::vector<Point> {
        return {{q[0], 0.0}, {q[0] + s.l * std::sin(q[1]), -s.l * std::cos(q[1])}};
      },
  };
}

}  // namespace qdot::scenes
