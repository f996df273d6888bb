#pragma once
// SPDX-License-Identifier: MIT
//
// Four bars in a plane, one of them the ground: a crank a that turns about the origin, a coupler b, and a rocker c that turns
// about (d, 0). Their absolute angles θ₁, θ₂, θ₃ (from the x-axis) are three coordinates of one degree of freedom; the loop
//
//     a e^{iθ₁} + b e^{iθ₂} = d + c e^{iθ₃}
//
// is two constraints. The bars are uniform rods of mass μ per length, in gravity along −y:
//
//     T = Σ ½ m v_G² + ½ (m L²/12) θ̇²,      V = Σ m g y_G .
//
// With a + d < b + c and a the shortest, the crank can turn all the way (Grashof).

#include <cmath>
#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct FourBar {
  double a = 0.3;   // crank
  double b = 0.9;   // coupler
  double c = 0.7;   // rocker
  double d = 1.0;   // ground
  double mu = 1.0;  // mass per length
  double g = 9.81;  // gravity

  constexpr auto T(const auto& q, const auto& qdot) const {
    using std::cos;
    const auto crank = mu * a * a * a / 3.0 * qdot[0] * qdot[0];
    const auto rocker = mu * c * c * c / 3.0 * qdot[2] * qdot[2];
    const auto coupler = mu * b * (a * a * qdot[0] * qdot[0] + a * b * qdot[0] * qdot[1] * cos(q[0] - q[1]) + b * b / 3.0 * qdot[1] * qdot[1]);
    return 0.5 * (crank + coupler + rocker);
  }

  constexpr auto V(const auto& q) const {
    using std::sin;
    return mu * g * (0.5 * a * a * sin(q[0]) + b * (a * sin(q[0]) + 0.5 * b * sin(q[1])) + 0.5 * c * c * sin(q[2]));
  }
};

/// θ₂ and θ₃ for a crank angle, by Freudenstein's closure; the branch with the coupler's joint above the ground.
inline Vector<double, 3> four_bar_angles(const FourBar& s, double crank) {
  const double x = s.d - s.a * std::cos(crank), y = -s.a * std::sin(crank);  // from the crank's end to the rocker's pivot
  const double distance = std::hypot(x, y);
  const double turn = std::acos((s.b * s.b + distance * distance - s.c * s.c) / (2 * s.b * distance));
  const double coupler = std::atan2(y, x) + turn;
  return {crank, coupler, std::atan2(s.a * std::sin(crank) + s.b * std::sin(coupler), s.a * std::cos(crank) + s.b * std::cos(coupler) - s.d)};
}

inline Scene<FourBar, 3> four_bar() {
  return {
      .name = "four_bar",
      .title = "Four-bar linkage",
      .summary = "A crank, a coupler and a rocker in a closed loop: three angles and two constraints; the crank turns all the way.",
      .parameters = {{"a", &FourBar::a, "m", Range::positive, "length of the crank"},
                     {"b", &FourBar::b, "m", Range::positive, "length of the coupler"},
                     {"c", &FourBar::c, "m", Range::positive, "length of the rocker"},
                     {"d", &FourBar::d, "m", Range::positive, "distance of the pivots"},
                     {"mu", &FourBar::mu, "kg/m", Range::positive, "mass per length"},
                     {"g", &FourBar::g, "m/s^2", Range::any, "gravity"}},
      .coordinates = {{"theta1", "rad"}, {"theta2", "rad"}, {"theta3", "rad"}},
      .start = [](const FourBar& s) { return State<3>{0.0, four_bar_angles(s, 0.5), {20.0, 0.0, 0.0}}; },
      .t_end = 5.0,
      .drawing = {report::trail(4, 0, 0.5), report::line({0, 1}, 0), report::line({1, 2}), report::line({2, 3}, 1),
                  report::pivot(0), report::pivot(3), report::disk(1, 0, 5), report::disk(2, 1, 5)},
      .positions = [](const FourBar& s, const Vector<double, 3>& q, double) -> std::vector<Point> {
        const Point A{s.a * std::cos(q[0]), s.a * std::sin(q[0])};
        const Point B{A.x + s.b * std::cos(q[1]), A.y + s.b * std::sin(q[1])};
        return {{0.0, 0.0}, A, B, {s.d, 0.0}, {0.5 * (A.x + B.x), 0.5 * (A.y + B.y)}};
      },
  };
}

}  // namespace qdot::scenes
