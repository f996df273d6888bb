#pragma once
// SPDX-License-Identifier: MIT
//
// A hanging chain of m point masses in Cartesian coordinates, 2m of them, on m rods u_k from mass k − 1 to mass k:
//
//     m r̈_k = λ_k u_k − λ_{k+1} u_{k+1} + m g ,    u_k·(r̈_k − r̈_{k−1}) = −|u̇_k|² .
//
// The multipliers solve a tridiagonal system. The scene is what a user writes, with m known at run time.

#include <cstddef>
#include <type_traits>
#include <vector>

#include "qdot/effects/constraints.hpp"
#include "qdot/effects/scene.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot::bench {

struct HangingMasses {
  double m = 1.0, g = 9.81;
  auto T(const auto& v) const {
    typename std::remove_cvref_t<decltype(v)>::Scalar sum(0.0);
    for (Eigen::Index i = 0; i < v.size(); ++i) sum += 0.5 * m * (v[i] * v[i]);
    return sum;
  }
  auto V(const auto& q) const {
    typename std::remove_cvref_t<decltype(q)>::Scalar sum(0.0);
    for (Eigen::Index i = 1; i < q.size(); i += 2) sum += m * g * q[i];
    return sum;
  }
};

/// ½ (|u_k|² − 1) for each rod.
struct RodsOfChain {
  auto operator()(const auto& q) const {
    using S = typename std::remove_cvref_t<decltype(q)>::Scalar;
    Vector<S, Dynamic> rows(q.size() / 2);
    for (Eigen::Index k = 0; k < rows.size(); ++k) {
      const S x = k == 0 ? q[0] : q[2 * k] - q[2 * k - 2], y = k == 0 ? q[1] : q[2 * k + 1] - q[2 * k - 1];
      rows[k] = 0.5 * (x * x + y * y - 1.0);
    }
    return rows;
  }
};

inline auto hanging_chain(int masses) { return scene(mechanical_system(2 * masses, HangingMasses{}), holonomic("rods", RodsOfChain{})); }

/// q̈, then λ, by elimination from the top and substitution from the tip.
struct HangingChainByHand {
  std::size_t masses;
  double m = 1.0, g = 9.81, per_m = 1.0 / m;
  mutable std::vector<double> x = std::vector<double>(masses), y = x, inverse = x, below = x;

  void operator()(const double* q, const double* v, double* a) const {
    double* const lambda = a + 2 * masses;
    double qx = 0.0, qy = 0.0, vx = 0.0, vy = 0.0;
    for (std::size_t k = 0; k < masses; ++k) {
      x[k] = q[2 * k] - qx;
      y[k] = q[2 * k + 1] - qy;
      const double dx = v[2 * k] - vx, dy = v[2 * k + 1] - vy, square = (x[k] * x[k] + y[k] * y[k]) * per_m;
      qx = q[2 * k], qy = q[2 * k + 1], vx = v[2 * k], vy = v[2 * k + 1];
      if (k == 0) {
        inverse[0] = 1.0 / square;
        lambda[0] = g * y[0] - dx * dx - dy * dy;
        continue;
      }
      below[k] = -(x[k] * x[k - 1] + y[k] * y[k - 1]) * per_m;
      const double factor = below[k] * inverse[k - 1];
      inverse[k] = 1.0 / (2.0 * square - factor * below[k]);
      lambda[k] = -dx * dx - dy * dy - factor * lambda[k - 1];
    }
    double px = 0.0, py = 0.0, last = 0.0, next = 0.0;  // λ u of the rod below
    for (std::size_t k = masses; k-- > 0;) {
      lambda[k] = (lambda[k] - next * last) * inverse[k];
      last = lambda[k];
      next = below[k];
      const double ux = lambda[k] * x[k], uy = lambda[k] * y[k];
      a[2 * k] = (ux - px) * per_m;
      a[2 * k + 1] = (uy - py) * per_m - g;
      px = ux, py = uy;
    }
  }
};

}  // namespace qdot::bench
