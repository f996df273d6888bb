#pragma once
// SPDX-License-Identifier: MIT
//
// A spring whose stiffness is modulated, ẍ + (a − 2 q cos 2t) x = 0 in Mathieu's normal form. V depends on the time, so no
// energy is conserved; inside the tongues of the (a, q) plane the rest position is unstable (a = 1, q = 0.2 is one of them).

#include <cmath>
#include <vector>

#include "scenes/scene.hpp"

namespace qdot::scenes {

struct Mathieu {
  double a = 1.0;  // mean stiffness
  double q = 0.2;  // depth of the modulation

  constexpr auto T(const auto& qdot) const { return 0.5 * qdot[0] * qdot[0]; }

  constexpr auto V(const auto& x, const auto& t) const {
    using std::cos;
    return 0.5 * (a - 2.0 * q * cos(2.0 * t)) * x[0] * x[0];
  }
};

inline Scene<Mathieu, 1> mathieu() {
  return {
      .name = "mathieu",
      .title = "Mathieu's oscillator",
      .summary = "A spring whose stiffness is modulated at twice its frequency: the smallest motion grows without bound.",
      .parameters = {{"a", &Mathieu::a, "", Range::any, "mean stiffness"},
                     {"q", &Mathieu::q, "", Range::any, "depth of the modulation"}},
      .coordinates = {{"x", ""}},
      .start = {0.1},
      .t_end = 30.0,
      .time_unit = "",
      .energy_unit = "",
      .drawing = {report::spring(0, 1), report::disk(1)},
      .positions = [](const Mathieu&, const Vector<double, 1>& q, double) -> std::vector<Point> {
        return {{-3.0, 0.0}, {q[0], 0.0}};
      },
  };
}

}  // namespace qdot::scenes
