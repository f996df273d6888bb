// SPDX-License-Identifier: MIT
//
// Lagrange's equations do not care about coordinates: the same T and V in others give the same motion.
#include "catch2_bridge.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <random>

#include "qdot/ad/derivatives.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"
#include "qdot/mechanics/rotation.hpp"
#include "qdot/mechanics/velocity.hpp"
#include "scenes/charged_particle.hpp"
#include "scenes/heavy_top.hpp"
#include "scenes/rod_and_ring.hpp"
#include "systems/shaken_pendulum.hpp"

using namespace qdot;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

// Two linear solves with the coordinates' Jacobian and one with M; condition numbers up to a hundred each.
constexpr double solved = 1e-11;
constexpr int samples = 50;

// A change of coordinates that bends every axis and mixes neighbours: q_i = s_i + 0.2 sin s_{i+1} + 0.01 s_i², invertible
// near the s that belong to the states of the laws.
inline const auto bent = [](const auto& s) {
  using std::sin;
  auto q = s.eval();
  for (Eigen::Index i = 0; i < s.size(); ++i) q[i] = s[i] + 0.2 * sin(s[(i + 1) % s.size()]) + 0.01 * s[i] * s[i];
  return q;
};

// The s with bent(s) = q, by Newton's method.
template <int n>
Vector<double, n> unbent(const Vector<double, n>& q) {
  Vector<double, n> s = q;
  for (int i = 0; i < 50; ++i) {
    const MatrixXd J = qdot::jacobian(bent, s);
    s -= J.partialPivLu().solve(VectorXd(bent(s) - q));
  }
  return s;
}

// T and V of `system` written in the coordinates s.
template <class Energies, int n>
struct InBentCoordinates {
  Energies energies;

  template <class S>
  S T(const Vector<S, n>& s, const Vector<S, n>& sdot, const S& t) const {
    const auto both = value_and_velocity_of(bent, s, sdot);
    return qdot::detail::kinetic<n>(energies, both.value, both.rate, t);
  }
  template <class S>
  S V(const Vector<S, n>& s, const S& t) const {
    return qdot::detail::potential<n>(energies, Vector<S, n>(bent(s)), t);
  }
};

// The worst relative difference of the accelerations of `energies` in its own and in bent coordinates.
template <int n, class Energies>
double difference_in_bent_coordinates(const Energies& energies, const Vector<double, n>& centre) {
  const auto system = mechanical_system<n>(energies);
  const auto other = mechanical_system<n>(InBentCoordinates<Energies, n>{energies});
  std::mt19937 random(30);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  double worst = 0.0;
  for (int sample = 0; sample < samples; ++sample) {
    Vector<double, n> q, v;
    for (int i = 0; i < n; ++i) {
      q[i] = centre[i] + uniform(random);
      v[i] = 4.0 * uniform(random);
    }
    const double t = 2.0 + uniform(random);
    const Vector<double, n> s = unbent<n>(q);
    const Vector<double, n> sdot = MatrixXd(jacobian(bent, s)).partialPivLu().solve(VectorXd(v));
    const Vector<double, n> expected = acceleration(system, q, v, t);
    const Vector<double, n> actual = acceleration_of(bent, s, sdot, acceleration(other, s, sdot, t));
    worst = std::max(worst, (actual - expected).norm() / (1.0 + expected.norm()));
  }
  return worst;
}

// A point in space under gravity and a spring to the origin; the potential needs the position alone.
const auto potential_at = [](const auto& r) {
  return 1.7 * 9.81 * r[2] + 0.5 * 4.2 * (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
};
const auto newton = [](const Vector3d& r) { return Vector3d(-4.2 * r / 1.7 - 9.81 * Vector3d::UnitZ()); };

// The largest departure from Newton's m r̈ = −∇V when the point is described by `position`(q).
template <class Position>
double departure_from_newton(const Position& position, const Vector3d& centre) {
  const auto point = mechanical_system<3>(
      [&](const auto& q, const auto& v) { return 0.5 * 1.7 * velocity_of(position, q, v).squaredNorm(); },
      [&](const auto& q) { return potential_at(position(q)); });
  std::mt19937 random(31);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  double worst = 0.0;
  for (int sample = 0; sample < samples; ++sample) {
    Vector3d q, v;
    for (int i = 0; i < 3; ++i) {
      q[i] = centre[i] + uniform(random);
      v[i] = 4.0 * uniform(random);
    }
    const Vector3d a = acceleration_of(position, q, v, acceleration(point, q, v));
    worst = std::max(worst, (a - newton(position(q))).norm());
  }
  return worst;
}

}  // namespace

