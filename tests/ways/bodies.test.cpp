// SPDX-License-Identifier: MIT
//
// Rigid bodies by the library's own rotations, whose angular velocities are known in closed form, against nested duals, which know nothing but R(q).
#include <algorithm>
#include <array>
#include <random>

#include "catch2_bridge.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene_motion.hpp"
#include "qdot/mechanics/kinematic_system.hpp"
#include "systems/library_rotations.hpp"
#include "systems/solution_by_pivots.hpp"

using namespace qdot;

namespace {

constexpr double rounded = 1e-12;  // of both ways, times the condition of M, which is moderate but near poles

struct States {
  std::mt19937 random{11};
  template <int n>
  Vector<double, n> next(double lowest, double highest) {
    std::uniform_real_distribution<double> number(lowest, highest);
    Vector<double, n> x;
    for (int i = 0; i < n; ++i) x[i] = number(random);
    return x;
  }
};

// The largest difference of a closed form from R on duals: Ω, its slopes W, and W W⁻¹ from 1.
template <class Turn, class Rotation>
double difference_of_closed_form(const Rotation& rotation, double lowest, double highest) {
  constexpr int n = Rotation::n;
  States states;
  double worst = 0.0;
  for (int sample = 0; sample < 20; ++sample) {
    const auto q = states.next<n>(lowest, highest), v = states.next<n>(-1.0, 1.0);
    detail::InverseTurn<double, true> inverse;
    std::array<double, Turn::remembered> from;
    std::copy_n(q.data(), n, from.data());
    if constexpr (Turn::remembered > n) {
      const auto of = detail::stumpff<4>(q.squaredNorm());
      from[3] = of.c1, from[4] = of.c2, from[5] = of.c3, from[6] = of.c4;
    }
    const auto closed_form = [&](const Vector<double, n>& rates) {
      Eigen::Vector3d omega;
      Turn::angular_velocity(from.data(), rates.data(), omega.data(), inverse);
      return omega;
    };
    worst = std::max(worst, (closed_form(v) - body_angular_velocity_of(rotation, q, v)).norm());
    Matrix<double, 3, n> W;
    for (int c = 0; c < n; ++c) {
      const Vector<double, n> unit = Vector<double, n>::Unit(c);
      W.col(c) = closed_form(unit);
      worst = std::max(worst, (W.col(c) - body_angular_velocity_of(rotation, q, unit)).norm());
    }
    const Eigen::Map<const Eigen::Matrix<double, n, 3, Eigen::RowMajor>> V(inverse.entries);
    worst = std::max(worst, (W * V - Eigen::Matrix3d::Identity()).norm());
  }
  return worst;
}
template <int i, int j, int k>
double difference_of_angles() {
  return difference_of_closed_form<detail::EulerTurn<i, j, k>>(ByAngles<i, j, k>{}, 0.3, 1.2);
}

// The largest difference of a scene's acceleration from M q̈ = r + Q + Jᵀλ by nested duals.
template <class Sc>
double difference(const Sc& s, double lowest, double highest) {
  constexpr int n = Sc::dof_at_compile_time;
  States states;
  double worst = 0.0;
  for (int sample = 0; sample < 20; ++sample) {
    const auto q = states.next<n>(lowest, highest), v = states.next<n>(-1.0, 1.0);
    const Matrix<double, n> M = detail::kinetic_hessian<n>(s.system().energies(), q, v, 0.0);
    Vector<double, n> r = detail::lagrange_rhs<n>(s.system().energies(), q, v, 0.0), expected;
    if constexpr (Sc::has_forces) r += effect_forces(s, q, v, EffectStates<Sc>(), 0.0);
    if constexpr (Sc::has_constraints) {
      constexpr int m = Sc::constraints_at_compile_time;
      const auto rows = constraint_rows(s, q, v, 0.0, EffectStates<Sc>());
      const auto both = detail::pivoted_solution(M, rows.J, r.data(), rows.gamma.data(), 0.0, {}, {});
      expected = Eigen::Map<const Vector<double, n>>(both.data());
      const auto solution = constrained_acceleration(s, q, v);
      worst = std::max(worst, (solution.lambda - Eigen::Map<const Vector<double, m>>(both.data() + n)).norm() / (1.0 + expected.norm()));
    } else {
      expected = solution_by_pivots(M, r);
    }
    worst = std::max(worst, (acceleration(s, q, v) - expected).norm() / (1.0 + expected.norm()));
  }
  return worst;
}

// T = ½ Ω·I Ω with all of I, in a potential; the length of a quaternion has an inertia where `lengthens` is not zero.
template <class Rotation, int lengthens = 0>
struct Turning {
  auto T(const auto& q, const auto& v) const {
    const auto w = body_angular_velocity_of(Rotation{}, q, v);
    const auto turning = 0.5 * (1.0 * w[0] * w[0] + 2.0 * w[1] * w[1] + 2.5 * w[2] * w[2]) + 0.2 * w[0] * w[1] - 0.1 * w[1] * w[2];
    if constexpr (lengthens == 0) return turning;
    else if constexpr (lengthens == 1) return turning + 0.5 * q.dot(v) * q.dot(v);
    else return turning + 0.5 * (1.0 + q[1] * q[1]) * v.dot(v);  // an inertia that is none of its length
  }
  auto V(const auto& q) const { return 0.7 * q[0] * q[2]; }
};
template <class Rotation, int lengthens = 0>
auto turning() { return mechanical_system<Rotation::n>(Turning<Rotation, lengthens>{}); }
template <class Rotation>
auto torque() { return torque_on_body(Rotation{}, Eigen::Vector3d(0.3, -0.2, 0.5)); }

// Two functors, stored in vectors of the scalar of T.
struct Mixed {
  template <class S>
  S T(const Vector<S, 3>& q, const Vector<S, 3>& v) const {
    const Vector<S, 3> w = body_angular_velocity_of(ByVector{}, q, v);
    Vector<S, 3> u = 0.5 * body_angular_velocity_of(ByAngles<3, 2, 1>{}, q, v);
    u += w;
    S sum = 0.5 * w.squaredNorm();
    sum += 0.5 * u.dot(w) + 0.1 * body_angular_velocity_of(ByVector{}, q, v)[0] * u[1];
    return sum;
  }
  auto V(const auto& q) const { return 0.3 * q[1]; }
};

const Eigen::Matrix3d tensor = (Eigen::Matrix3d() << 1.0, 0.1, 0.0, 0.1, 2.0, -0.2, 0.0, -0.2, 2.5).finished();

}  // namespace

