// SPDX-License-Identifier: MIT
//
// The lecture's procedure, step by step, for a rod on a pivot O with a ring that slides on it.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include <qdot/mechanics/degrees_of_freedom.hpp>
#include <qdot/mechanics/inertia.hpp>
#include <qdot/mechanics/velocity.hpp>
#include <qdot/qdot.hpp>

using namespace qdot;

int main() {
  const double M = 2.0, L = 1.5, m = 0.3, g = 9.81;

  // 1. The constraints, in the coordinates that everything would have without them: rod (x_G, y_G, φ), ring (x, y).
  const auto constraints = [=](const auto& x) {
    using std::cos, std::sin;
    return vector(x[0] - 0.5 * L * cos(x[2]),             // the rod's end stays at O, horizontally
                  x[1] - 0.5 * L * sin(x[2]),             // and vertically
                  x[4] * cos(x[2]) - x[3] * sin(x[2]));   // the ring stays on the rod
  };
  std::printf("1. constraints            3, holonomic: phi(x) = 0\n");

  // 2. Degrees of freedom: N − rank of ∂φ/∂x at a configuration that satisfies them.
  Vector<double, 5> x;
  x << 0.5 * L * std::cos(0.2), 0.5 * L * std::sin(0.2), 0.2, 0.4 * std::cos(0.2), 0.4 * std::sin(0.2);
  const ConstraintRank count = constraint_rank(constraints, x);
  std::printf("2. degrees of freedom     %d - %d = %d\n", static_cast<int>(count.coordinates),
              static_cast<int>(count.rank), static_cast<int>(count.degrees_of_freedom));

  // 3. Coordinates that satisfy the constraints by themselves.
  const auto along_rod = [](const auto& distance, const auto& phi) {
    using std::cos, std::sin;
    return vector(distance * cos(phi), distance * sin(phi));
  };
  const auto ring = [=](const auto& q) { return along_rod(q[0], q[1]); };
  const auto middle = [=](const auto& q) { return along_rod(0.5 * L, q[1]); };
  std::printf("3. coordinates            q = (r, phi)\n");

  // 4.–6. Kinetic energy: the point, the body about its centre of mass (Koenig), the sum.
  const double I_G = inertia::thin_rod(M, L)(2, 2);
  const auto T_ring = [=](const auto& q, const auto& qdot) { return 0.5 * m * velocity_of(ring, q, qdot).squaredNorm(); };
  const auto T_rod = [=](const auto& q, const auto& qdot) {
    return 0.5 * M * velocity_of(middle, q, qdot).squaredNorm() + 0.5 * I_G * qdot[1] * qdot[1];
  };
  const auto T = [=](const auto& q, const auto& qdot) { return T_ring(q, qdot) + T_rod(q, qdot); };
  const Vector<double, 2> q(0.4, 0.2), qdot(0.1, 1.0);
  std::printf("4. T of the ring          %.9f\n5. T of the rod           %.9f\n6. T                      %.9f\n",
              T_ring(q, qdot), T_rod(q, qdot), T(q, qdot));

  // 7. Potential energy: the heights of the ring and of the rod's middle.
  const auto V = [=](const auto& p) { return m * g * ring(p)[1] + M * g * middle(p)[1]; };
  std::printf("7. V                      %.9f\n", V(q));

  // 8. and 9. The Lagrangian and its equations.
  const auto system = mechanical_system<2>(T, V).with_names({"r", "phi"});
  std::printf("8. L = T - V              %.9f\n", lagrangian(system, q, qdot));
  const Vector<double, 2> qddot = acceleration(system, q, qdot);
  std::printf("9. (r'', phi'')           (%.9f, %.9f)\n", qddot[0], qddot[1]);

  // The lecture's equations, r'' = r φ'² − g sin φ and (I_O + m r²) φ'' + 2 m r r' φ' + (m r + M L/2) g cos φ = 0.
  const double I_O = M * L * L / 3.0;
  std::mt19937 random(1);
  double worst = 0.0;
  for (int sample = 0; sample < 1000; ++sample) {
    const auto number = [&](double low, double high) { return low + (high - low) * static_cast<double>(random()) / 4294967295.0; };
    const double r = number(0.1, 1.5), phi = number(-3.0, 3.0), rdot = number(-2.0, 2.0), phidot = number(-2.0, 2.0);
    const Vector<double, 2> a = acceleration(system, Vector<double, 2>(r, phi), Vector<double, 2>(rdot, phidot));
    const double first = r * phidot * phidot - g * std::sin(phi);
    const double second = -(2.0 * m * r * rdot * phidot + (m * r + 0.5 * M * L) * g * std::cos(phi)) / (I_O + m * r * r);
    worst = std::max({worst, std::abs(a[0] - first), std::abs(a[1] - second)});
  }
  std::printf("against the lecture's equations at 1000 random states: %s\n", worst <= 1e-13 ? "equal to 1e-13" : "DIFFERENT");
  return worst <= 1e-13 ? 0 : 1;
}
