// SPDX-License-Identifier: MIT
#include "../catch2_bridge.hpp"

#include <cmath>
#include <random>

#include "bench/chain_energies.hpp"
#include "bench/hand_derived.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene_form.hpp"
#include "qdot/mechanics/kinematic_system.hpp"
#include "systems/chain_by_loops.hpp"
#include "systems/solution_by_pivots.hpp"

using namespace qdot;

namespace {

// Rounding of both ways, times the condition of M.
constexpr double rounded = 1e-12;

// Largest relative difference of q̈ to `other(q, qdot, t)` over random states.
template <int n, class E, Inertia I, class Other>
double difference(const System<E, n, I>& system, const Other& other, double low = -2.0, double high = 2.0) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> position(low, high), velocity(-2.0, 2.0);
  double worst = 0.0;
  for (int sample = 0; sample < 20; ++sample) {
    Vector<double, n> q(system.dof()), v(system.dof());
    for (Eigen::Index i = 0; i < system.dof(); ++i) {
      q[i] = position(random);
      v[i] = velocity(random);
    }
    const double t = position(random);
    const Vector<double, n> expected = other(q, v, t), a = acceleration(system, q, v, t);
    worst = std::max(worst, (a - expected).norm() / (1.0 + expected.norm()));
  }
  return worst;
}

template <int n, class Hand>
auto by_hand(const Hand& hand) {
  return [hand](const Vector<double, n>& q, const Vector<double, n>& v, double) {
    Vector<double, n> a;
    hand(q.data(), v.data(), a.data());
    return a;
  };
}

// What T and V of one object give, the general way.
template <int n, class E>
auto by_energies(const E& energies) {
  return [system = mechanical_system<n>(energies)](const Vector<double, n>& q, const Vector<double, n>& v, double t) {
    return solution_by_pivots(mass_matrix(system, q, v, t), rhs(system, q, v, t));
  };
}

constexpr auto free_fall = 9.81;

TEST_CASE("a chain of masses accelerates as derived by hand, whether its positions are straight-line code or a loop") {
  const auto down = uniform_gravity(0.0, -free_fall);
  CHECK(difference(kinematic_system<2>(bench::UnrolledPositions<2>{}, down), by_hand<2>(bench::short_chain_by_hand<2>)) < rounded);
  CHECK(difference(kinematic_system(12, bench::LoopedPositions{}, down),
                   [](const auto& q, const auto& v, double) { return chain_by_loops(q, v); }) < 10 * rounded);
}

// A body on a point that is at rest, given by plain numbers, beside the same point on numbers that could move; and places that are products of matrices.
TEST_CASE("plain numbers and products are places and rotations as well") {
  const RigidBody top{1.5, Eigen::Vector3d(0.0, 0.1, 0.4), Eigen::Matrix3d(Eigen::Vector3d(0.6, 0.7, 0.3).asDiagonal())};
  const auto down = uniform_gravity(0.0, 0.0, -free_fall);
  const auto moving = kinematic_system<3>([=](const auto& q, auto& bodies) {
    bodies.rigid_body(top, vector(0.0 * q[0], 0.0 * q[0], 0.0 * q[0]), euler_rotation_313(q[0], q[1], q[2]));
  }, down);
  const auto as_moving = [&](const auto& q, const auto& v, double) { return acceleration(moving, q, v); };
  const auto at_rest = kinematic_system<3>([=](const auto& q, auto& bodies) {
    bodies.rigid_body(top, Eigen::Vector3d::Zero(), euler_rotation_313(q[0], q[1], q[2]));
  }, down);
  CHECK(difference(at_rest, as_moving, 0.3, 1.2) < rounded);
  const auto by_product = kinematic_system<3>([=](const auto& q, auto& bodies) {
    bodies.rigid_body(top, vector(0.0, 0.0, 0.0), rotation_z(q[0]) * rotation_x(q[1]) * rotation_z(q[2]));
  }, down);
  CHECK(difference(by_product, as_moving, 0.3, 1.2) < rounded);
  const auto arm = [](double length) {
    return kinematic_system<2>([=](const auto& q, auto& bodies) {
      using S = std::remove_cvref_t<decltype(q[0])>;
      bodies.point_mass(1.0, planar_rotation(q[0]) * Vector<S, 2>(S(length), q[1]));
      bodies.rigid_body(1.0, Eigen::Matrix3d(Eigen::Matrix3d::Identity()), vector(q[1], 0.0, 0.0), Eigen::Matrix3d(Eigen::Matrix3d::Identity()));
    });
  };
  // r = R(φ) (l, s), and a mass on the axis: T = ½ (l² + s²) φ̇² + l φ̇ ṡ + ½ ṡ² + ½ ṡ²
  CHECK(difference(arm(0.7), [](const auto& q, const auto& v, double) {
          const double l = 0.7, s = q[1];
          const Eigen::Matrix2d M = (Eigen::Matrix2d() << l * l + s * s, l, l, 2.0).finished();
          return Eigen::Vector2d(M.llt().solve(Eigen::Vector2d(-2.0 * s * v[1] * v[0], s * v[0] * v[0])));
        }) < rounded);
}

