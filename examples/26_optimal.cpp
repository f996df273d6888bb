// SPDX-License-Identifier: MIT
//
// The best way from one state to another: a pole swung up by a cart with a bounded force, and the fastest wire for a bead. And a task that no
// motion meets.

#include <cmath>
#include <cstdio>
#include <numbers>

#include <qdot/analysis/trajectory_optimization.hpp>
#include <qdot/qdot.hpp>

using namespace qdot;

// A cart of 1 kg, a bob of 0.3 kg on a rod of 0.5 m, θ from the downward vertical.
struct CartPole {
  double m1 = 1.0, m2 = 0.3, l = 0.5, g = 9.81;
  auto T(const auto& q, const auto& v) const {
    using std::cos;
    return 0.5 * (m1 + m2) * v[0] * v[0] + m2 * l * v[0] * v[1] * cos(q[1]) + 0.5 * m2 * l * l * v[1] * v[1];
  }
  auto V(const auto& q) const {
    using std::cos;
    return -m2 * g * l * cos(q[1]);
  }
};

struct Bead {
  double g = 9.80665;
  auto T(const auto& v) const { return 0.5 * v.squaredNorm(); }
  auto V(const auto& q) const { return g * q[1]; }
};

int main() {
  const double pi = std::numbers::pi;
  const auto cart = scene(mechanical_system<2>(CartPole{}).with_names({"x", "theta"}), input("motor", 0));
  OptimalTask<2> task{.start = {0.0, {0.0, 0.0}, {0.0, 0.0}}, .end = {2.0, {1.0, pi}, {0.0, 0.0}},
                      .bounds = {{"motor", -20.0, 20.0}, {"x", -2.0, 2.0}}};
  const auto effort = least_integral([](const auto&, const auto&, const auto& u) { return u[0] * u[0]; });
  const auto swing = trajectory_optimization(cart, task, effort, OptimalOptions{.tolerance = 1e-9});
  std::printf("swing-up: %s, %.5f N^2 s, off by less than 1e-6 at the end: %s\n", name(swing.outcome), swing.cost,
              swing.miss.cwiseAbs().maxCoeff() < 1e-6 ? "yes" : "no");
  for (double t = 0.0; t < 2.1; t += 0.5) {
    const auto state = swing.at(t);
    std::printf("  t = %.1f   x = %6.3f   theta = %6.3f   force %7.3f N\n", t, state.q[0] + 0.0, state.q[1] + 0.0, swing.input(t)[0]);
  }

  // A force that does no work guides the bead: it turns the velocity, as a wire does.
  const auto wire = input<1>("wire", [](const auto&, const auto& v, const auto& u) { return vector(-u[0] * v[1], u[0] * v[0]); });
  const auto bead = scene(mechanical_system<2>(Bead{}).with_names({"x", "y"}), wire);
  const auto fastest = trajectory_optimization(bead,
                                               {.start = {0.0, {0.0, 10.0}, {0.0, 0.0}}, .end = {2.0, {10.0, 5.0}, {5.0, 0.0}},
                                       .free_at_end = {"xdot", "ydot"}, .times = {{0.5, 5.0}}},
                                      minimum_time(), OptimalOptions{.intervals = 10, .stages = 5});
  std::printf("brachistochrone: %s, T = %.7f s\n", name(fastest.outcome), fastest.t_end);

  task.end.t = 0.5;
  task.bounds = {{"motor", -3.0, 3.0}};
  task.free_at_end = {"theta", "xdot", "thetadot"};
  std::printf("in half a second: %s\n", trajectory_optimization(cart, task, effort, OptimalOptions{.intervals = 8}).message.c_str());
}
