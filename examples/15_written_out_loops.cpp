// SPDX-License-Identifier: MIT
//
// A chain of four links with loops in T and V, as fast as equations derived by hand: written_out() has the compiler run the loops.
// T and V are constexpr for that; nothing else changes, and masses and lengths are what they are at run time.

#include <cmath>
#include <cstdio>
#include <type_traits>

#include <qdot/mechanics/energy.hpp>
#include <qdot/mechanics/equations_of_motion.hpp>
#include <qdot/mechanics/written_out.hpp>

struct Chain {
  double m = 1.0, l = 1.0, g = 9.81;

  constexpr auto T(const auto& q, const auto& qdot) const {
    using std::cos, std::sin;
    typename std::decay_t<decltype(q)>::Scalar vx(0.0), vy(0.0), sum(0.0);
    for (int k = 0; k < q.size(); ++k) {
      vx += l * cos(q[k]) * qdot[k];
      vy += l * sin(q[k]) * qdot[k];
      sum += 0.5 * m * (vx * vx + vy * vy);
    }
    return sum;
  }
  constexpr auto V(const auto& q) const {
    using std::cos;
    typename std::decay_t<decltype(q)>::Scalar y(0.0), sum(0.0);
    for (int k = 0; k < q.size(); ++k) {
      y -= l * cos(q[k]);
      sum += m * g * y;
    }
    return sum;
  }
};

int main() {
  const Chain chain{.m = 0.2, .l = 0.5};
  const auto plain = qdot::mechanical_system<4>(chain);
  const auto written = qdot::mechanical_system<4>(qdot::written_out<4>(chain));
  const Eigen::Vector4d q(0.9, 0.5, -0.3, 1.4), qdot(0.2, -1.0, 0.7, 0.4);
  std::printf("%s\n", written.energies().replays() ? "evaluated without a loop" : "evaluated with loops: m and l lead to other operations");
  const Eigen::Vector4d a = acceleration(plain, q, qdot), b = acceleration(written, q, qdot);
  for (int k = 0; k < 4; ++k) std::printf("link %d   loop %12.8f   written out %12.8f rad/s^2\n", k + 1, a[k], b[k]);
  std::printf("energy   loop %12.8f   written out %12.8f J\n", energy(plain, q, qdot), energy(written, q, qdot));
}
