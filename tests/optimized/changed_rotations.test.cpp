// SPDX-License-Identifier: MIT
//
// Rotations of which the compiler must see that they are not what they were made from, or not the same: against nested duals, which look at R(q) alone.
#include <algorithm>
#include <random>

#include "catch2_bridge.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene_motion.hpp"
#include "qdot/mechanics/kinematic_system.hpp"
#include "systems/solution_by_pivots.hpp"

using namespace qdot;

namespace {

constexpr double rounded = 1e-12;  // of both ways, times the condition of M, which is moderate

// A matrix by the library's words to which somebody has written afterwards.
struct ByOtherAxes {
  auto operator()(const auto& q) const {
    auto R = euler_rotation_313(q[0], q[1], q[2]);
    for (int i = 0; i < 3; ++i) {
      const auto x = R(i, 0);
      R(i, 0) = R(i, 1);
      R(i, 1) = x;
      R(i, 2) = -R(i, 2);
    }
    return R;
  }
};

struct Turning {
  auto T(const auto& q, const auto& v) const {
    const auto w = body_angular_velocity_of(ByOtherAxes{}, q, v);
    return 0.5 * (1.0 * w[0] * w[0] + 2.0 * w[1] * w[1] + 2.5 * w[2] * w[2]);
  }
  auto V(const auto& q) const { return 0.7 * q[0] * q[2]; }
};

// A gimbal and a rotor in it, both by the same functor with another capture, and a T that is no quadratic form of Ω.
struct Gimbal {
  struct Inclined {
    double by;
    auto operator()(const auto& q) const { return euler_rotation_313(q[0], q[1], by * q[2]); }
  };
  auto T(const auto& q, const auto& v) const {
    using std::cos;
    const auto w = body_angular_velocity_of(Inclined{1.0}, q, v), u = body_angular_velocity_of(Inclined{0.5}, q, v);
    return 0.5 * (w.dot(w) + 2.0 * u[2] * u[2] + 0.3 * u[0] * w[0]) + (2.0 - cos(w[1])) * 0.2 + 0.1 * v[1] * w[0] * q[0];
  }
  auto V(const auto& q) const { return 0.3 * q[1]; }
};
template <class Sc>
double difference(const Sc& s) {
  constexpr int n = Sc::dof_at_compile_time;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> position(0.4, 1.2), velocity(-1.0, 1.0);
  double worst = 0.0;
  for (int sample = 0; sample < 20; ++sample) {
    Vector<double, n> q, v;
    for (int i = 0; i < n; ++i) {
      q[i] = position(random);
      v[i] = velocity(random);
    }
    const Matrix<double, n> M = detail::kinetic_hessian<n>(s.system().energies(), q, v, 0.0);
    Vector<double, n> r = detail::lagrange_rhs<n>(s.system().energies(), q, v, 0.0);
    if constexpr (Sc::has_forces) r += effect_forces(s, q, v, EffectStates<Sc>(), 0.0);
    const Vector<double, n> expected = solution_by_pivots(M, r);
    worst = std::max(worst, (acceleration(s, q, v) - expected).norm() / (1.0 + expected.norm()));
  }
  return worst;
}

}  // namespace

TEST_CASE("a rotation to which somebody has written is what it has become, and not what it was made from") {
  const auto torque = torque_on_body(ByOtherAxes{}, Eigen::Vector3d(0.3, -0.2, 0.5));
  CHECK(difference(scene(mechanical_system<3>(Turning{}), torque)) < rounded);
  const auto placed = [](const auto& q, auto& bodies) {
    bodies.rigid_body(1.5, Eigen::Vector3d(1.0, 2.0, 2.5).asDiagonal().toDenseMatrix(), vector(q[0], q[1], q[2]), ByOtherAxes{}(q));
  };
  CHECK(difference(scene(kinematic_system<3>(placed), torque)) < rounded);
}

TEST_CASE("angular velocities by one functor with several captures are those of several rotations") {
  CHECK(difference(scene(mechanical_system<3>(Gimbal{}))) < rounded);
}