TEST_CASE("a rod with a sliding ring, a body and a mass, accelerates as derived by hand") {
  const double M = 2.0, L = 1.5, m = 0.3;
  const auto place = [=](const auto& q, auto& bodies) {
    using std::cos, std::sin;
    const auto along = vector(cos(q[1]), sin(q[1]));
    bodies.planar_body(M, M * L * L / 12.0, vector(0.5 * L * along[0], 0.5 * L * along[1]), q[1]);
    bodies.point_mass(m, vector(q[0] * along[0], q[0] * along[1]));
  };
  CHECK(difference(kinematic_system<2>(place, uniform_gravity(0.0, -free_fall)), by_hand<2>(bench::RodAndRingByHand{}), 0.3, 1.2) < rounded);
}

TEST_CASE("gravity along an axis is uniform gravity") {
  const Vector<double, 2> q{0.4, 1.1}, v{0.2, -0.3};
  CHECK(acceleration(kinematic_system<2>(bench::LoopedPositions{}, gravity_along<1>(-9.81)), q, v) ==
        acceleration(kinematic_system<2>(bench::LoopedPositions{}, uniform_gravity(0.0, -9.81)), q, v));
}

TEST_CASE("a spherical pendulum is one mass in three dimensions") {
  const auto place = [](const auto& q, auto& bodies) {
    using std::cos, std::sin;
    bodies.point_mass(0.4, vector(sin(q[0]) * cos(q[1]), sin(q[0]) * sin(q[1]), -cos(q[0])));
  };
  CHECK(difference(kinematic_system<2>(place, uniform_gravity(0.0, 0.0, -free_fall)), by_hand<2>(bench::SphericalPendulumByHand{}), 0.3, 1.2) < rounded);
}

TEST_CASE("a heavy top by Euler's angles accelerates as derived by hand") {
  const double m = 1.0, l = 0.2, A = 1.0, C = 0.7;  // A about the tip
  const Eigen::Matrix3d about_centre = Eigen::Vector3d(A - m * l * l, A - m * l * l, C).asDiagonal();
  const auto down = uniform_gravity(0.0, 0.0, -free_fall);
  const auto rotation = [](const auto& q) { return euler_rotation_313(q[1], q[0], q[2]); };
  const auto by_centre = [=](const auto& q, auto& bodies) {
    const auto R = rotation(q);
    bodies.rigid_body(m, about_centre, vector(l * R(0, 2), l * R(1, 2), l * R(2, 2)), R);
  };
  CHECK(difference(kinematic_system<3>(by_centre, down), by_hand<3>(bench::HeavyTopByHand{}), 0.3, 1.2) < rounded);
}

