// SPDX-License-Identifier: MIT
//
// A pendulum that stands on a cart: where it rests, how it falls, and a feedback that holds it up. The pole's end is a mass in Cartesian coordinates,
// tied to the cart by a rod, so all of this happens on a constraint. The linearization finds the coordinates that are free.

#include <cmath>
#include <cstdio>

#include <qdot/analysis/linearization.hpp>
#include <qdot/analysis/lqr.hpp>
#include <qdot/effects/constraints.hpp>
#include <qdot/effects/dissipation.hpp>
#include <qdot/integrate/runge_kutta.hpp>
#include <qdot/qdot.hpp>

using namespace qdot;
using Eigen::MatrixXd;
using Eigen::Vector3d;

// q = (s, x, y): the cart of 2 kg on its track, the mass of 1 kg at the end of a rod of 1 m.
struct CartAndMass {
  auto T(const auto& v) const { return 0.5 * 2.0 * v[0] * v[0] + 0.5 * (v[1] * v[1] + v[2] * v[2]); }
  auto V(const auto& q) const { return 9.81 * q[2]; }
};

void show(const DampedModes& modes) {
  std::printf("  %s\n", description(modes.stability));
  for (const DampedMode& mode : modes.modes)
    std::printf("  exponent %7.4f %+7.4fi   damping ratio %7.4f\n", mode.exponent.real() + 0.0,
                mode.exponent.imag() + 0.0, mode.damping_ratio);
}

int main() {
  const auto rod =
      holonomic("rod", [](const auto& q) { return 0.5 * ((q[1] - q[0]) * (q[1] - q[0]) + q[2] * q[2] - 1.0); });
  const auto system = mechanical_system<3>(CartAndMass{}).with_names({"s", "x", "y"});
  const auto plant = scene(system, rod, viscous_damping(Vector3d(0.5, 0.0, 0.0)));

  for (const double y : {-0.9, 0.9}) {
    const auto rest = equilibrium_near(plant, Vector3d(0.0, 0.0, y));
    std::printf("rest at y = %.4f, the rod pulls with %.2f N\n", rest.state.q[2], -rest.lambda[0]);
    show(damped_modes(linearization(plant, rest)));
  }

  // Upright, with a motor that pushes the cart.
  const auto upright = equilibrium_near(plant, Vector3d(0.0, 0.0, 0.9));
  const Linearization linear = linearization(plant, upright, input("motor", 0));
  std::printf("x = (");
  for (const auto& name : linear.states) std::printf(" %s", name.c_str());
  std::printf(" )\n");
  const Lqr held = lqr(linear, MatrixXd::Identity(4, 4), MatrixXd::Identity(1, 1));
  std::printf("K = (");
  for (Eigen::Index i = 0; i < 4; ++i) std::printf(" %.4f", held.K(0, i));
  std::printf(" ), slowest pole %.4f\n", held.exponents.real().maxCoeff());

  // The same feedback on the scene itself, from the pole 0.3 m aside.
  const auto feedback = generalized_force([K = held.K](const auto& q, const auto& v) {
    auto Q = q;
    Q[0] = -(K(0, 0) * q[0] + K(0, 1) * q[1] + K(0, 2) * v[0] + K(0, 3) * v[1]);
    Q[1] = Q[2] = 0.0;
    return Q;
  });
  const State<3> aside{0.0, Vector3d(0.0, 0.3, std::sqrt(0.91)), Vector3d::Zero()};
  const auto run = simulate(scene(plant, feedback), aside, 20.0, Dop853{});
  const State<3> at_end = run.state();
  std::printf("after 20 s: s = %.3f m, x = %.3f m, y = %.6f m\n", std::abs(at_end.q[0]), std::abs(at_end.q[1]),
              at_end.q[2]);
}
