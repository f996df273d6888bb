#pragma once
// SPDX-License-Identifier: MIT
//
// A square net of n × n masses that move out of its plane, with stretched springs between neighbours along both sides, its edge held:
//
//     T = Σ ½ m q̇²,      V = Σ ½ k (√(a² + d²) − l)²,      d between neighbours .
//
// A string in two directions. The mass in row i and column j is coordinate n i + j.

#include <cmath>
#include <string>
#include <vector>

#include "scenes/scene.hpp"
#include "scenes/shown.hpp"
#include "scenes/stretched_springs.hpp"

namespace qdot::scenes {

struct Net : StretchedSprings {
  int n = 7;  // masses along a side

  auto V(const auto& q) const {
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    const Eigen::Index side = n;
    const auto height = [&](Eigen::Index i, Eigen::Index j) { return i < 0 || j < 0 || i == side || j == side ? S(0.0) : S(q[side * i + j]); };
    S sum(0.0);
    for (Eigen::Index i = 0; i <= side; ++i)
      for (Eigen::Index j = 0; j <= side; ++j) {
        if (i < side) sum += energy(S(height(i, j) - height(i, j - 1)));
        if (j < side) sum += energy(S(height(i, j) - height(i - 1, j)));
      }
    return sum;
  }
};

inline Scene<Net, Dynamic> net() {
  return {
      .name = "net",
      .title = "Square net",
      .summary = "n by n masses and stretched springs, the edge held; a bulge off the middle is let go and waves run out from it.",
      .parameters = with_springs<Net>({"n", &Net::n, "", Range::between(1, 1000), "masses along a side"}),
      .coordinates = [](const Net& s) {
        std::vector<Coordinate> coordinates;
        for (int i = 1; i <= s.n; ++i)
          for (int j = 1; j <= s.n; ++j) coordinates.push_back({"z_" + std::to_string(i) + "_" + std::to_string(j), "m"});
        return coordinates;
      },
      .start = [](const Net& s) {
        State<Dynamic> start{0.0, Eigen::VectorXd(s.n * s.n), Eigen::VectorXd::Zero(s.n * s.n)};
        const double middle = 0.4 * (s.n + 1), width = 0.15 * (s.n + 1);
        for (int i = 0; i < s.n; ++i)
          for (int j = 0; j < s.n; ++j) {
            const double x = (i + 1 - middle) / width, y = (j + 1 - middle) / width;
            start.q[s.n * i + j] = s.h * std::exp(-x * x - y * y);
          }
        return start;
      },
      .t_end = 2.0,
      .drawing = [](const Net& s) -> Drawing {
        const int count = static_cast<int>(shown(0, s.n + 1, 22).size());
        Drawing drawing = report::in_space({}, {.side = 25, .above = 30});
        for (int i = 0; i < count; ++i) {
          std::vector<int> row, column;
          for (int j = 0; j < count; ++j) {
            row.push_back(count * i + j);
            column.push_back(count * j + i);
          }
          drawing.shapes.push_back(report::line(row, 0));
          drawing.shapes.push_back(report::line(column, 0));
        }
        return drawing;
      },
      .positions = [](const Net& s, const Eigen::VectorXd& q, double) {
        std::vector<Point> points;
        const auto held = [&](int i) { return i == 0 || i == s.n + 1; };
        const std::vector<int> lines = shown(0, s.n + 1, 22);
        for (const int i : lines)
          for (const int j : lines) points.push_back({j * s.a, i * s.a, held(i) || held(j) ? 0.0 : q[s.n * (i - 1) + j - 1]});
        return points;
      },
  };
}

}  // namespace qdot::scenes
