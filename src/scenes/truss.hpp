#pragma once
// SPDX-License-Identifier: MIT
//
// A bridge of n bays, all of its bars elastic, hinged at its joints, where its mass is.
//
// Joints 0, 1, … 2n stand in zigzag, those with even numbers below and the odd ones above; the first and the last are held. Bars go from each to the next
// and to the one after that,
//
//     T = Σ ½ m (u̇² + v̇²),      V = Σ ½ (EA / l₀) (l − l₀)² + Σ m g v ,
//
// with l₀ the length of a bar in the drawing, and u, v how far a joint has moved from there. The bars are stiff: along one of them sound runs at
// √(EA l₀ / m) metres a second, while the bridge swings slowly, and the more so the longer it is.

#include <cmath>
#include <vector>

#include "scenes/scene.hpp"
#include "scenes/shown.hpp"

namespace qdot::scenes {

struct Truss {
  int n = 5;         // bays
  double m = 20.0;   // mass at each joint
  double EA = 4e5;   // stiffness of a bar
  double a = 1.0;    // length of a bay
  double h = 0.8;    // height
  double g = 9.81;   // gravity

  auto T(const auto& qdot) const { return 0.5 * m * qdot.squaredNorm(); }
  auto V(const auto& q) const {
    using std::sqrt;
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    const Eigen::Index last = q.size() / 2 + 1;
    const auto moved = [&](Eigen::Index j, Eigen::Index axis) { return j == 0 || j == last ? S(0.0) : S(q[2 * (j - 1) + axis]); };
    S sum(0.0);
    const auto add_bar = [&](Eigen::Index from, Eigen::Index to, double x0, double y0) {
      const S x = x0 + (moved(to, 0) - moved(from, 0)), y = y0 + (moved(to, 1) - moved(from, 1));
      const double l0 = std::sqrt(x0 * x0 + y0 * y0);
      const S longer = sqrt(x * x + y * y) - l0;
      sum += 0.5 * EA / l0 * longer * longer;
    };
    for (Eigen::Index j = 0; j < last; ++j) add_bar(j, j + 1, 0.5 * a, j % 2 == 0 ? h : -h);
    for (Eigen::Index j = 0; j + 1 < last; ++j) add_bar(j, j + 2, a, 0.0);
    for (Eigen::Index j = 1; j < last; ++j) sum += m * g * moved(j, 1);
    return sum;
  }
};

inline Scene<Truss, Dynamic> truss() {
  return {
      .name = "truss",
      .title = "Bridge of elastic bars",
      .summary = "A bridge of n bays whose bars are stiff springs, held at both ends; it is let go as drawn, and sags and swings under its weight.",
      .parameters = {{"n", &Truss::n, "", Range::between(1, 250000), "bays"},
                     {"m", &Truss::m, "kg", Range::positive, "mass at each joint"},
                     {"EA", &Truss::EA, "N", Range::positive, "stiffness of a bar"},
                     {"a", &Truss::a, "m", Range::positive, "length of a bay"},
                     {"h", &Truss::h, "m", Range::positive, "height"},
                     {"g", &Truss::g, "m/s^2", Range::any, "gravity"}},
      .coordinates = [](const Truss& s) { return numbered(2 * s.n - 1, {{"u", "m"}, {"v", "m"}}); },
      .start = [](const Truss& s) {
        return State<Dynamic>{0.0, Eigen::VectorXd::Zero(4 * s.n - 2), Eigen::VectorXd::Zero(4 * s.n - 2)};
      },
      .t_end = 3.0,
      .drawing = [](const Truss& s) -> Drawing {
        const std::vector<int> joints = shown(0, 2 * s.n);
        const int count = static_cast<int>(joints.size());
        Drawing drawing{.shapes = {report::line(in_a_row(joints.size()), 0)}};
        if (count == 2 * s.n + 1)
          for (int first = 0; first < 2; ++first) {
            std::vector<int> chord;
            for (int j = first; j < count; j += 2) chord.push_back(j);
            drawing.shapes.push_back(report::line(chord, 0));
          }
        drawing.shapes.push_back(report::pivot(0));
        drawing.shapes.push_back(report::pivot(count - 1));
        return drawing;
      },
      .positions = [](const Truss& s, const Eigen::VectorXd& q, double) {
        std::vector<Point> points;
        for (const int j : shown(0, 2 * s.n)) {
          const bool held = j == 0 || j == 2 * s.n;
          points.push_back({0.5 * s.a * j + (held ? 0.0 : q[2 * (j - 1)]), (j % 2 == 0 ? 0.0 : s.h) + (held ? 0.0 : q[2 * (j - 1) + 1])});
        }
        return points;
      },
  };
}

}  // namespace qdot::scenes