// A free body by a quaternion of any length, whose length has an inertia of its own: a term that no body makes.
const RigidBody asymmetric{1.3, {0.1, -0.2, 0.3}, Eigen::Vector3d(2.0, 3.0, 4.0).asDiagonal()};
struct LengthOfQuaternion {
  auto operator()(const auto& q, const auto& qdot) const {
    const auto rate = q[0] * qdot[0] + q[1] * qdot[1] + q[2] * qdot[2] + q[3] * qdot[3];
    return 0.5 * rate * rate;
  }
};
struct QuaternionBody {
  template <class S>
  S T(const Vector<S, 4>& q, const Vector<S, 4>& qdot) const {
    const auto rotation = [](const auto& p) { return rotation_from_quaternion(p); };
    const auto still = [](const auto& p) { return vector(0.0 * p[0], 0.0 * p[0], 0.0 * p[0]); };
    return kinetic_energy_of_body(asymmetric, rotation, still, q, qdot) + LengthOfQuaternion{}(q, qdot);
  }
  template <class S>
  S V(const Vector<S, 4>& q) const {
    const Matrix<S, 3> R = rotation_from_quaternion(q);
    return free_fall * asymmetric.mass * (0.1 * R(2, 0) - 0.2 * R(2, 1) + 0.3 * R(2, 2));
  }
};

TEST_CASE("a body by a quaternion, with a kinetic term of its own, accelerates as with T and V written out") {
  const auto place = [](const auto& q, auto& bodies) {
    bodies.rigid_body(asymmetric, vector(0.0 * q[0], 0.0 * q[0], 0.0 * q[0]), rotation_from_quaternion(q));
  };
  const auto body = kinematic_system<4>(place, uniform_gravity(0.0, 0.0, -free_fall), LengthOfQuaternion{});
  CHECK(difference(body, by_energies<4>(QuaternionBody{}), 0.3, 1.2) < rounded);
}

// Two bars, the second on the end of the first.
struct TwoBars {
  double m = 0.7, l = 1.3, I = 0.2;
  auto T(const auto& q, const auto& v) const {
    using std::cos;
    return 0.5 * ((0.25 * m * l * l + I + m * l * l) * v[0] * v[0] + (0.25 * m * l * l + I) * v[1] * v[1] +
                  m * l * l * cos(q[0] - q[1]) * v[0] * v[1]);
  }
  auto V(const auto& q) const {
    using std::cos;
    return -m * free_fall * l * (1.5 * cos(q[0]) + 0.5 * cos(q[1]));
  }
};

TEST_CASE("a pendulum on a pivot that is moved accelerates as in the frame of the pivot") {
  // x = X(t) + l sin q: q̈ = −(g + Ÿ)/l sin q − Ẍ/l cos q
  const double l = 0.8, w = 3.0, a = 0.3, b = 0.2;
  const auto place = [=](const auto& q, const auto& t, auto& bodies) {
    using std::cos, std::sin;
    bodies.point_mass(1.7, vector(a * sin(w * t) + l * sin(q[0]), b * cos(w * t) - l * cos(q[0])));
  };
  const auto system = kinematic_system<1>(place, uniform_gravity(0.0, -free_fall));
  static_assert(!decltype(system)::autonomous);
  CHECK(difference(system, [=](const auto& q, const auto&, double t) {
          const double X = -a * w * w * std::sin(w * t), Y = -b * w * w * std::cos(w * t);
          return Vector<double, 1>(-((free_fall + Y) * std::sin(q[0]) + X * std::cos(q[0])) / l);
        }) < rounded);
}

