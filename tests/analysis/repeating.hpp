#pragma once
// SPDX-License-Identifier: MIT
//
// What repeats itself in the tests of periodic orbits: one type for all, for the compiler's sake.

#include "qdot/effects/contact.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/mechanics/system.hpp"

namespace repeating {

// One coordinate of unit mass: weight, a spring that may be shaken, a pendulum whose gravity may be.
struct Particle {
  double g = 0.0;                              // g q
  double a = 0.0, s = 0.0;                     // ½ (a − 2s cos 2t) q²
  double pull = 0.0, shake = 0.0, omega = 0.0;  // −(pull + shake cos ωt) cos q

  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q, const auto& t) const {
    using std::cos;
    return g * q[0] + 0.5 * (a - 2 * s * cos(2.0 * t)) * q[0] * q[0] - (pull + shake * cos(omega * t)) * cos(q[0]);
  }
};
// Forces along q̇: c q̇, van der Pol's μ (1 − q²) q̇, and b (2r² − r⁴) q̇ with r² = q² + q̇². With a = 1, circles where
// c + b (2r² − r⁴) = 0 are cycles of period 2π.
struct Feed {
  double c = 0.0, mu = 0.0, b = 0.0;
  auto operator()(const auto& q, const auto& v) const {
    auto Q = q;
    const auto r2 = q[0] * q[0] + v[0] * v[0];
    Q[0] = (c + mu * (1.0 - q[0] * q[0]) + b * (2.0 - r2) * r2) * v[0];
    return Q;
  }
};
struct Height {
  double floor = -100.0;
  auto operator()(const auto& q) const { return q[0] - floor; }
};

inline auto over_floor(Particle p, Feed feed = {}, double floor = -100.0) {
  return qdot::scene(qdot::mechanical_system<1>(p), qdot::generalized_force(feed), qdot::contact("floor", Height{floor}, qdot::restitution(1.0)));
}

}  // namespace repeating
