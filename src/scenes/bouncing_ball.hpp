#pragma once
// SPDX-License-Identifier: MIT
//
// A ball that falls on a floor and keeps the part e of its velocity at each impact:
//
//     T = ½ m ẏ²,   V = m g y,      y ≥ 0 .
//
// Dropped from y₀ it hits at t₁ = √(2 y₀/g) and then after flights of 2 eⁿ t₁ each; infinitely many impacts are over at
// t₁ (1 + e)/(1 − e). After those that the tolerances can resolve the ball lies on the floor.

#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct BouncingBall {
  double m = 1.0;   // mass
  double g = 9.81;  // gravity
  double e = 0.8;   // restitution

  constexpr auto T(const auto& qdot) const { return 0.5 * m * qdot[0] * qdot[0]; }
  constexpr auto V(const auto& q) const { return m * g * q[0]; }
};

inline Scene<BouncingBall, 1> bouncing_ball() {
  return {
      .name = "bouncing_ball",
      .title = "Bouncing ball",
      .summary = "A ball falls on a floor again and again: infinitely many impacts in finite time, and then it lies there.",
      .parameters = {{"m", &BouncingBall::m, "kg", Range::positive, "mass"},
                     {"g", &BouncingBall::g, "m/s^2", Range::positive, "gravity"},
                     {"e", &BouncingBall::e, "", Range::non_negative, "restitution, the part of the velocity that an impact leaves"}},
      .coordinates = {{"y", "m"}},
      .start = {1.0},
      .t_end = 5.0,
      .drawing = [](const BouncingBall&) -> Drawing {
        return {.shapes = {report::disk(0)}, .backdrop = {{{-0.5, 0.0}, {0.5, 0.0}}}};
      },
      .positions = [](const BouncingBall&, const Vector<double, 1>& q, double) -> std::vector<Point> { return {{0.0, q[0]}}; },
  };
}

}  // namespace qdot::scenes
