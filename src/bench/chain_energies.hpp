#pragma once
// SPDX-License-Identifier: MIT
//
// The chain of src/bench/hand_derived.hpp the natural way: as energies whose velocities are summed link by link, and as positions
// of the masses. Each has a plain loop and the library's loop that the compiler sees through.

#include <cmath>
#include <type_traits>

#include "qdot/ad/unroll.hpp"
#include "qdot/mechanics/velocity.hpp"

namespace qdot::bench {

/// T and V of the chain with `for`.
struct LoopedChain {
  double g = 9.81;

  constexpr auto T(const auto& q, const auto& qdot) const {
    using std::cos, std::sin;
    using S = typename std::decay_t<decltype(q)>::Scalar;
    S vx(0.0), vy(0.0), sum(0.0);
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      vx += cos(q[k]) * qdot[k];
      vy += sin(q[k]) * qdot[k];
      sum += 0.5 * (vx * vx + vy * vy);
    }
    return sum;
  }
  constexpr auto V(const auto& q) const {
    using std::cos;
    using S = typename std::decay_t<decltype(q)>::Scalar;
    S y(0.0), sum(0.0);
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      y -= cos(q[k]);
      sum += g * y;
    }
    return sum;
  }
};

/// The chain as a sum over pairs of links, as in books: n² terms.
struct PairedChain {
  double g = 9.81;

  auto T(const auto& q, const auto& qdot) const {
    using std::cos;
    using S = typename std::decay_t<decltype(q)>::Scalar;
    S sum(0.0);
    for (Eigen::Index i = 0; i < q.size(); ++i)
      for (Eigen::Index k = 0; k < q.size(); ++k) sum += 0.5 * links_beyond(q, i, k) * qdot[i] * qdot[k] * cos(q[i] - q[k]);
    return sum;
  }
  auto V(const auto& q) const {
    using std::cos;
    using S = typename std::decay_t<decltype(q)>::Scalar;
    S sum(0.0);
    for (Eigen::Index k = 0; k < q.size(); ++k) sum -= g * links_beyond(q, k, k) * cos(q[k]);
    return sum;
  }

 private:
  static double links_beyond(const auto& q, Eigen::Index i, Eigen::Index k) { return static_cast<double>(q.size() - (i > k ? i : k)); }
};

/// T and V of the chain with qdot::unroll.
template <int n>
struct UnrolledChain {
  double g = 9.81;

  auto T(const auto& q, const auto& qdot) const {
    using std::cos, std::sin;
    using S = typename std::decay_t<decltype(q)>::Scalar;
    S vx(0.0), vy(0.0), sum(0.0);
    unroll<n>([&](auto k) {
      vx += cos(q[k]) * qdot[k];
      vy += sin(q[k]) * qdot[k];
      sum += 0.5 * (vx * vx + vy * vy);
    });
    return sum;
  }
  auto V(const auto& q) const {
    using std::cos;
    using S = typename std::decay_t<decltype(q)>::Scalar;
    S y(0.0), sum(0.0);
    unroll<n>([&](auto k) {
      y -= cos(q[k]);
      sum += g * y;
    });
    return sum;
  }
};

/// Positions of the masses with qdot::unroll.
template <int n>
struct UnrolledPositions {
  template <class Q>
  void operator()(const Q& q, auto& bodies) const {
    using std::cos, std::sin;
    typename Q::Scalar x(0.0), y(0.0);
    unroll<n>([&](auto k) {
      x = x + sin(q[k]);
      y = y - cos(q[k]);
      bodies.point_mass(1.0, vector(x, y));
    });
  }
};

/// Positions of the masses with `for`.
struct LoopedPositions {
  template <class Q>
  constexpr void operator()(const Q& q, auto& bodies) const {
    using std::cos, std::sin;
    typename Q::Scalar x(0.0), y(0.0);
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      x += sin(q[k]);
      y -= cos(q[k]);
      bodies.point_mass(1.0, vector(x, y));
    }
  }
};

/// x of the last mass.
template <int n>
struct TipOfChain {
  template <class Q>
  constexpr auto operator()(const Q& q) const {
    using std::sin;
    typename Q::Scalar x(0.0);
    unroll<n>([&](auto k) { x = x + sin(q[k]); });
    return x;
  }
};

}  // namespace qdot::bench
