#pragma once
// SPDX-License-Identifier: MIT
//
// A block on a spring with Coulomb friction F:
//
//     T = ½ m ẋ²,   V = ½ k x²,      Q = −F sgn ẋ while it slides, |Q| ≤ F while it sticks.
//
// Each half swing is a half period of a sine about ±F/k. So the turning points are at |x| lower by 2F/k each time, at multiples
// of π √(m/k); at the first one with |x| ≤ F/k it sticks.

#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct FrictionBlock {
  double m = 1.0;  // mass
  double k = 4.0;  // stiffness
  double F = 0.3;  // friction

  constexpr auto T(const auto& qdot) const { return 0.5 * m * qdot[0] * qdot[0]; }
  constexpr auto V(const auto& q) const { return 0.5 * k * q[0] * q[0]; }
};

inline Scene<FrictionBlock, 1> friction_block() {
  return {
      .name = "friction_block",
      .title = "Block with dry friction",
      .summary = "A block on a spring slides with Coulomb friction, loses 4F/k of its amplitude in each cycle, and sticks.",
      .parameters = {{"m", &FrictionBlock::m, "kg", Range::positive, "mass"},
                     {"k", &FrictionBlock::k, "N/m", Range::positive, "stiffness of the spring"},
                     {"F", &FrictionBlock::F, "N", Range::non_negative, "friction"}},
      .coordinates = {{"x", "m"}},
      .start = {1.0},
      .t_end = 12.0,
      .drawing = [](const FrictionBlock&) -> Drawing {
        return {.shapes = {report::spring(0, 1), report::box(1, 0.5, 0.5, 0)},
                .backdrop = {{{-2.5, 0.6}, {-2.5, -0.25}, {2.0, -0.25}}}};
      },
      .positions = [](const FrictionBlock&, const Vector<double, 1>& q, double) -> std::vector<Point> {
        return {{-2.5, 0.0}, {q[0], 0.0}};
      },
  };
}

}  // namespace qdot::scenes
