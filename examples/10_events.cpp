// SPDX-License-Identifier: MIT
//
// Moments at which something happens: crossings that are recorded, impacts, a rope that goes slack, friction that sticks.
// And an account of the energy, which none of them may create.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include <qdot/effects/contact.hpp>
#include <qdot/effects/dry_friction.hpp>
#include <qdot/integrate/energy_balance.hpp>
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/qdot.hpp>

using namespace qdot;
using V1 = Vector<double, 1>;
using V2 = Vector<double, 2>;

int main() {
  const double g = 9.81;
  const Options tight{.rtol = 1e-12, .atol = 1e-13};

  // A ball on a floor: infinitely many impacts in finite time, and then it lies there.
  const double e = 0.8;
  const auto falling = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [=](const auto& q) { return g * q[0]; });
  const auto ball = scene(falling, contact("floor", [](const auto& q) { return q[0]; }, restitution(e)));
  auto meter = energy_balance(ball);
  const auto bounces = simulate(ball, State<1>{0.0, V1(1.0), V1(0.0)}, 5.0, Dop853{}, tight, meter);
  double worst = 0.0, t = std::sqrt(2.0 / g), flight = 2.0 * t;
  for (int k = 0; k < 40; ++k, t += flight *= e) worst = std::max(worst, std::abs(bounces.events[static_cast<std::size_t>(k)].t - t));
  std::printf("ball      40 impacts like the closed form to 1e-10: %s\n", worst < 1e-10 ? "yes" : "no");
  std::printf("          %s at %.4f s; the limit of all impacts is %.4f s\n", bounces.events.back().name.c_str(),
              bounces.events.back().t, std::sqrt(2.0 / g) * (1 + e) / (1 - e));
  std::printf("          lost in impacts %.6f of %.6f, balance kept to 1e-10: %s\n\n", -meter.balance().impacts,
              meter.balance().initial, meter.balance().residual < 1e-10 ? "yes" : "no");

  // A bob on a rope, thrown so hard that it leaves its circle; the top of its flight is recorded as well.
  const auto free_fall = mechanical_system<2>([](const auto& v) { return 0.5 * v.squaredNorm(); }, [=](const auto& q) { return g * q[1]; });
  const auto swing = scene(free_fall, rope("rope", [](const auto& q) { return q; }, V2(0.0, 0.0), 1.0));
  const double v0 = 5.5;
  const auto thrown = simulate(swing, State<2>{0.0, V2(0.0, -1.0), V2(v0, 0.0)}, 1.3, Dop853{}, tight,
                               events(event("top", [](const auto&, const auto& v) { return v[1]; }).falling()));
  for (const auto& what : thrown.events) {
    const auto at = thrown.trajectory.at(what.t);
    std::printf("%-10s  t = %.6f   (x, y) = (%9.6f, %9.6f)\n", what.name.c_str(), what.t, at.q[0], at.q[1]);
  }
  std::printf("closed form: slack at y = %.6f\n\n", -(2.0 - v0 * v0 / g) / 3.0);

  // A block on a spring with dry friction: 4F/k less amplitude each cycle, until the spring is too weak to move it.
  const double k = 4.0, F = 0.3;
  const auto spring = mechanical_system<1>([](const auto& v) { return 0.5 * v[0] * v[0]; }, [=](const auto& q) { return 0.5 * k * q[0] * q[0]; });
  const auto block = scene(spring, dry_friction("block", 0, F));
  const auto slides = simulate(block, State<1>{0.0, V1(1.0), V1(0.0)}, 20.0, Dop853{}, tight);
  for (const auto& what : slides.events)
    std::printf("%-12s  t = %4.2f pi   x = %5.2f\n", what.name.c_str(), what.t / std::numbers::pi, slides.trajectory.at(what.t).q[0]);
  const auto end = slides.state();
  std::printf("friction at rest %.2f, of at most %.2f\n", reactions(block, end.q, end.qdot, end.t, settled_states(block, end))[0], F);
}
