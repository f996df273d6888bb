// SPDX-License-Identifier: MIT
//
// Velocities inside T, against nested duals, which differentiate the whole of T twice: bodies and chains.
#include "qdot/mechanics/velocity.hpp"

#include "catch2_bridge.hpp"
#include "qdot/mechanics/rigid_body.hpp"
#include "systems/velocities_in_T.hpp"

using namespace qdot;
using test::difference, test::Turning;

namespace {

constexpr double rounded = 1e-12;  // times the condition of M, which is moderate

// The same, by a matrix whose rows lie together: what a functor returns may be stored in either way.
struct TurningByRows : Turning {
  auto T(const auto& p, const auto& v) const {
    const auto rotation = [](const auto& x) { return rotation_from_quaternion(x).transpose().eval(); };
    const auto w = body_angular_velocity_of(rotation, p, v), of_space = angular_velocity_of(rotation, p, v);
    const auto d = p[0] * v[0] + p[1] * v[1] + p[2] * v[2] + p[3] * v[3];
    return 0.5 * (1.0 * w[0] * w[0] + 2.0 * w[1] * w[1] + 2.5 * w[2] * w[2] + d * d + 0.3 * of_space[0] * of_space[0]);
  }
};
struct RateByRows : Turning {
  auto T(const auto& p, const auto& v) const {
    const auto Rdot = velocity_of([](const auto& x) { return rotation_from_quaternion(x).transpose().eval(); }, p, v);
    const auto d = p[0] * v[0] + p[1] * v[1] + p[2] * v[2] + p[3] * v[3];
    return 0.5 * (Rdot.row(0).squaredNorm() + 2.0 * Rdot.row(1).squaredNorm() + 3.0 * Rdot.row(2).squaredNorm() + d * d);
  }
};

// A body seen from a point that is not its centre of mass, and moves.
struct HeldAside : Turning {
  RigidBody body{1.5, {0.1, 0.2, 0.3}, Eigen::Vector3d(1.0, 2.0, 2.5).asDiagonal()};
  auto T(const auto& p, const auto& v) const {
    const auto rotation = [](const auto& x) { return rotation_from_quaternion(x).transpose().eval(); };
    const auto place = [](const auto& x) { return vector(0.5 * x[0] * x[1], x[2], 0.3 * x[3]); };
    const auto d = p[0] * v[0] + p[1] * v[1] + p[2] * v[2] + p[3] * v[3];
    return kinetic_energy_of_body(body, rotation, place, p, v) + 0.5 * d * d;
  }
};

// A chain by loops, from where its points are; the first one is moved.
struct LoopedChain {
  auto T(const auto& q, const auto& v, const auto& t) const {
    auto sum = 0.05 * v.squaredNorm();
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      const auto place = [k](const auto& x, const auto& s) {
        using std::cos, std::sin;
        auto X = 0.2 * sin(s), Y = 0.0 * s;
        for (Eigen::Index i = 0; i <= k; ++i) {
          X += sin(x[i]);
          Y -= cos(x[i]);
        }
        return vector(X, Y);
      };
      sum += 0.5 * velocity_of(place, q, v, t).squaredNorm();
    }
    return sum;
  }
  auto V(const auto& q) const { return 0.5 * q.squaredNorm(); }
};

}  // namespace

TEST_CASE("a rotation may be stored by rows or by columns") {
  CHECK(difference<4>(TurningByRows{}) < rounded);
  CHECK(difference<4>(RateByRows{}) < rounded);
}

TEST_CASE("the kinetic energy of a body may be seen from a moving point") {
  CHECK(difference<4>(HeldAside{}) < rounded);
}

TEST_CASE("velocities in the T of a chain by loops are what they are, for any number of links") {
  CHECK(difference<Dynamic>(LoopedChain{}, 3) < rounded);
  CHECK(difference<Dynamic>(LoopedChain{}, 9) < rounded);
}
