#pragma once
// SPDX-License-Identifier: MIT
//
// A sleigh on a horizontal plane. Its blade at (x, y) does not let it slip sideways; its centre of mass is the distance a ahead:
//
//     T = ½ m |v_G|² + ½ I θ̇²,   V = 0,      −ẋ sin θ + ẏ cos θ = 0 .
//
// The constraint is not integrable. Energy is kept, and yet a turning sleigh ends up going straight: with κ = m a V/(I + m a²) and
// V = ω₀ √((I + m a²)/m), from v = 0 the speed is V tanh κt and the turn ω₀ sech κt.

#include <cmath>
#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct ChaplyginSleigh {
  double m = 1.0;  // mass
  double I = 0.3;  // moment of inertia about the centre of mass
  double a = 0.5;  // from the blade to the centre of mass

  constexpr auto T(const auto& q, const auto& qdot) const {
    using std::cos, std::sin;
    const auto vx = qdot[0] - a * sin(q[2]) * qdot[2];
    const auto vy = qdot[1] + a * cos(q[2]) * qdot[2];
    return 0.5 * m * (vx * vx + vy * vy) + 0.5 * I * qdot[2] * qdot[2];
  }
  constexpr auto V(const auto& q) const { return 0.0 * q[0]; }
};

inline Scene<ChaplyginSleigh, 3> chaplygin_sleigh() {
  return {
      .name = "chaplygin_sleigh",
      .title = "Chaplygin's sleigh",
      .summary = "A sleigh whose blade does not slip sideways: it keeps its energy, and its turning still dies away.",
      .parameters = {{"m", &ChaplyginSleigh::m, "kg", Range::positive, "mass"},
                     {"I", &ChaplyginSleigh::I, "kg m^2", Range::positive, "moment of inertia about the centre of mass"},
                     {"a", &ChaplyginSleigh::a, "m", Range::any, "from the blade to the centre of mass"}},
      .coordinates = {{"x", "m"}, {"y", "m"}, {"theta", "rad"}},
      .start = {0.0, 0.0, 0.0, 0.0, 0.0, 1.3},
      .t_end = 6.0,
      .drawing = {report::trail(0), report::line({1, 2}), report::disk(3, 1, 7)},
      .positions = [](const ChaplyginSleigh& s, const Vector<double, 3>& q, double) -> std::vector<Point> {
        const double c = s.a * std::cos(q[2]), d = s.a * std::sin(q[2]);
        return {{q[0], q[1]}, {q[0] - 0.4 * c, q[1] - 0.4 * d}, {q[0] + 1.4 * c, q[1] + 1.4 * d}, {q[0] + c, q[1] + d}};
      },
  };
}

}  // namespace qdot::scenes
