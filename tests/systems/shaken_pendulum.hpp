#pragma once
// SPDX-License-Identifier: MIT

#include <cmath>

#include "qdot/mechanics/velocity.hpp"

namespace qdot::systems {

// A pendulum whose pivot shakes as y = A cos γt: T depends on the time, and its velocity comes from its position.
struct ShakenPendulum {
  double m = 0.7, l = 1.3, g = 9.81, A = 0.2, gamma = 5.0;

  auto T(const auto& q, const auto& qdot, const auto& t) const {
    const auto position = [this](const auto& x, const auto& time) {
      using std::cos, std::sin;
      return vector(l * sin(x[0]), A * cos(gamma * time) - l * cos(x[0]));
    };
    return 0.5 * m * velocity_of(position, q, qdot, t).squaredNorm();
  }
  auto V(const auto& q, const auto& t) const {
    using std::cos;
    return m * g * (A * cos(gamma * t) - l * cos(q[0]));
  }
};

}  // namespace qdot::systems
