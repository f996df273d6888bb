// SPDX-License-Identifier: MIT
//
// Exact derivatives of q̈ against quotients of differences of q̈.
#include "catch2_bridge.hpp"

#include "bench/chain_energies.hpp"
#include "mechanics/difference_from_quotients.hpp"
#include "qdot/mechanics/rigid_body.hpp"
#include "scenes/rod_and_ring.hpp"

using namespace qdot;

namespace {

template <int n>
Vector<double, n> spread(Eigen::Index size, double from, double to) {
  return Vector<double, n>::LinSpaced(size, from, to);
}

// A body about a point of it, by what the library says of its kinetic energy and of its angular velocity.
struct HeldBody {
  RigidBody body{1.0, {0.0, 0.1, 0.5}, Eigen::Vector3d(1.0, 2.0, 2.5).asDiagonal()};
  auto T(const auto& q, const auto& v) const {
    const auto place = [](const auto& x) { return vector(0.2 * x[0], 0.0 * x[0], 0.0 * x[0]); };
    return kinetic_energy_of_body(body, [](const auto& x) { return euler_rotation_313(x[0], x[1], x[2]); }, place, q, v);
  }
  auto V(const auto& q) const {
    using std::cos;
    return 9.81 * cos(q[1]);
  }
};
// Two points in the plane by one functor: four numbers, and no rotation.
struct TwoPoints {
  auto T(const auto& q, const auto& v) const {
    const auto places = [](const auto& x) {
      using std::cos, std::sin;
      return vector(sin(x[0]), -cos(x[0]), sin(x[0]) + sin(x[1]), -cos(x[0]) - cos(x[1]));
    };
    return 0.5 * velocity_of(places, q, v).squaredNorm();
  }
  auto V(const auto& q) const {
    using std::cos;
    return -9.81 * (2.0 * cos(q[0]) + cos(q[1]));
  }
};
struct Turning {
  auto T(const auto& q, const auto& v) const {
    const auto w = body_angular_velocity_of([](const auto& x) { return rotation_from_vector(x); }, q, v);
    return 0.5 * (1.0 * w[0] * w[0] + 2.0 * w[1] * w[1] + 2.5 * w[2] * w[2]);
  }
  auto V(const auto& q) const { return 0.3 * q[0] * q[2]; }
};

}  // namespace

TEST_CASE("derivatives of accelerations are limits of quotients: chains") {
  CHECK(difference_from_quotients(mechanical_system<3>(bench::LoopedChain{}), spread<3>(3, -1.0, 1.2), spread<3>(3, 1.0, -0.7)) < differenced);
}

TEST_CASE("derivatives of accelerations are limits of quotients: bodies that turn") {
  const Vector<double, 3> q(0.9, 0.6, 0.2), v(-0.3, 1.1, 2.0);
  CHECK(difference_from_quotients(mechanical_system<3>(HeldBody{}), q, v) < differenced);
  CHECK(difference_from_quotients(mechanical_system<3>(Turning{}), q, v) < differenced);
}

TEST_CASE("derivatives of accelerations are limits of quotients: points by one functor, and a bar on which a ring slides") {
  const Vector<double, 2> q(0.3, 0.7), v(1.0, -0.5);
  CHECK(difference_from_quotients(mechanical_system<2>(TwoPoints{}), q, v) < differenced);
  CHECK(difference_from_quotients(mechanical_system<2>(scenes::RodAndRing{}), q, v) < differenced);
}

TEST_CASE("derivatives of accelerations are limits of quotients: sizes known at run time, within the limit of the records and beyond") {
  for (const Eigen::Index n : {2, 7, 33})
    CHECK(difference_from_quotients(mechanical_system(n, bench::LoopedChain{}), spread<Dynamic>(n, -1.0, 1.2), spread<Dynamic>(n, 1.0, -0.7)) <
          differenced);
}

TEST_CASE("derivatives of accelerations are limits of quotients: energies of several formulas, sizes known at run time") {
  const auto stops = mechanical_system(Eigen::Index(2), [](const auto& v) { return 0.5 * v.dot(v); },
                                       [](const auto& q) {
                                         using std::max;
                                         const auto into_stop = max(q[0] - 0.5, 0.0 * q[0]);
                                         return 20.0 * into_stop * into_stop * into_stop + q[0] * q[1];
                                       });
  for (const double x : {0.2, 0.9})
    CHECK(difference_from_quotients(stops, Vector<double, Dynamic>{{x, -0.4}}, Vector<double, Dynamic>{{0.9, 0.5}}) < differenced);
}

TEST_CASE("derivatives of accelerations are limits of quotients: indefinite mass matrices") {
  const auto exchanged = mechanical_system<2>([](const auto& q, const auto& v) { return (1.0 + q[0] * q[0]) * v[0] * v[1]; },
                                              [](const auto& q) { return sin(q[0]) * q[1]; })
                             .with_indefinite_mass_matrix();
  const Vector<double, 2> q(0.6, -0.4), v(0.9, 0.5);
  CHECK(difference_from_quotients(exchanged, q, v) < differenced);
}

TEST_CASE("derivatives of accelerations do not exist where the mass matrix is singular") {
  const auto s = mechanical_system<2>([](const auto& v) { return 0.5 * (v[0] + v[1]) * (v[0] + v[1]); });
  CHECK_THROWS_AS(acceleration_jacobian(s, Vector<double, 2>(0, 0), Vector<double, 2>(0, 0)), SingularMassMatrix);
}
