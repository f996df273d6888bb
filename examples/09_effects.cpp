// SPDX-License-Identifier: MIT
//
// A scene is a system and the effects that it names. Here: a pendulum in Cartesian coordinates on a rod (a constraint),
// with friction in the air (a Rayleigh function) and a gust of wind, an effect that this file brings itself.

#include <cmath>
#include <cstdio>

#include <qdot/effects/constraints.hpp>
#include <qdot/effects/dissipation.hpp>
#include <qdot/effects/scene_form.hpp>
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/integrate/simulate.hpp>

using qdot::Vector;

// An effect of one's own: any type with a member force(q, qdot, t) that works for every scalar.
struct Wind {
  double strength = 0.5;

  template <class S, int n>
  Vector<S, n> force(const Vector<S, n>&, const Vector<S, n>&, const S& t) const {
    using std::sin;
    return {strength * sin(t), S(0)};
  }
};

int main() {
  const double m = 1.0, l = 1.0, g = 9.81, c = 0.2;
  const auto bob = qdot::mechanical_system<2>([=](const auto& qdot) { return 0.5 * m * qdot.squaredNorm(); },
                                              [=](const auto& q) { return m * g * q[1]; })
                       .with_names({"x", "y"});
  const auto rod = qdot::holonomic("rod", [=](const auto& q) { return 0.5 * (q.squaredNorm() - l * l); });
  const auto air = qdot::rayleigh([=](const auto&, const auto& qdot) { return 0.5 * c * qdot.squaredNorm(); });
  const auto pendulum = scene(bob, rod, air, Wind{0.5});

  // A rough start becomes a consistent one, and says what it moved.
  const auto [start, report] = consistent_state(pendulum, qdot::State<2>{0.0, {0.8, -0.7}, {0.0, 1.0}});
  std::printf("start      q = (%.6f, %.6f), moved by %.3f\n", start.q[0], start.q[1], report.moved_q);

  // The rod's tension is its multiplier: Jᵀλ is the force on the bob, J = qᵀ, so the rod pulls with −λ l.
  const auto first = constrained_acceleration(pendulum, start.q, start.qdot, start.t);
  std::printf("tension    %.6f, by hand %.6f\n", -first.lambda[0] * l,
              m * (start.qdot.squaredNorm() / l - g * start.q[1] / l));

  const auto run = simulate(pendulum, start, 20.0, qdot::Dop853{}, {.rtol = 1e-10, .atol = 1e-12});
  for (const double t : {0.0, 5.0, 10.0, 15.0, 20.0}) {
    const auto state = run.trajectory.at(t);
    std::printf("t = %4.1f   q = (%8.5f, %8.5f)   E = %8.5f   power of air and wind = %8.5f\n", t, state.q[0], state.q[1],
                energy(pendulum, state.q, state.qdot), power(pendulum, state.q, state.qdot, t));
  }
  std::printf("%s, off the rod by less than 1e-15: %s\n", std::string(name(run.outcome)).c_str(),
              run.statistics.constraint_residual < 1e-15 ? "yes" : "no");
}
