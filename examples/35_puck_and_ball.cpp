// SPDX-License-Identifier: MIT
//
// Friction in a plane: a puck stops, rides on a belt and turns downhill; a billiard ball with side and draw goes along a parabola. Each beside its closed form.

#include <cmath>
#include <cstdio>

#include <qdot/effects/dry_friction.hpp>
#include <qdot/effects/forces.hpp>
#include <qdot/effects/scene_at_state.hpp>
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/integrate/simulate.hpp>
#include <qdot/mechanics/rotation.hpp>

using namespace qdot;

template <class Sc, int n>
void print(const char* what, const Sc& scene, const State<n>& start, double t_end, double x, double y, double t) {
  const auto run = simulate(scene, start, t_end, Dop853{}, {.rtol = 1e-10, .atol = 1e-10});
  if (!run.completed()) return (void)std::fprintf(stderr, "%s\n", run.message.c_str());
  std::printf("%-9s %s at %.6f, at (%.6f, %.6f)\n", what, run.events.at(0).name.c_str(), run.events[0].t, run.state().q[0], run.state().q[1]);
  std::printf("          closed form  %.6f,    (%.6f, %.6f)\n", t, x, y);
}

int main() {
  const auto puck = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); });
  const auto velocity = [](const auto&, const auto& v) { return v; };
  print("stops", scene(puck, dry_friction("pad", velocity, 2.0)), State<2>{0.0, {0.0, 0.0}, {3.0, 4.0}}, 4.0, 3.75, 5.0, 2.5);

  // A belt that runs at 1 m/s along x: friction acts against the velocity relative to it.
  const auto on_belt = [](const auto&, const auto& v) {
    auto slip = v;
    slip[0] = slip[0] - 1.0;
    return slip;
  };
  print("belt", scene(puck, dry_friction("belt", on_belt, 2.0)), State<2>{0.0, {0.0, 0.0}, {0.0, 0.0}}, 2.0, 1.75, 0.0, 0.5);

  // Across an incline of 0.4 rad with mu = 0.6: the direction falls off as a power of the speed, k = mu/tan(alpha).
  const double alpha = 0.4, mu = 0.6, g = 9.81, v = 2.0, a = g * std::sin(alpha), k = mu / std::tan(alpha);
  const auto downhill = generalized_force([a](const auto& q, const auto&) {
    auto Q = q;
    Q[0] = a;
    Q[1] = 0.0;
    return Q;
  });
  print("incline", scene(puck, downhill, dry_friction("slope", velocity, mu * g * std::cos(alpha))), State<2>{0.0, {0.0, 0.0}, {0.0, v}}, 1.0,
        v * v / (4 * a) * (1 / (2 * k - 2) - 1 / (2 * k + 2)), v * v / (2 * a) * (1 / (2 * k - 1) + 1 / (2 * k + 1)), v * k / (a * (k * k - 1)));

  // A ball on cloth: x, y and a quaternion p, whose length has an inertia of its own. The point of contact slips with ẋ − R ω_y, ẏ + R ω_x.
  const double R = 0.0286, I = 0.4 * R * R, cloth = 0.2;
  const auto spin = [](const auto& q, const auto& v) {
    return angular_velocity_of([](const auto& p) { return rotation_from_quaternion(p); }, q.template tail<4>(), v.template tail<4>());
  };
  const auto ball = mechanical_system<6>([=](const auto& q, const auto& v) {
    const auto along = q.template tail<4>().dot(v.template tail<4>());
    return 0.5 * (v[0] * v[0] + v[1] * v[1] + I * spin(q, v).squaredNorm() + I * along * along);
  });
  const auto slip = [=](const auto& q, const auto& v) {
    const auto omega = spin(q, v);
    auto u = omega.template head<2>().eval();
    u[0] = v[0] - R * omega[1];
    u[1] = v[1] + R * omega[0];
    return u;
  };
  State<6> start{0.0, {}, {}};
  start.q << 0.0, 0.0, 1.0, 0.0, 0.0, 0.0;
  start.qdot << 2.0, 0.0, 0.0, 5.0, -30.0, 12.5;  // spin (10, -60, 25) rad/s: side, draw and a turn about the vertical
  const double u0 = 2.0 + 60.0 * R, u1 = 10.0 * R, t = 2.0 * std::hypot(u0, u1) / (7.0 * cloth * g), t_end = 3.0;
  const double path = t_end - 0.5 * t;  // velocity falls evenly by 2/7 of the slip until it rolls
  print("ball", scene(ball, dry_friction("cloth", slip, cloth * g)), start, t_end, 2.0 * t_end - 2.0 / 7.0 * u0 * path, -2.0 / 7.0 * u1 * path, t);
}
