#pragma once
// SPDX-License-Identifier: MIT
//
// A thin disk that rolls upright on a plane without slip.

#include <cmath>

namespace qdot::hard {

// (x, y): contact point, φ: heading, δ: lean to the right, ψ: rolling angle.
struct RollingDisk {
  double m = 1.0, r = 0.5, g = 9.81;

  auto T(const auto& q, const auto& v) const {
    using std::cos, std::sin;
    const double I = m * r * r / 4, J = m * r * r / 2;
    const auto sp = sin(q[2]), cp = cos(q[2]), sd = sin(q[3]), cd = cos(q[3]);
    const auto vx = v[0] + r * (cd * sp * v[3] + sd * cp * v[2]), vy = v[1] - r * (cd * cp * v[3] - sd * sp * v[2]);
    const auto vz = -r * sd * v[3], spin = v[4] + sd * v[2];
    return 0.5 * m * (vx * vx + vy * vy + vz * vz) + 0.5 * I * (v[3] * v[3] + cd * cd * v[2] * v[2]) + 0.5 * J * spin * spin;
  }
  auto V(const auto& q) const {
    using std::cos;
    return m * g * r * cos(q[3]);
  }
};

}  // namespace qdot::hard
