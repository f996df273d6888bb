// SPDX-License-Identifier: MIT
//
// Phases: a block that a spring pulls along sticks and slips, and a box leaves a table that shakes. Each beside its closed form.

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include <qdot/effects/contact.hpp>
#include <qdot/effects/dry_friction.hpp>
#include <qdot/effects/scene_at_state.hpp>
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/integrate/simulate.hpp>

using namespace qdot;

int main() {
  const Options tight{.rtol = 1e-12, .atol = 1e-13};

  // The end of a spring k moves with speed v. The block sticks until the spring pulls with F_s, and slides against F_k.
  const double k = 4.0, v = 0.5, F_k = 1.0, F_s = 2.0;
  const auto pulled = mechanical_system<1>([](const auto& qdot) { return 0.5 * qdot[0] * qdot[0]; },
                                           [=](const auto& q, const auto& t) { return 0.5 * k * (q[0] - v * t) * (q[0] - v * t); });
  const auto block = scene(pulled, dry_friction("block", 0, F_k, F_s));
  const auto run = simulate(block, State<1>{0.0, Vector<double, 1>(0.0), Vector<double, 1>(0.0)}, 5.0, Dop853{}, tight);
  for (const auto& what : run.events) std::printf("%-12s  t = %.6f   x = %.6f\n", what.name.c_str(), what.t, run.trajectory.at(what.t).q[0]);

  // It slips at F_s/(k v). With u = v t − x − F_k/k, ü = −4u from u = (F_s − F_k)/k and u̇ = v on, until u̇ is v again.
  const double slips = F_s / (k * v), sticks = slips + 0.75 * std::numbers::pi;
  std::printf("closed form: slips at %.6f, sticks at %.6f with x = %.6f\n\n", slips, sticks, v * sticks);

  // What holds it, and what brakes it, at a state: the phase is chosen as the state has it.
  const State<1> held = run.trajectory.at(0.5), slid = run.trajectory.at(2.0);
  std::printf("held     acceleration %.3f, friction %.3f\n", acceleration(block, held)[0], reactions(block, held)[0]);
  std::printf("sliding  power %.6f, by hand %.6f\n\n", power(block, slid), -F_k * slid.qdot[0]);

  // A box on a table that goes up and down by a sin(Ω t): the table would have to pull where a Ω² sin(Ω t) = g.
  const double a = 0.1, Omega = 12.0, g = 9.81;
  const auto box = mechanical_system<1>([](const auto& qdot) { return 0.5 * qdot[0] * qdot[0]; }, [=](const auto& q) { return g * q[0]; });
  const auto shaken = scene(box, contact("table", [=](const auto& q, const auto& t) {
    using std::sin;
    return q[0] - a * sin(Omega * t);
  }));
  const State<1> start{0.0, Vector<double, 1>(0.0), Vector<double, 1>(a * Omega)};
  std::printf("box      reaction at the start %.3f\n", reactions(shaken, start)[0]);
  const auto leaves = simulate(shaken, start, 0.5, Dop853{}, tight);
  for (const auto& what : leaves.events) std::printf("%-12s  t = %.6f\n", what.name.c_str(), what.t);
  std::printf("closed form: opens at %.6f\n", std::asin(g / (a * Omega * Omega)) / Omega);
}
