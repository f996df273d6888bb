#pragma once
// SPDX-License-Identifier: MIT
//
// A diatomic molecule: V = D (1 − e^{−a x})². Below the dissociation energy D the period is 2π / (a √(2D/m) √(1 − E/D)).

#include <cmath>
#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct Morse {
  double m = 1.0;  // reduced mass
  double D = 1.0;  // dissociation energy
  double a = 1.0;  // inverse width of the well

  constexpr auto T(const auto& qdot) const { return 0.5 * m * qdot[0] * qdot[0]; }

  constexpr auto V(const auto& q) const {
    using std::exp;
    const auto s = 1.0 - exp(-a * q[0]);
    return D * s * s;
  }
};

inline Scene<Morse, 1> morse() {
  return {
      .name = "morse",
      .title = "Morse oscillator",
      .summary = "The vibration of a diatomic molecule: stiff when pressed, soft when pulled, free above the dissociation energy.",
      .parameters = {{"m", &Morse::m, "", Range::positive, "reduced mass"},
                     {"D", &Morse::D, "", Range::positive, "dissociation energy"},
                     {"a", &Morse::a, "", Range::positive, "inverse width of the well"}},
      .coordinates = {{"x", ""}},
      .start = {0.0, 1.2},
      .t_end = 30.0,
      .time_unit = "",
      .energy_unit = "",
      .drawing = {report::spring(0, 1), report::disk(0, 6, 12), report::disk(1, 0, 12)},
      .positions = [](const Morse&, const Vector<double, 1>& q, double) -> std::vector<Point> {
        return {{-2.0, 0.0}, {q[0], 0.0}};
      },
  };
}

}  // namespace qdot::scenes
