// SPDX-License-Identifier: MIT
//
// Mass that leaves and mass that is caught. T with m(t) makes d/dt(m v) = Q; what leaves with the body's own velocity takes ṁ v along, so Q = thrust + ṁ v.

#include <cmath>
#include <cstdio>

#include <qdot/effects/forces.hpp>
#include <qdot/effects/scene_form.hpp>
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/integrate/simulate.hpp>

using namespace qdot;

int main() {
  const Options tight{.rtol = 1e-12, .atol = 1e-12};
  const double g = 9.81;
  const State<1> rest{0.0, Vector<double, 1>(0.0), Vector<double, 1>(0.0)};

  // A rocket: m falls from 1000 by 8 each second for 100 s, and the gas leaves with u = 2500 relative to it.
  const double m0 = 1000.0, burnt = 8.0, u = 2500.0, T_burn = 100.0;
  const auto mass = [=](const auto& t) { return m0 - burnt * t; };
  const auto rocket = mechanical_system<1>([=](const auto&, const auto& v, const auto& t) { return 0.5 * mass(t) * v[0] * v[0]; },
                                           [=](const auto& q, const auto& t) { return mass(t) * g * q[0]; });
  const auto engine = generalized_force([=](const auto&, const auto& v, const auto&) {
    auto Q = v;
    Q[0] = burnt * u - burnt * v[0];  // thrust + ṁ v, ṁ = −burnt
    return Q;
  });
  const auto flight = simulate(scene(rocket, engine), rest, T_burn, Dop853{}, tight);
  const double m1 = m0 - burnt * T_burn, ln = std::log(m0 / m1);
  std::printf("rocket    v = %.6f m/s, by u ln(m0/m1) - g t = %.6f\n", flight.y[1], u * ln - g * T_burn);
  std::printf("          h = %.4f m, closed form %.4f\n", flight.y[0], u * (T_burn - m1 / burnt * ln) - 0.5 * g * T_burn * T_burn);

  // Without ṁ v the gas would take no momentum along, however fast the rocket is: another motion.
  const auto thrust = generalized_force([=](const auto&, const auto& v, const auto&) {
    auto Q = v;
    Q[0] = 0.0 * v[0] + burnt * u;
    return Q;
  });
  std::printf("          with thrust alone v = %.1f m/s, d/dt(m v) = F\n\n", simulate(scene(rocket, thrust), rest, T_burn, Dop853{}, tight).y[1]);

  // A drop that catches mist at rest, 0.1 g each second: what it catches brings no momentum, so there is nothing to add.
  const double c = 1e-4, drop0 = 1e-4;
  const auto grown = [=](const auto& t) { return drop0 + c * t; };
  const auto drop = mechanical_system<1>([=](const auto&, const auto& v, const auto& t) { return 0.5 * grown(t) * v[0] * v[0]; },
                                         [=](const auto& q, const auto& t) { return -grown(t) * g * q[0]; });
  const auto falls = simulate(drop, rest, 10.0, Dop853{}, tight);
  std::printf("drop      v = %.6f m/s, closed form %.6f\n", falls.y[1], g * (drop0 * 10.0 + 0.5 * c * 100.0) / (drop0 + c * 10.0));
}
