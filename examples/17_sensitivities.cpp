// SPDX-License-Identifier: MIT
//
// How a motion depends on its start and its parameters. How fast do small errors grow, what is a length worth, which swings are chaotic? And
// how to throw a ball at a wall by way of the floor.

#include <cmath>
#include <cstdio>
#include <type_traits>

#include <qdot/analysis/lyapunov.hpp>
#include <qdot/analysis/sensitivity.hpp>
#include <qdot/effects/contact.hpp>
#include <qdot/qdot.hpp>

using namespace qdot;

// The double pendulum of the README, made of the scalar of its parameters.
template <class S>
struct DoublePendulum {
  S l1, l2, g;

  auto T(const auto& q, const auto& qdot) const {
    using std::cos;
    return l1 * l1 * qdot[0] * qdot[0] + 0.5 * l2 * l2 * qdot[1] * qdot[1] + l1 * l2 * qdot[0] * qdot[1] * cos(q[0] - q[1]);
  }
  auto V(const auto& q) const {
    using std::cos;
    return -2.0 * g * l1 * cos(q[0]) - g * l2 * cos(q[1]);
  }
};

int main() {
  const Options tight{.rtol = 1e-12, .atol = 1e-13};

  const auto energies_of = [](const auto& p) { return DoublePendulum<std::remove_cvref_t<decltype(p[0])>>{p[0], p[1], p[2]}; };
  const auto swings = sensitivities(energies_of, Eigen::Vector3d(1.0, 1.0, 9.81), State<2>{0.0, {1.7, 1.7}, {0.0, 0.0}}, 10.0, Dop853{}, tight);
  for (const double t : {1.0, 3.0, 10.0}) {
    const Eigen::MatrixXd Phi = swings.Phi_at(t);
    std::printf("t = %4.1f   theta2 = %8.5f   by theta1(0): %12.5f   by l2: %12.5f   by g: %11.5f\n", t, swings.at(t).q[1], Phi(1, 0), Phi(1, 5), Phi(1, 6));
  }

  std::printf("\nboth rods released at rest from\n");
  for (const double angle : {0.5, 2.0}) {
    const auto system = mechanical_system<2>(energies_of(Eigen::Vector3d(1.0, 1.0, 9.81)));
    const auto parted = lyapunov_spectrum(system, State<2>{0.0, {angle, angle}, {0.0, 0.0}}, 200.0, Dop853{}, {.rtol = 1e-9, .atol = 1e-9});
    std::printf("%.1f rad: %s\n", angle, parted.lambda[0] > 0.1 + 5.0 * parted.standard_error[0] ? "chaotic" : "regular, as far as 200 s tell");
  }

  // A ball is thrown at the floor, e = 0.7, and is to hit a wall 3 m away at a height of 0.5 m. The run ends at the wall.
  const auto throws = [](const Eigen::Vector3d& p) {
    const auto ball = mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] * v[0] + v[1] * v[1]); }, [](const auto& q) { return 9.81 * q[1]; });
    const auto floor = contact("floor", [](const auto& q) { return q[1]; }, restitution(p[2]));
    return problem(scene(ball, floor), State<2>{0.0, {0.0, 1.5}, {p[0], p[1]}}, events(event("wall", [](const auto& q) { return q[0] - 3.0; }).stop()));
  };
  std::printf("\nspeed, at 45 degrees downwards, by Newton's method through the impact\n");
  double speed = 4.3;
  for (int k = 0; k < 5; ++k) {
    const Eigen::Vector3d p(speed * std::sqrt(0.5), -speed * std::sqrt(0.5), 0.7);
    const auto flight = sensitivities(throws, p, 5.0, Dop853{}, tight);
    const Eigen::RowVectorXd slope = flight.Phi_of_event.row(1);  // of the height where the ball is at the wall, whenever that is
    const double by_speed = std::sqrt(0.5) * (slope[0] - slope[1]);
    std::printf("speed %.9f   height %.9f   by speed: %.6f   by e: %.6f\n", speed, flight.y[1], by_speed, slope[2]);
    speed += (0.5 - flight.y[1]) / by_speed;
  }
}