TEST_CASE("angular velocities of known rotations in closed form are those of R: Euler's twelve sets, vectors, quaternions") {
  CHECK(difference_of_angles<3, 1, 3>() < rounded);
  CHECK(difference_of_angles<3, 2, 3>() < rounded);
  CHECK(difference_of_angles<2, 1, 2>() < rounded);
  CHECK(difference_of_angles<2, 3, 2>() < rounded);
  CHECK(difference_of_angles<1, 2, 1>() < rounded);
  CHECK(difference_of_angles<1, 3, 1>() < rounded);
  CHECK(difference_of_angles<3, 2, 1>() < rounded);
  CHECK(difference_of_angles<3, 1, 2>() < rounded);
  CHECK(difference_of_angles<2, 3, 1>() < rounded);
  CHECK(difference_of_angles<2, 1, 3>() < rounded);
  CHECK(difference_of_angles<1, 2, 3>() < rounded);
  CHECK(difference_of_angles<1, 3, 2>() < rounded);
  CHECK(difference_of_closed_form<detail::QuaternionTurn>(ByQuaternion{}, -1.0, 1.0) < rounded);
  CHECK(difference_of_closed_form<detail::VectorTurn>(ByVector{}, -1.0, 1.0) < rounded);
  CHECK(difference_of_closed_form<detail::VectorTurn>(ByVector{}, 0.1, 0.3) < rounded);
  CHECK(difference_of_closed_form<detail::VectorTurn>(ByVector{}, -1e-9, 1e-9) < rounded);
  CHECK(difference_of_closed_form<detail::VectorTurn>(ByVector{}, 1.5, 2.5) < rounded);
}