TEST_CASE("two bars as bodies move as with T and V written out, and have energies, momenta, names, Jacobians and effects") {
  const TwoBars b;
  const auto system = kinematic_system<2>([=](const auto& q, auto& bodies) {
    using std::cos, std::sin;
    const auto x1 = 0.5 * b.l * sin(q[0]), y1 = -0.5 * b.l * cos(q[0]);
    bodies.planar_body(b.m, b.I, vector(x1, y1), q[0]);
    bodies.planar_body(b.m, b.I, vector(2.0 * x1 + 0.5 * b.l * sin(q[1]), 2.0 * y1 - 0.5 * b.l * cos(q[1])), q[1]);
  }, [=](const auto& q) { return b.V(q); }).with_names({"alpha", "beta"});
  const auto written = mechanical_system<2>(b);
  CHECK(difference(system, by_energies<2>(b)) < rounded);
  const Eigen::Vector2d q(0.4, -1.1), v(0.7, 1.9);
  CHECK(system.velocity_name(1) == "betadot");
  CHECK_THAT(energy(system, q, v), WithinAbs(energy(written, q, v), 10 * rounded));
  CHECK((conjugate_momenta(system, q, v) - conjugate_momenta(written, q, v)).norm() < rounded);
  CHECK((mass_matrix(system, q, v) - mass_matrix(written, q, v)).norm() < rounded);
  CHECK((rhs(system, q, v) - rhs(written, q, v)).norm() < 10 * rounded);
  const auto J = acceleration_jacobian(system, q, v), J_written = acceleration_jacobian(written, q, v);
  CHECK((J.d_q - J_written.d_q).norm() < 100 * rounded);
  CHECK((J.d_qdot - J_written.d_qdot).norm() < 100 * rounded);
  const auto push = generalized_force([](const auto& x, const auto& u) { return vector(2.0 - 0.3 * u[0], 0.1 * x[0]); });
  CHECK((acceleration(scene(system, push), q, v) - acceleration(scene(written, push), q, v)).norm() < 10 * rounded);
}

TEST_CASE("a kinematic system without inertia in some direction says so") {
  const auto system = kinematic_system<2>([](const auto& q, auto& bodies) { bodies.point_mass(1.0, vector(q[0] + q[1])); });
  CHECK_THROWS_AS(acceleration(system, Eigen::Vector2d(1, 2), Eigen::Vector2d(3, 4)), SingularMassMatrix);
}

TEST_CASE("a position of more than three entries is refused, where its size is known at run time, too") {
  const auto system = kinematic_system<2>([](const auto& q, auto& bodies) {
    using S = std::decay_t<decltype(q[0])>;
    bodies.point_mass(1.0, Vector<S, Dynamic>(Vector<S, Dynamic>::Constant(4, q[0] + 2.0 * q[1])));
  }, uniform_gravity(0.0, -9.81));
  CHECK_THROWS_AS(acceleration(system, Eigen::Vector2d(1, 2), Eigen::Vector2d(3, 4)), InvalidValue);
}

// By Koenig, from where G is.
struct MovedByItsCentre {
  auto T(const auto& q, const auto& v) const {
    const auto turn = [](const auto& x) { return euler_rotation_321(x[0], x[1], x[2]); };
    const auto centre = [&](const auto& x) {
      const auto R = turn(x);
      const auto along = [&](int i) { return R(i, 0) * asymmetric.centre[0] + R(i, 1) * asymmetric.centre[1] + R(i, 2) * asymmetric.centre[2]; };
      return vector(x[3] + along(0), x[4] + along(1), x[5] * x[5] + along(2));
    };
    const Eigen::Matrix3d I_G = inertia_at_centre(asymmetric.inertia, asymmetric.mass, asymmetric.centre);
    return kinetic_energy_about_centre(asymmetric.mass, I_G, velocity_of(centre, q, v), body_angular_velocity_of(turn, q, v));
  }
  auto V(const auto& q) const { return 0.0 * q[0]; }
};

TEST_CASE("a body off its centre, whose reference point moves, has the kinetic energy of its centre of mass") {
  const auto system = kinematic_system<6>([](const auto& q, auto& bodies) {
    bodies.rigid_body(asymmetric, vector(q[3], q[4], q[5] * q[5]), euler_rotation_321(q[0], q[1], q[2]));
  });
  const auto by_centre = mechanical_system<6>(MovedByItsCentre{});
  const Vector<double, 6> q = Vector<double, 6>::LinSpaced(0.3, 1.2), v = Vector<double, 6>::LinSpaced(-0.8, 0.9);
  CHECK(kinetic_energy(system, q, v) == Approx(kinetic_energy(by_centre, q, v)).epsilon(rounded));
  CHECK((acceleration(system, q, v) - acceleration(by_centre, q, v)).norm() < 100 * rounded);
}

}  // namespace
