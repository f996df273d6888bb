#pragma once
// SPDX-License-Identifier: MIT
//
// A mass on a spring that hardens (β > 0) or softens: V = ½ α x² + ¼ β x⁴. For m = α = 1 the period is 4 K(k²)/√(1+βA²)
// with k² = β A² / (2 (1 + β A²)).

#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct Duffing {
  double m = 1.0;      // mass
  double alpha = 1.0;  // linear stiffness
  double beta = 1.0;   // cubic stiffness

  constexpr auto T(const auto& qdot) const { return 0.5 * m * qdot[0] * qdot[0]; }

  constexpr auto V(const auto& q) const {
    const auto x2 = q[0] * q[0];
    return 0.5 * alpha * x2 + 0.25 * beta * x2 * x2;
  }
};

inline Scene<Duffing, 1> duffing() {
  return {
      .name = "duffing",
      .title = "Duffing's oscillator",
      .summary = "A mass on a spring that hardens as it stretches: the period falls with the amplitude.",
      .parameters = {{"m", &Duffing::m, "kg", Range::positive, "mass"},
                     {"alpha", &Duffing::alpha, "N/m", Range::any, "linear stiffness"},
                     {"beta", &Duffing::beta, "N/m^3", Range::any, "cubic stiffness"}},
      .coordinates = {{"x", "m"}},
      .start = {1.0},
      .t_end = 20.0,
      .drawing = [](const Duffing&) -> Drawing {
        return {.shapes = {report::spring(0, 1), report::box(1, 0.5, 0.5, 0)},
                .backdrop = {{{-2.5, 0.6}, {-2.5, -0.25}, {2.0, -0.25}}}};
      },
      .positions = [](const Duffing&, const Vector<double, 1>& q, double) -> std::vector<Point> {
        return {{-2.5, 0.0}, {q[0], 0.0}};
      },
  };
}

}  // namespace qdot::scenes
