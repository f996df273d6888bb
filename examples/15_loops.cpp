// SPDX-License-Identifier: MIT
//
// A chain of four links with loops in T and V. The first acceleration() derives the equations from what T and V do, and later ones use them: they have the
// masses and lengths that the object has at run time. Beside it the same chain with qdot::unroll, a loop that the compiler sees through.

#include <cmath>
#include <cstdio>
#include <type_traits>

#include <qdot/ad/unroll.hpp>
#include <qdot/mechanics/energy.hpp>
#include <qdot/mechanics/equations_of_motion.hpp>

struct Chain {
  double m = 1.0, l = 1.0, g = 9.81;

  auto T(const auto& q, const auto& qdot) const {
    using std::cos, std::sin;
    typename std::decay_t<decltype(q)>::Scalar vx(0.0), vy(0.0), sum(0.0);
    for (int k = 0; k < q.size(); ++k) {
      vx += l * cos(q[k]) * qdot[k];
      vy += l * sin(q[k]) * qdot[k];
      sum += 0.5 * m * (vx * vx + vy * vy);
    }
    return sum;
  }
  auto V(const auto& q) const {
    using std::cos;
    typename std::decay_t<decltype(q)>::Scalar y(0.0), sum(0.0);
    for (int k = 0; k < q.size(); ++k) {
      y -= l * cos(q[k]);
      sum += m * g * y;
    }
    return sum;
  }
};

struct UnrolledChain : Chain {
  auto T(const auto& q, const auto& qdot) const {
    using std::cos, std::sin;
    typename std::decay_t<decltype(q)>::Scalar vx(0.0), vy(0.0), sum(0.0);
    qdot::unroll<4>([&](auto k) {
      vx += l * cos(q[k]) * qdot[k];
      vy += l * sin(q[k]) * qdot[k];
      sum += 0.5 * m * (vx * vx + vy * vy);
    });
    return sum;
  }
  auto V(const auto& q) const {
    using std::cos;
    typename std::decay_t<decltype(q)>::Scalar y(0.0), sum(0.0);
    qdot::unroll<4>([&](auto k) {
      y -= l * cos(q[k]);
      sum += m * g * y;
    });
    return sum;
  }
};

int main() {
  const Chain chain{.m = 0.2, .l = 0.5};
  const auto looped = qdot::mechanical_system<4>(chain);
  const auto unrolled = qdot::mechanical_system<4>(UnrolledChain{chain});
  const Eigen::Vector4d q(0.9, 0.5, -0.3, 1.4), qdot(0.2, -1.0, 0.7, 0.4);
  const Eigen::Vector4d a = acceleration(looped, q, qdot), b = acceleration(unrolled, q, qdot);
  for (int k = 0; k < 4; ++k) std::printf("link %d   loop %12.8f   unrolled %12.8f rad/s^2\n", k + 1, a[k], b[k]);
  std::printf("energy   loop %12.8f   unrolled %12.8f J\n", energy(looped, q, qdot), energy(unrolled, q, qdot));
}
