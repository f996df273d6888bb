// SPDX-License-Identifier: MIT
//
// Positions are enough: velocities are differentiated from them. A point in spherical coordinates, its kinetic energy and mass
// matrix, and a pendulum whose pivot is shaken, which stands upright if it is shaken fast enough.

#include <cmath>
#include <cstdio>

#include <qdot/analysis/modes.hpp>
#include <qdot/mechanics/velocity.hpp>
#include <qdot/qdot.hpp>

int main() {
  using namespace qdot;

  // r, θ, φ → x, y, z. The same function serves numbers, dual numbers, and dual numbers of dual numbers.
  const auto position = [](const auto& q) {
    using std::cos, std::sin;
    return vector(q[0] * sin(q[1]) * cos(q[2]), q[0] * sin(q[1]) * sin(q[2]), q[0] * cos(q[1]));
  };
  const Vector<double, 3> q(1.5, 0.8, 0.3), qdot(0.2, -0.5, 1.1);
  const Vector<double, 3> v = velocity_of(position, q, qdot);
  std::printf("velocity       (%.6f, %.6f, %.6f)\n", v[0], v[1], v[2]);
  const double r = q[0], s = std::sin(q[1]);
  std::printf("v^2            %.6f\n", v.squaredNorm());
  std::printf("by hand        %.6f   rdot^2 + r^2 thetadot^2 + r^2 sin^2(theta) phidot^2\n\n",
              qdot[0] * qdot[0] + r * r * qdot[1] * qdot[1] + r * r * s * s * qdot[2] * qdot[2]);

  // Inside T: Lagrange's equations differentiate through it.
  const auto T = [&](const auto& x, const auto& xdot) { return 0.5 * velocity_of(position, x, xdot).squaredNorm(); };
  const auto point = mechanical_system<3>(T).with_names({"r", "theta", "phi"});
  const Matrix<double, 3> M = mass_matrix(point, q, qdot);
  std::printf("mass matrix    diag(%.6f, %.6f, %.6f)\n", M(0, 0), M(1, 1), M(2, 2));
  std::printf("by hand        diag(%.6f, %.6f, %.6f)\n\n", 1.0, r * r, r * r * s * s);

  // A prescribed motion: the pivot goes up and down as A cos γt, and ∂r/∂t is taken care of.
  const double g = 9.81, A = 0.05, gamma = 150.0;
  const auto shaken = mechanical_system<1>(
      [=](const auto& x, const auto& xdot, const auto& t) {
        const auto bob = [=](const auto& y, const auto& time) {
          using std::cos, std::sin;
          return vector(sin(y[0]), A * cos(gamma * time) - cos(y[0]));
        };
        return 0.5 * velocity_of(bob, x, xdot, t).squaredNorm();
      },
      [=](const auto& x) {
        using std::cos;
        return -g * cos(x[0]);
      });
  const double angle = 2.5, t = 0.01;
  const auto qddot = acceleration(shaken, Vector<double, 1>(angle), Vector<double, 1>(0.7), t);
  std::printf("shaken pivot   theta'' = %.6f\n", qddot[0]);
  std::printf("by hand        theta'' = %.6f   -(g - A gamma^2 cos(gamma t)) sin(theta)\n\n",
              -(g - A * gamma * gamma * std::cos(gamma * t)) * std::sin(angle));

  // Shaken fast, the upright position is a minimum of the averaged potential −g cos θ + ¼ A²γ² sin² θ (Kapitza).
  const auto averaged = mechanical_system<1>([](const auto& xdot) { return 0.5 * xdot[0] * xdot[0]; },
                                             [=](const auto& x) {
                                               using std::cos, std::sin;
                                               return -g * cos(x[0]) + 0.25 * A * A * gamma * gamma * sin(x[0]) * sin(x[0]);
                                             });
  const auto upright = equilibrium_near(averaged, Vector<double, 1>(3.0));
  std::printf("upright        theta = %.6f, omega^2 = %.4f: %s\n", upright[0],
              normal_modes(averaged, upright).squared_frequencies[0],
              normal_modes(averaged, upright).squared_frequencies[0] > 0.0 ? "stable" : "unstable");
}
