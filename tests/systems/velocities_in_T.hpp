#pragma once
// SPDX-License-Identifier: MIT
//
// Velocities inside T, against nested duals, which differentiate the whole of T twice: what tests/optimized and tests/ways have in common.

#include <algorithm>
#include <random>

#include "qdot/mechanics/equations_of_motion.hpp"
#include "qdot/mechanics/rigid_body.hpp"
#include "qdot/mechanics/velocity.hpp"
#include "systems/solution_by_pivots.hpp"

namespace qdot::test {

// A body that turns; the length of the quaternion has an inertia of its own.
struct Turning {
  auto T(const auto& p, const auto& v) const {
    const auto w = body_angular_velocity_of([](const auto& x) { return rotation_from_quaternion(x); }, p, v);
    const auto d = p[0] * v[0] + p[1] * v[1] + p[2] * v[2] + p[3] * v[3];
    return 0.5 * (1.0 * w[0] * w[0] + 2.0 * w[1] * w[1] + 2.5 * w[2] * w[2] + d * d);
  }
  auto V(const auto& p) const { return 0.3 * p[0] * p[3]; }
};

/// The largest difference of accelerations at twenty states, beside 1 and the acceleration.
template <int n, class E>
double difference(const E& energies, Eigen::Index size = n) {
  const auto system = [&] {
    if constexpr (n == Dynamic) return mechanical_system(size, energies);
    else return mechanical_system<n>(energies);
  }();
  std::mt19937 random(17);
  std::uniform_real_distribution<double> uniform(0.4, 1.6);
  double worst = 0.0;
  for (int sample = 0; sample < 20; ++sample) {
    Vector<double, n> q(size), v(size);
    for (Eigen::Index i = 0; i < size; ++i) {
      q[i] = uniform(random);
      v[i] = uniform(random) - 1.0;
    }
    const double t = uniform(random);
    const Matrix<double, n> M = detail::kinetic_hessian<n>(system.energies(), q, v, t);
    const Vector<double, n> r = detail::lagrange_rhs<n>(system.energies(), q, v, t), expected = solution_by_pivots(M, r);
    worst = std::max(worst, (acceleration(system, q, v, t) - expected).norm() / (1.0 + expected.norm()));
  }
  return worst;
}

}  // namespace qdot::test
