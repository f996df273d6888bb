// SPDX-License-Identifier: MIT
//
// A pendulum from its two energies: acceleration, motion, and the period against the elliptic integral.

#include <cmath>
#include <cstdio>
#include <numbers>

#include <qdot/integrate/cvode.hpp>
#include <qdot/integrate/simulate.hpp>
#include <qdot/qdot.hpp>

// K(m), the complete elliptic integral, by the arithmetic-geometric mean.
double elliptic_K(double m) {
  double a = 1.0, b = std::sqrt(1.0 - m);
  for (int i = 0; i < 8; ++i) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  return std::numbers::pi / (2.0 * a);
}

int main() {
  const double m = 0.5, l = 1.2, g = 9.81;

  const auto T = [=](const auto& qdot) { return 0.5 * m * l * l * qdot[0] * qdot[0]; };
  const auto V = [=](const auto& q) {
    using std::cos;
    return -m * g * l * cos(q[0]);
  };
  const auto pendulum = qdot::mechanical_system<1>(T, V).with_names({"theta"});

  using Vector1 = qdot::Vector<double, 1>;
  std::printf("theta    theta''   -(g/l) sin theta\n");
  for (const double theta : {0.1, 1.0, 2.0}) {
    const Vector1 qddot = acceleration(pendulum, Vector1(theta), Vector1(0.0));
    std::printf("%.1f    %9.6f   %9.6f\n", theta, qddot[0], -g / l * std::sin(theta));
  }

  // Released at rest, the pendulum is at rest again after one period: the error of the period shows in θ̇/θ̈.
  std::printf("\ntheta0   4 sqrt(l/g) K(sin^2 theta0/2)   error of the simulated period below 1e-10?\n");
  for (const double theta0 : {0.1, 1.0, 2.5}) {
    const double half = std::sin(0.5 * theta0);
    const double period = 4.0 * std::sqrt(l / g) * elliptic_K(half * half);
    const qdot::State<1> start{0.0, Vector1(theta0), Vector1(0.0)};
    const auto run = simulate(pendulum, start, period, qdot::CvodeAdams{}, {.rtol = 1e-13, .atol = 1e-14});
    if (!run.completed()) {
      std::fprintf(stderr, "%s\n", run.message.c_str());
      return 1;
    }
    const double error = run.state().qdot[0] / acceleration(pendulum, run.state())[0];
    std::printf("%.1f      %.10f                      %s\n", theta0, period, std::abs(error) < 1e-10 ? "yes" : "no");
  }
}
