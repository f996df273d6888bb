#pragma once
// SPDX-License-Identifier: MIT
//
// A string: n masses that move across a line, with stretched springs between neighbours, both ends held,
//
//     T = Σ ½ m q̇ᵢ²,      V = Σ ½ k (√(a² + d²) − l)²,      d = qᵢ₊₁ − qᵢ .
//
// a is the distance of neighbours along the line, l < a the length of a spring without tension. Small waves have the tension F = k (a − l), and long
// ones run at c = a √(F / (m a)).

#include <vector>

#include "scenes/scene.hpp"
#include "scenes/shown.hpp"
#include "scenes/stretched_springs.hpp"

namespace qdot::scenes {

struct VibratingString : StretchedSprings {
  int n = 20;  // number of masses

  auto V(const auto& q) const {
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    S sum(0.0);
    for (Eigen::Index i = 0; i <= q.size(); ++i) {
      const S d = (i < q.size() ? q[i] : S(0.0)) - (i > 0 ? q[i - 1] : S(0.0));
      sum += energy(d);
    }
    return sum;
  }
};

inline Scene<VibratingString, Dynamic> string() {
  return {
      .name = "string",
      .title = "Plucked string",
      .summary = "n masses and stretched springs in a row, both ends held; lifted at a third of its length and let go.",
      .parameters = with_springs<VibratingString>({"n", &VibratingString::n, "", Range::positive, "number of masses"}),
      .coordinates = [](const VibratingString& s) { return numbered(s.n, {{"y", "m"}}); },
      .start = [](const VibratingString& s) {
        State<Dynamic> start{0.0, Eigen::VectorXd(s.n), Eigen::VectorXd::Zero(s.n)};
        for (int i = 0; i < s.n; ++i) {
          const double x = (i + 1.0) / (s.n + 1.0);
          start.q[i] = s.h * std::min(3.0 * x, 1.5 * (1.0 - x));
        }
        return start;
      },
      .t_end = 4.0,
      .drawing = [](const VibratingString& s) -> Drawing {
        const std::size_t count = shown(0, s.n + 1).size();
        return {.shapes = {report::line(in_a_row(count), 0), report::pivot(0), report::pivot(static_cast<int>(count) - 1)}};
      },
      .positions = [](const VibratingString& s, const Eigen::VectorXd& q, double) {
        std::vector<Point> points;
        for (const int i : shown(0, s.n + 1)) points.push_back({i * s.a, i > 0 && i <= s.n ? q[i - 1] : 0.0});
        return points;
      },
  };
}

}  // namespace qdot::scenes
