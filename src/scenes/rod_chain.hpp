#pragma once
// SPDX-License-Identifier: MIT
//
// A hanging chain in Cartesian coordinates: n free masses in a vertical plane, and n rods that hold each to the one before,
//
//     T = Σ ½ m (ẋ² + ẏ²),   V = Σ m g y,      φₖ = ½ (|rₖ − rₖ₋₁|² − l²) = 0 .
//
// It is the scene `chain` once more. There each angle meets all others; here coordinates and multipliers meet their neighbours, and a chain
// of a thousand rods costs a thousand times one rod. λₖ is minus the force in rod k over its length.

#include <vector>

#include "scenes/scene.hpp"
#include "scenes/shown.hpp"

namespace qdot::scenes {

struct RodChain {
  int n = 8;        // number of rods
  double m = 1.0;   // each mass
  double l = 0.25;  // length of each rod
  double g = 9.81;  // gravity

  auto T(const auto& qdot) const { return 0.5 * m * qdot.squaredNorm(); }
  auto V(const auto& q) const {
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    S sum(0.0);
    for (Eigen::Index k = 0; 2 * k < q.size(); ++k) sum += m * g * q[2 * k + 1];
    return sum;
  }
};

/// What holds the rods to their length; of each: ½ (distance² − l²).
struct RodLengths {
  double l;

  auto operator()(const auto& q) const {
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    Vector<S, Dynamic> phi(q.size() / 2);
    for (Eigen::Index k = 0; k < phi.size(); ++k) {
      const S x = k == 0 ? S(q[0]) : S(q[2 * k] - q[2 * k - 2]), y = k == 0 ? S(q[1]) : S(q[2 * k + 1] - q[2 * k - 1]);
      phi[k] = 0.5 * (x * x + y * y - l * l);
    }
    return phi;
  }
};

inline Scene<RodChain, Dynamic> rod_chain() {
  return {
      .name = "rod_chain",
      .title = "Hanging chain of rods",
      .summary = "n masses in Cartesian coordinates on n rods, which are constraints; held level and let go.",
      .parameters = {{"n", &RodChain::n, "", Range::positive, "number of rods"},
                     {"m", &RodChain::m, "kg", Range::positive, "each mass"},
                     {"l", &RodChain::l, "m", Range::positive, "length of each rod"},
                     {"g", &RodChain::g, "m/s^2", Range::non_negative, "gravity"}},
      .coordinates = [](const RodChain& s) { return numbered(s.n, {{"x", "m"}, {"y", "m"}}); },
      .start = [](const RodChain& s) {
        State<Dynamic> start{0.0, Eigen::VectorXd::Zero(2 * s.n), Eigen::VectorXd::Zero(2 * s.n)};
        for (int k = 0; k < s.n; ++k) start.q[2 * k] = s.l * (k + 1);
        return start;
      },
      .t_end = 1.0,
      .drawing = [](const RodChain& s) -> Drawing {
        const std::size_t count = shown(0, s.n).size();
        return {.shapes = {report::trail(static_cast<int>(count) - 1, 1, 0.5), report::line(in_a_row(count)), report::pivot(0),
                           report::disk(static_cast<int>(count) - 1, 1, 4)}};
      },
      .positions = [](const RodChain& s, const Eigen::VectorXd& q, double) {
        std::vector<Point> points;
        for (const int k : shown(0, s.n)) points.push_back(k == 0 ? Point{} : Point{q[2 * k - 2], q[2 * k - 1]});
        return points;
      },
  };
}

}  // namespace qdot::scenes
