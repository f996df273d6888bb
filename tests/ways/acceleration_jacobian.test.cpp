// SPDX-License-Identifier: MIT
//
// Exact derivatives of q̈ as straight-line code, which exists only with the optimizer on, against quotients of differences.
#include "catch2_bridge.hpp"

#include <algorithm>

#include "bench/chain_energies.hpp"
#include "qdot/mechanics/acceleration_jacobian.hpp"
#include "qdot/mechanics/rigid_body.hpp"
#include "scenes/heavy_top.hpp"
#include "scenes/rod_and_ring.hpp"

using namespace qdot;

namespace {

// Central differences with h = 1e-5 leave h² times a third derivative, and rounding over h.
constexpr double differenced = 1e-7;

template <int n, class E>
double difference_from_quotients(const E& energies, const Vector<double, n>& q, const Vector<double, n>& v) {
  using V = Vector<double, n>;
  constexpr double h = 1e-5;
  const auto system = mechanical_system<n>(energies);
  const auto J = acceleration_jacobian(system, q, v);
  const double scale = 1.0 + J.d_q.cwiseAbs().maxCoeff() + J.d_qdot.cwiseAbs().maxCoeff();
  double worst = (J.qddot - acceleration(system, q, v)).norm() / scale;
  for (int j = 0; j < n; ++j) {
    const V step = h * V::Unit(j);
    const V of_q = (acceleration(system, V(q + step), v) - acceleration(system, V(q - step), v)) / (2.0 * h);
    const V of_v = (acceleration(system, q, V(v + step)) - acceleration(system, q, V(v - step))) / (2.0 * h);
    worst = std::max(worst, (J.d_q.col(j) - of_q).cwiseAbs().maxCoeff() / scale);
    worst = std::max(worst, (J.d_qdot.col(j) - of_v).cwiseAbs().maxCoeff() / scale);
  }
  return worst;
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

TEST_CASE("derivatives of accelerations in straight-line code are limits of quotients") {
  CHECK(difference_from_quotients<2>(scenes::RodAndRing{}, {0.9, 0.4}, {-0.3, 1.1}) < differenced);
  CHECK(difference_from_quotients<3>(scenes::HeavyTop{}, {0.9, 0.4, 0.2}, {-0.3, 1.1, 5.0}) < differenced);
  CHECK(difference_from_quotients<2>(bench::UnrolledChain<2>{}, {0.9, 0.4}, {-0.3, 1.1}) < differenced);
  CHECK(difference_from_quotients<3>(bench::LoopedChain{}, {0.9, 0.4, -0.5}, {-0.3, 1.1, 0.7}) < differenced);
}

TEST_CASE("derivatives of accelerations of bodies that turn are limits of quotients") {
  CHECK(difference_from_quotients<3>(HeldBody{}, {0.9, 0.6, 0.2}, {-0.3, 1.1, 2.0}) < differenced);
  CHECK(difference_from_quotients<3>(Turning{}, {0.9, 0.6, 0.2}, {-0.3, 1.1, 2.0}) < differenced);
}

TEST_CASE("what the straight line takes of velocities it takes whole, and of rotations nothing") {
  const auto takes = []<int n, class E>(const E& energies, const Vector<double, n>& q, const Vector<double, n>& v) {
    Vector<double, n> a;
    Matrix<double, n> d_q, d_v;
    return detail::straight_line_jacobian<n>(energies, q.data(), v.data(), 0.0, a.data(), d_q.data(), d_v.data());
  };
  const bool sees_through = detail::straight_line_pays && !detail::remembers_loops;  // g++, optimizing
  CHECK((takes(TwoPoints{}, Vector<double, 2>(0.3, 0.7), Vector<double, 2>(1.0, -0.5)) || !sees_through));
  CHECK_FALSE(takes(HeldBody{}, Vector<double, 3>(0.9, 0.6, 0.2), Vector<double, 3>(-0.3, 1.1, 2.0)));
  CHECK(difference_from_quotients<2>(TwoPoints{}, {0.3, 0.7}, {1.0, -0.5}) < differenced);
}