TEST_CASE("bent coordinates give the same motion: the rod with the ring") {
  CHECK(difference_in_bent_coordinates<2>(scenes::RodAndRing{}, {0.9, 0.4}) < solved);
}

TEST_CASE("bent coordinates give the same motion: the heavy top") {
  CHECK(difference_in_bent_coordinates<3>(scenes::HeavyTop{}, {1.3, 0.2, -0.4}) < solved);
}

TEST_CASE("bent coordinates give the same motion: a charge in a magnetic field and a field that alternates") {
  CHECK(difference_in_bent_coordinates<2>(scenes::ChargedParticle{}, {0.3, -0.7}) < solved);
}

TEST_CASE("bent coordinates give the same motion: a pendulum whose pivot shakes") {
  CHECK(difference_in_bent_coordinates<1>(systems::ShakenPendulum{}, Vector<double, 1>(0.4)) < solved);
}

TEST_CASE("a material point obeys Newton in Cartesian coordinates") {
  CHECK(departure_from_newton([](const auto& q) { return q.eval(); }, {0.1, 0.2, 0.3}) < solved);
}

TEST_CASE("a material point obeys Newton in cylindrical coordinates") {
  const auto cylindrical = [](const auto& q) {
    using std::cos, std::sin;
    return vector(q[0] * cos(q[1]), q[0] * sin(q[1]), q[2]);
  };
  CHECK(departure_from_newton(cylindrical, {1.2, 0.4, 0.3}) < solved);
}

TEST_CASE("a material point obeys Newton in spherical coordinates") {
  const auto spherical = [](const auto& q) {
    using std::cos, std::sin;
    return vector(q[0] * sin(q[1]) * cos(q[2]), q[0] * sin(q[1]) * sin(q[2]), q[0] * cos(q[1]));
  };
  CHECK(departure_from_newton(spherical, {1.2, 1.1, 0.3}) < solved);
}

TEST_CASE("a material point obeys Newton in parabolic coordinates") {
  const auto parabolic = [](const auto& q) {
    using std::cos, std::sin;
    return vector(q[0] * q[1] * cos(q[2]), q[0] * q[1] * sin(q[2]), 0.5 * (q[0] * q[0] - q[1] * q[1]));
  };
  CHECK(departure_from_newton(parabolic, {1.2, 1.1, 0.3}) < solved);
}

TEST_CASE("a material point obeys Newton with his inertial forces in a turning frame") {
  // coordinates fixed to a table that turns with Ω: x̂̈ = −2 Ω × v − Ω × (Ω × r) + gravity
  const double Omega = 1.4;
  const auto turning = mechanical_system<3>(
      [Omega](const auto& q, const auto& v, const auto& t) {
        const auto position = [Omega](const auto& x, const auto& time) { return (rotation_z(Omega * time) * x).eval(); };
        return 0.5 * velocity_of(position, q, v, t).squaredNorm();
      },
      [](const auto& q) { return 9.81 * q[2]; });
  const Vector3d q(0.4, -0.8, 0.3), v(1.1, 0.6, -0.2), axis(0.0, 0.0, Omega);
  const Vector3d expected = -2.0 * axis.cross(v) - axis.cross(axis.cross(q)) - 9.81 * Vector3d::UnitZ();
  CHECK((acceleration(turning, q, v, 0.7) - expected).norm() < solved);
}

TEST_CASE("a bead on a helix slides as if on an incline: phi'' = -g b/(R^2 + b^2)") {
  const double R = 1.0, b = 0.2;
  const auto helix = [=](const auto& q) {
    using std::cos, std::sin;
    return vector(R * cos(q[0]), R * sin(q[0]), b * q[0]);
  };
  const auto bead = mechanical_system<1>(
      [&](const auto& q, const auto& v) { return 0.5 * velocity_of(helix, q, v).squaredNorm(); },
      [&](const auto& q) { return 9.81 * helix(q)[2]; });
  CHECK_THAT(acceleration(bead, Vector<double, 1>(0.7), Vector<double, 1>(2.0))[0], WithinAbs(-1.88653846153846, solved));
}