TEST_CASE("bodies that turn, free and under torques, move as nested duals say, by T and by where they are") {
  CHECK(difference(scene(turning<ByAngles<3, 1, 3>>()), 0.4, 1.2) < rounded);
  CHECK(difference(scene(turning<ByAngles<3, 2, 1>>(), torque<ByAngles<3, 2, 1>>()), 0.4, 1.2) < rounded);
  CHECK(difference(scene(turning<ByAngles<3, 2, 1>>(), torque<ByAngles<3, 1, 3>>(), torque<ByVector>()), 0.4, 1.2) < rounded);
  CHECK(difference(scene(turning<ByVector>()), -0.2, 0.2) < rounded);
  CHECK(difference(scene(turning<ByVector>(), torque<ByVector>()), -1.2, 1.2) < rounded);
  CHECK(difference(scene(turning<ByQuaternion, 1>()), -1.2, 1.2) < rounded);
  CHECK(difference(scene(turning<ByQuaternion, 1>(), torque<ByQuaternion>()), -1.2, 1.2) < rounded);
  CHECK(difference(scene(turning<ByQuaternion, 2>(), torque<ByQuaternion>()), -1.2, 1.2) < rounded);
  const auto aside = [](const auto& q, auto& bodies) {
    bodies.rigid_body(RigidBody{1.5, {0.1, 0.2, 0.3}, tensor}, vector(q[0], 0.0 * q[0], q[0] * q[1]), ByAngles<3, 1, 3>{}(q));
  };
  CHECK(difference(scene(kinematic_system<3>(aside, gravity_along<2>(-9.81)), torque<ByAngles<3, 1, 3>>()), 0.4, 1.2) < rounded);
  const auto centred = [](const auto& q, auto& bodies) { bodies.rigid_body(1.5, tensor, vector(0.0 * q[0], 0.0 * q[0], 0.0 * q[0]), ByVector{}(q)); };
  CHECK(difference(scene(kinematic_system<3>(centred, [](const auto& q) { return 0.5 * q.squaredNorm(); }), torque<ByVector>()), -1.2, 1.2) < rounded);
}

TEST_CASE("a body that falls and turns moves as nested duals say: six coordinates, and seven with a quaternion of unit length") {
  const auto by_angles = [](const auto& q, auto& bodies) { bodies.rigid_body(1.5, tensor, vector(q[0], q[1], q[2]), euler_rotation_321(q[3], q[4], q[5])); };
  CHECK(difference(scene(kinematic_system<6>(by_angles, uniform_gravity(0.1, 0.2, -9.81))), 0.4, 1.2) < rounded);
  const auto by_quaternion = [](const auto& q, auto& bodies) {
    bodies.rigid_body(1.5, tensor, vector(q[4], q[5], q[6]), rotation_from_quaternion(q.template head<4>().eval()));
  };
  const auto unit = holonomic("unit length", [](const auto& q) { return 0.5 * (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1.0); });
  CHECK(difference(scene(kinematic_system<7>(by_quaternion, uniform_gravity(0.1, 0.2, -9.81)).with_indefinite_mass_matrix(), unit), 0.3, 0.9) < rounded);
}

TEST_CASE("a constraint on the length of a quaternion determines it, its multiplier being what forces there are along it") {
  const auto body = turning<ByQuaternion>().with_indefinite_mass_matrix();
  const auto unit = holonomic("unit length", [](const auto& p) { return 0.5 * (p.squaredNorm() - 1.0); });
  const auto other = holonomic("one entry", [](const auto& p, const auto& t) { return p[0] - 0.3 - 0.1 * t; });
  CHECK(difference(scene(body, unit), 0.3, 0.9) < rounded);
  CHECK(difference(scene(body, unit, torque<ByQuaternion>()), 0.3, 0.9) < rounded);
  CHECK(difference(
            scene(body, other, generalized_force([](const auto& q, const auto& v, const auto&) { return (0.3 * q - 0.2 * v).eval(); })),
            0.3, 0.9) < rounded);
}

TEST_CASE("what T does with angular velocities of several rotations is as nested duals say") {
  CHECK(difference(scene(mechanical_system<3>(Mixed{})), 0.4, 1.2) < rounded);
}

TEST_CASE("near a pole of Euler's angles accelerations keep their digits, and at the pole the direction without inertia is named") {
  const auto system = turning<ByAngles<3, 1, 3>>();
  for (const double nutation : {0.1, 2e-3, 5e-4, 1e-5}) {
    const Vector<double, 3> q(0.3, nutation, 0.7), v(0.4, 0.2, -0.3);
    const Matrix<double, 3> M = detail::kinetic_hessian<3>(system.energies(), q, v, 0.0);
    const Vector<double, 3> r = detail::lagrange_rhs<3>(system.energies(), q, v, 0.0), expected = solution_by_pivots(M, r);
    CHECK((acceleration(system, q, v) - expected).norm() < 1e-15 / (nutation * nutation) * expected.norm());  // the condition of M
  }
  CHECK_THROWS_AS(acceleration(system, Vector<double, 3>(0.3, 0.0, 0.7), Vector<double, 3>(0.4, 0.2, -0.3)), SingularMassMatrix);
}
