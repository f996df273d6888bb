#pragma once
// SPDX-License-Identifier: MIT
//
// What moves in the tests of sections and return maps: one type for all, for the compiler's sake.

#include <cmath>

#include "qdot/integrate/event.hpp"
#include "qdot/mechanics/system.hpp"

namespace stars {

// V = ½ (x² + w² y²) + λ (x² y − y³/3): two oscillators of frequencies 1 and w, or Hénon's and Heiles' star.
struct Star {
  double w = 1.0, lambda = 0.0;

  auto T(const auto& v) const { return 0.5 * (v[0] * v[0] + v[1] * v[1]); }
  auto V(const auto& q) const {
    return 0.5 * (q[0] * q[0] + w * w * q[1] * q[1]) + lambda * (q[0] * q[0] * q[1] - q[1] * q[1] * q[1] / 3.0);
  }
};

// x = at, and the phase of the time.
struct Plane {
  double at = 0.0, omega = 0.0;

  double operator()(const auto& q, const auto&, double t) const { return omega > 0.0 ? std::sin(omega * t) : q[0] - at; }
};

inline const auto oscillators = qdot::mechanical_system<2>(Star{.w = std::sqrt(2.0)});
inline const auto henon_heiles = qdot::mechanical_system<2>(Star{.lambda = 1.0});
inline auto plane(double at = 0.0) { return qdot::event("plane", Plane{.at = at}).rising(); }

// On x = 0 with the energy E, ẋ ≥ 0.
inline qdot::State<2> on_plane(double E, double y, double ydot) {
  return {0.0, {0.0, y}, {std::sqrt(2.0 * E - ydot * ydot - y * y + 2.0 / 3.0 * y * y * y), ydot}};
}

}  // namespace stars
