// SPDX-License-Identifier: MIT
//
// The motion of a double pendulum from T and V. Nothing else is derived by hand.

#include <cmath>
#include <cstdio>

#include <qdot/integrate/cvode.hpp>
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
  const auto run = simulate(system, start, 3.0, qdot::CvodeAdams{}, {.rtol = 1e-12, .atol = 1e-12});
  if (!run.completed()) return std::fprintf(stderr, "%s\n", run.message.c_str()), 1;
  for (const auto& state : run.trajectory.sampled(7)) {
    std::printf("t = %.1f   theta = (%8.5f, %8.5f)   energy = %.6f\n", state.t, state.q[0], state.q[1], energy(system, state));
  }
}
