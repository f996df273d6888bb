// SPDX-License-Identifier: MIT
//
// Motions that repeat: the backbone curve of a pendulum, a limit cycle and its fold, a pendulum that stands on its head and its return map. And where
// Mathieu's equation becomes unstable.

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include <qdot/analysis/orbit_family.hpp>
#include <qdot/analysis/return_map.hpp>
#include <qdot/qdot.hpp>

using namespace qdot;

// θ on a pivot that shakes by A cos ωt, or x on a spring a − 2s cos 2t.
struct Swinger {
  double g = 0.0, A = 0.0, omega = 1.0, a = 0.0, s = 0.0;

  auto T(const auto& v) const { return 0.5 * v[0] * v[0]; }
  auto V(const auto& q, const auto& t) const {
    using std::cos;
    return -(g - A * omega * omega * cos(omega * t)) * cos(q[0]) + 0.5 * (a - 2.0 * s * cos(2.0 * t)) * q[0] * q[0];
  }
};

void print(const Orbit& orbit) {
  std::printf("  T = %.9f, %s;", orbit.period, std::string(description(orbit.stability)).c_str());
  for (const Multiplier& m : orbit.multipliers) std::printf("  %.6f %+.6fi%s", m.value.real(), m.value.imag(), m.trivial ? " (trivial)" : "");
  std::printf("\n");
}

int main() {
  const double pi = std::numbers::pi;
  FamilyOptions ten_digits{.first_step = 0.1, .longest_step = 0.3};
  ten_digits.orbit.tolerance = 1e-8;
  ten_digits.orbit.integration = {.rtol = 1e-11, .atol = 1e-12};

  const auto pendulum = mechanical_system<1>(Swinger{.g = 1.0});
  std::printf("a pendulum that swings by 1.3 rad, from a guess of 6.5\n");
  const auto swing = periodic_orbit_near(pendulum, State<1>{0.0, {1.3}, {0.0}}, 6.5, hold_coordinate(0));
  print(swing);
  for (const OrbitIteration& step : swing.history) std::printf("    T = %.9f   off by %.7f\n", step.period, step.residual);

  std::printf("its family up to 2.5 rad\n");
  const auto swings = continue_orbits(pendulum, swing.start(), swing.period, in_energy(-std::cos(2.5)), ten_digits);
  for (const FamilyOrbit& orbit : swings.orbits)
    std::printf("  %-8s h = %8.5f   T = %9.5f\n", std::string(name(orbit.kind)).c_str(), orbit.energy, orbit.period);

  std::printf("upside down on a pivot that shakes by 0.1, at two frequencies\n");
  for (const double omega : {13.5, 14.5}) {
    const auto shaken = mechanical_system<1>(Swinger{.g = 1.0, .A = 0.1, .omega = omega});
    print(periodic_orbit_near(shaken, State<1>{0.0, {pi}, {0.0}}, 2 * pi / omega, driven()));
  }

  std::printf("the second of them, seen once in each period, from a start beside it\n");
  const auto shaken = mechanical_system<1>(Swinger{.g = 1.0, .A = 0.1, .omega = 14.5});
  const auto flash = event("flash", [](const auto&, const auto&, double t) { return std::sin(14.5 * t); }).rising();
  const auto seen = poincare_section(shaken, State<1>{0.0, {pi + 0.1}, {0.0}}, flash, 5, 100.0, Dop853{}, {.rtol = 1e-12});
  for (std::size_t k = 0; k < seen.size(); ++k)
    std::printf("  t = %.6f   %.6f rad beside, %9.6f rad/s\n", seen.t[k], seen.state(k).q[0] - pi, seen.state(k).qdot[0]);
  const auto P = return_map(shaken, State<1>{0.0, {pi}, {0.0}}, flash, 100.0, Dop853{}, {.rtol = 1e-12});
  std::printf("  half the trace of DP on its head: %.6f\n", 0.5 * P.derivative.trace());

  std::printf("x'' + (a - 2 cos 2t) x = 0, where it changes between stable and unstable\n");
  const auto mathieu = [](const Vector<double, 1>& p) { return problem(mechanical_system<1>(Swinger{.a = p[0], .s = 1.0}), State<1>{0.0, {0.0}, {0.0}}); };
  for (const FamilyOrbit& orbit : continue_orbits(mathieu, -0.3, pi, in_parameter(4.2), driven(), ten_digits).orbits)
    if (orbit.kind == OrbitKind::period_doubling || orbit.kind == OrbitKind::branch)
      std::printf("  a = %9.6f   %s\n", orbit.value, std::string(name(orbit.kind)).c_str());

  std::printf("a cycle of x'' + x = (p + 2 r^2 - r^4) x', r^2 = x^2 + x'^2, that meets its unstable twin\n");
  const auto fed = [](const Vector<double, 1>& p) {
    const auto feed = generalized_force([p = p[0]](const auto& q, const auto& v) {
      auto Q = q;
      const auto r2 = q[0] * q[0] + v[0] * v[0];
      Q[0] = (p + (2.0 - r2) * r2) * v[0];
      return Q;
    });
    return problem(scene(mechanical_system<1>(Swinger{.a = 1.0}), feed), State<1>{0.0, {1.3}, {0.0}});
  };
  for (const FamilyOrbit& orbit : continue_orbits(fed, -0.8, 6.3, in_parameter(-1.8), hold_nothing(), ten_digits).orbits)
    if (orbit.kind != OrbitKind::regular) {
      std::printf("  %-5s p = %9.6f, r = %.4f:", std::string(name(orbit.kind)).c_str(), orbit.value, orbit.x.norm());
      print(orbit);
    }
}
