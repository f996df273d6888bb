#pragma once
// SPDX-License-Identifier: MIT
//
// A chain whose pivot is shaken, with loops in both energies and parameters of its own.

#include <Eigen/Core>
#include <cmath>
#include <type_traits>

// A chain with other masses than those that the compiler met, and a pivot that is moved by force.
struct ShakenChain {
  double m = 1.0, l = 1.0, g = 9.81, w = 2.0;
  constexpr auto T(const auto& q, const auto& qdot, const auto& t) const {
    using std::cos, std::sin;
    using S = typename std::decay_t<decltype(q)>::Scalar;
    S vx = w * cos(w * t), vy(0.0), sum(0.0);
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      vx += l * cos(q[k]) * qdot[k];
      vy += l * sin(q[k]) * qdot[k];
      sum += 0.5 * m * (vx * vx + vy * vy);
    }
    return sum;
  }
  constexpr auto V(const auto& q, const auto& t) const {
    using std::cos;
    using S = typename std::decay_t<decltype(q)>::Scalar;
    S y(0.0), sum(0.0);
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      y -= l * cos(q[k]);
      sum += m * g * y * (1.0 + 0.1 * t);
    }
    return sum;
  }
};
