#pragma once
// SPDX-License-Identifier: MIT
//
// The circular restricted three-body problem in the frame that turns along, for tests. One type for all mass ratios.

#include <cmath>

namespace qdot::systems {

struct ThreeBodies {
  double mu = 0.012150585;

  auto T(const auto& q, const auto& v) const {
    const auto u = v[0] - q[1], w = v[1] + q[0];
    return 0.5 * (u * u + w * w);
  }
  auto V(const auto& q) const {
    using std::sqrt;
    const auto x1 = q[0] + mu, x2 = q[0] - (1.0 - mu);
    return -(1.0 - mu) / sqrt(x1 * x1 + q[1] * q[1]) - mu / sqrt(x2 * x2 + q[1] * q[1]);
  }
};

}  // namespace qdot::systems
