#pragma once
// SPDX-License-Identifier: MIT
//
// The lattice of Fermi, Pasta, Ulam and Tsingou: n masses on a line between two walls, and between neighbours a spring that is not quite linear,
//
//     T = Σ ½ m q̇ᵢ²,      V = Σ ½ k d² + ⅓ α d³ + ¼ β d⁴,      d = qᵢ₊₁ − qᵢ,   q₀ = qₙ₊₁ = 0 .
//
// Let go from its lowest mode, it gives its energy to a few others, and after some hundred swings nearly all of it comes back.
// With α = β = 0 the modes have ω = 2 √(k/m) sin(π j / (2n + 2)) and never meet.
//
// Reference: E. Fermi, J. Pasta, S. Ulam, Studies of nonlinear problems, Los Alamos report LA-1940 (1955).

#include <cmath>
#include <numbers>
#include <vector>

#include "scenes/scene.hpp"
#include "scenes/shown.hpp"

namespace qdot::scenes {

struct Lattice {
  int n = 16;           // number of masses
  double m = 1.0;       // each mass
  double k = 1.0;       // stiffness of each spring
  double alpha = 0.25;  // of its quadratic force
  double beta = 0.0;    // of its cubic force
  double A = 1.0;       // amplitude of the lowest mode at the start

  auto T(const auto& qdot) const { return 0.5 * m * qdot.squaredNorm(); }
  auto V(const auto& q) const {
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    S sum(0.0);
    for (Eigen::Index i = 0; i <= q.size(); ++i) {
      const S d = (i < q.size() ? q[i] : S(0.0)) - (i > 0 ? q[i - 1] : S(0.0));
      sum += d * d * (0.5 * k + d * (alpha / 3.0 + 0.25 * beta * d));
    }
    return sum;
  }
};

inline Scene<Lattice, Dynamic> lattice() {
  return {
      .name = "lattice",
      .title = "Lattice of Fermi, Pasta, Ulam and Tsingou",
      .summary = "n masses on a line between two walls, with springs that are not quite linear; let go from the lowest mode.",
      .parameters = {{"n", &Lattice::n, "", Range::positive, "number of masses"},
                     {"m", &Lattice::m, "", Range::positive, "each mass"},
                     {"k", &Lattice::k, "", Range::positive, "stiffness of each spring"},
                     {"alpha", &Lattice::alpha, "", Range::any, "of the quadratic part of its force"},
                     {"beta", &Lattice::beta, "", Range::non_negative, "of the cubic part of its force"},
                     {"A", &Lattice::A, "", Range::any, "amplitude at the start"}},
      .coordinates = [](const Lattice& s) { return numbered(s.n, {{"x"}}); },
      .start = [](const Lattice& s) {
        State<Dynamic> start{0.0, Eigen::VectorXd(s.n), Eigen::VectorXd::Zero(s.n)};
        for (int i = 0; i < s.n; ++i) start.q[i] = s.A * std::sin(std::numbers::pi * (i + 1) / (s.n + 1));
        return start;
      },
      .t_end = 100.0,
      .time_unit = "",
      .energy_unit = "",
      .drawing = [](const Lattice& s) -> Drawing {
        const std::size_t count = shown(0, s.n + 1).size();
        Drawing drawing{.shapes = {report::line(in_a_row(count), 0), report::pivot(0), report::pivot(static_cast<int>(count) - 1)}};
        if (s.n <= 64)
          for (int i = 1; i <= s.n; ++i) drawing.shapes.push_back(report::disk(i, 0, 4));
        return drawing;
      },
      .positions = [](const Lattice& s, const Eigen::VectorXd& q, double) {  // the displacement is drawn across
        std::vector<Point> points;
        for (const int i : shown(0, s.n + 1)) points.push_back({6.0 * i / (s.n + 1.0), i > 0 && i <= s.n ? q[i - 1] : 0.0});
        return points;
      },
  };
}

}  // namespace qdot::scenes
