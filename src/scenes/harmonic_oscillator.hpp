#pragma once
// SPDX-License-Identifier: MIT
//
// A mass on a linear spring: x = x₀ cos ωt + (ẋ₀/ω) sin ωt with ω² = k/m, at every amplitude.

#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct HarmonicOscillator {
  double m = 1.0;  // mass
  double k = 4.0;  // stiffness

  constexpr auto T(const auto& qdot) const { return 0.5 * m * qdot[0] * qdot[0]; }
  constexpr auto V(const auto& q) const { return 0.5 * k * q[0] * q[0]; }
};

inline Scene<HarmonicOscillator, 1> harmonic_oscillator() {
  return {
      .name = "harmonic_oscillator",
      .title = "Harmonic oscillator",
      .summary = "A mass on a linear spring: a sine of the same period at every amplitude.",
      .parameters = {{"m", &HarmonicOscillator::m, "kg", Range::positive, "mass"},
                     {"k", &HarmonicOscillator::k, "N/m", Range::positive, "stiffness of the spring"}},
      .coordinates = {{"x", "m"}},
      .start = {1.0},
      .t_end = 10.0,
      .drawing = [](const HarmonicOscillator&) -> Drawing {
        return {.shapes = {report::spring(0, 1), report::box(1, 0.5, 0.5, 0)},
                .backdrop = {{{-2.5, 0.6}, {-2.5, -0.25}, {2.0, -0.25}}}};
      },
      .positions = [](const HarmonicOscillator&, const Vector<double, 1>& q, double) -> std::vector<Point> {
        return {{-2.5, 0.0}, {q[0], 0.0}};
      },
  };
}

}  // namespace qdot::scenes
