// SPDX-License-Identifier: MIT
//
// Chaos, seen by 200 double pendulums at once: released within a millionth of a radian of each other, they part. One column of the
// matrices is one pendulum, and all of them take each step of the classical Runge–Kutta method together.
#include <qdot/mechanics/accelerations.hpp>
#include <qdot/qdot.hpp>

#include <cmath>
#include <cstdio>

struct DoublePendulum {
  double m1 = 1.0, m2 = 1.0;  // kg
  double l1 = 1.0, l2 = 1.0;  // m
  double g = 9.81;            // m/s²

  auto T(const auto& q, const auto& qdot) const {
    using std::cos;
    return 0.5 * (m1 + m2) * l1 * l1 * qdot[0] * qdot[0] + 0.5 * m2 * l2 * l2 * qdot[1] * qdot[1] +
           m2 * l1 * l2 * qdot[0] * qdot[1] * cos(q[0] - q[1]);
  }
  auto V(const auto& q) const {
    using std::cos;
    return -(m1 + m2) * g * l1 * cos(q[0]) - m2 * g * l2 * cos(q[1]);
  }
};

int main() {
  using Members = Eigen::Matrix<double, 2, qdot::Dynamic, Eigen::RowMajor>;  // angles of all pendulums side by side
  constexpr int count = 200;
  constexpr double h = 0.002;

  const auto system = qdot::mechanical_system<2>(DoublePendulum{}).with_names({"theta1", "theta2"});
  Members q(2, count), qdot = Members::Zero(2, count);
  q.row(0).setLinSpaced(2.0, 2.0 + 1e-6);
  q.row(1).setConstant(2.5);

  const auto accelerations = [&](const Members& x, const Members& v) {
    const auto found = qdot::accelerations(system, x, v);
    for (const auto& failure : found.failures)  // none here; a member whose mass matrix were singular would be named
      std::printf("member %ld: %s\n", static_cast<long>(failure.member), failure.message.c_str());
    return found.qddot;
  };

  const auto spread = [](const Members& x) { return (x.rowwise().maxCoeff() - x.rowwise().minCoeff()).norm(); };
  std::printf("  t/s   spread of angles    of velocities\n");
  for (int step = 0; step <= 2500; ++step) {
    if (step % 500 == 0) std::printf("%5.1f   %.1e rad         %.1e rad/s\n", step * h, spread(q), spread(qdot));
    const Members a1 = accelerations(q, qdot);
    const Members v2 = qdot + 0.5 * h * a1, a2 = accelerations(q + 0.5 * h * qdot, v2);
    const Members v3 = qdot + 0.5 * h * a2, a3 = accelerations(q + 0.5 * h * v2, v3);
    const Members v4 = qdot + h * a3, a4 = accelerations(q + h * v3, v4);
    q += h / 6.0 * (qdot + 2.0 * v2 + 2.0 * v3 + v4);
    qdot += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  }
  return 0;
}
