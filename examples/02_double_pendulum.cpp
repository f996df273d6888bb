// SPDX-License-Identifier: MIT
//
// A double pendulum: two unit bobs, T and V as one would write them on the blackboard, and exact derivatives behind the scenes.

#include <cmath>
#include <cstdio>
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/integrate/simulate.hpp>

struct DoublePendulum {
  double m = 1.0, l = 1.0, g = 9.81;
  auto T(const auto& q, const auto& qdot) const {
    using std::cos;
    return 0.5 * m * l * l * (2.0 * qdot[0] * qdot[0] + qdot[1] * qdot[1] + 2.0 * qdot[0] * qdot[1] * cos(q[0] - q[1]));
  }
  auto V(const auto& q) const {
    using std::cos;
    return -m * g * l * (2.0 * cos(q[0]) + cos(q[1]));
  }
};

int main() {
  const auto system = qdot::mechanical_system<2>(DoublePendulum{});
  const qdot::State<2> start{.t = 0.0, .q = {1.7, 1.7}, .qdot = {0.0, 0.0}};
  const auto run = simulate(system, start, 3.0, qdot::Dop853{}, {.rtol = 1e-12, .atol = 1e-12});
  if (!run.completed()) return std::fprintf(stderr, "%s\n", run.message.c_str()), 1;
  for (const auto& s : run.trajectory.sampled(7))
    std::printf("t = %.1f   theta = (%8.5f, %8.5f)   energy = %.6f\n", s.t, s.q[0], s.q[1], energy(system, s));
}
