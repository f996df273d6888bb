#pragma once
// SPDX-License-Identifier: MIT
//
// The double pendulum as a family of its masses, lengths and gravity, of any scalar: one type for all tests that differentiate by them.

#include <cmath>
#include <type_traits>

namespace systems {

template <class S>
struct DoublePendulumOf {
  S m1, m2, l1, l2, g;

  auto T(const auto& q, const auto& v) const {
    using std::cos;
    return 0.5 * (m1 + m2) * l1 * l1 * v[0] * v[0] + 0.5 * m2 * l2 * l2 * v[1] * v[1] + m2 * l1 * l2 * v[0] * v[1] * cos(q[0] - q[1]);
  }
  auto V(const auto& q) const {
    using std::cos;
    return -(m1 + m2) * g * l1 * cos(q[0]) - m2 * g * l2 * cos(q[1]);
  }
};

struct DoublePendulumFamily {
  auto operator()(const auto& p) const {
    using S = std::remove_cvref_t<decltype(p[0])>;
    return DoublePendulumOf<S>{p[0], p[1], p[2], p[3], p[4]};
  }
};

}  // namespace systems
