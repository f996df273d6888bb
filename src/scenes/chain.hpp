#pragma once
// SPDX-License-Identifier: MIT
//
// n equal bobs on n equal massless rods, one below the other; all angles from the downward vertical. The energies are summed
// bob by bob, so the same code serves every n:
//
//     T = Σ ½ m v_k²,  v_k = v_{k−1} + l θ̇_k (cos θ_k, sin θ_k),      V = Σ m g y_k,  y_k = y_{k−1} − l cos θ_k.
//
// Small swings have ω² l/g = the zeros of the Laguerre polynomial L_n.

#include <cmath>
#include <vector>

#include "scenes/scene.hpp"
#include "scenes/shown.hpp"

namespace qdot::scenes {

struct Chain {
  int n = 5;        // number of links
  double m = 1.0;   // mass of each bob
  double l = 1.0;   // length of each rod
  double g = 9.81;  // gravity

  template <class S>
  S T(const Vector<S, Dynamic>& q, const Vector<S, Dynamic>& qdot) const {
    using std::cos, std::sin;
    S vx(0.0), vy(0.0), sum(0.0);
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      vx += l * cos(q[k]) * qdot[k];
      vy += l * sin(q[k]) * qdot[k];
      sum += vx * vx + vy * vy;
    }
    return 0.5 * m * sum;
  }

  template <class S>
  S V(const Vector<S, Dynamic>& q) const {
    using std::cos;
    S y(0.0), sum(0.0);
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      y -= l * cos(q[k]);
      sum += y;
    }
    return m * g * sum;
  }
};

inline Scene<Chain, Dynamic> chain() {
  return {
      .name = "chain",
      .title = "Chain of pendulums",
      .summary = "n equal bobs on n equal massless rods, one below the other; all angles are measured from the downward vertical.",
      .parameters = {{"n", &Chain::n, "", Range::between(1, 500), "number of links"},
                     {"m", &Chain::m, "kg", Range::positive, "mass of each bob"},
                     {"l", &Chain::l, "m", Range::positive, "length of each rod"},
                     {"g", &Chain::g, "m/s^2", Range::non_negative, "gravity"}},
      .coordinates = [](const Chain& s) { return numbered(s.n, {{"theta", "rad"}}); },
      .start = [](const Chain& s) {
        return State<Dynamic>{0.0, Eigen::VectorXd::Constant(s.n, 1.2), Eigen::VectorXd::Zero(s.n)};
      },
      .t_end = 10.0,
      .drawing = [](const Chain& s) -> Drawing {
        Drawing drawing{.shapes = {report::trail(s.n, 1, 2.0)}};
        std::vector<int> all;
        for (int k = 0; k <= s.n; ++k) all.push_back(k);
        drawing.shapes.push_back(report::line(all));
        for (int k = 1; k <= s.n; ++k) drawing.shapes.push_back(report::disk(k, k == s.n ? 1 : 0, s.n > 20 ? 4 : 7));
        drawing.shapes.push_back(report::pivot(0));
        return drawing;
      },
      .positions = [](const Chain& s, const Eigen::VectorXd& q, double) {
        std::vector<Point> points{{0.0, 0.0}};
        for (const double theta : q) {
          points.push_back({points.back().x + s.l * std::sin(theta), points.back().y - s.l * std::cos(theta)});
        }
        return points;
      },
  };
}

}  // namespace qdot::scenes
