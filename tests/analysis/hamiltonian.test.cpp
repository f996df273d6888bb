// SPDX-License-Identifier: MIT
#include "catch2_bridge.hpp"

#include <cmath>

#include "qdot/analysis/hamiltonian.hpp"
#include "scenes/heavy_top.hpp"

using namespace qdot;
using Eigen::Vector3d;
using Catch::Matchers::StartsWith;

namespace {

constexpr double rounding = 1e-13;

// A mass of 2 in space, attracted by the origin with mu = 3.
struct Kepler {
  double m = 2.0, mu = 3.0;
  auto T(const auto& v) const { return 0.5 * m * v.squaredNorm(); }
  auto V(const auto& q) const {
    using std::sqrt;
    return -mu / sqrt(q.squaredNorm());
  }
};

// Components of L = r × p and of the Laplace–Runge–Lenz vector A = p × L − m mu r/|r|.
struct AngularMomentum {
  int i;
  auto operator()(const auto& q, const auto& p) const { return q[(i + 1) % 3] * p[(i + 2) % 3] - q[(i + 2) % 3] * p[(i + 1) % 3]; }
};
struct Lenz {
  int i;
  auto operator()(const auto& q, const auto& p) const {
    using std::sqrt;
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    return p[j] * AngularMomentum{k}(q, p) - p[k] * AngularMomentum{j}(q, p) - 6.0 * q[i] / sqrt(q.squaredNorm());
  }
};
struct Coordinate {
  int i;
  auto operator()(const auto& q, const auto&) const { return q[i]; }
};
struct Momentum {
  int i;
  auto operator()(const auto&, const auto& p) const { return p[i]; }
};

// L = −m c² √(1 − v²/c²) − V with m = c = 1: p = v/√(1 − v²), H = √(1 + p²) + V.
struct Relativistic {
  auto T(const auto& v) const {
    using std::sqrt;
    return -sqrt(1.0 - v[0] * v[0]);
  }
  auto V(const auto& q) const { return 0.5 * q[0] * q[0]; }
};

const Vector3d q(0.4, -0.9, 1.2), p(1.1, 0.3, -0.7);

}  // namespace

TEST_CASE("{q_i, p_j} is 1 for i = j and 0 otherwise, and so are {q, q} and {p, p}") {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      CHECK(poisson_bracket(Coordinate{i}, Momentum{j}, q, p) == (i == j ? 1.0 : 0.0));
      CHECK(poisson_bracket(Coordinate{i}, Coordinate{j}, q, p) == 0.0);
      CHECK(poisson_bracket(Momentum{i}, Momentum{j}, q, p) == 0.0);
    }
}

TEST_CASE("the Laplace-Runge-Lenz vector turns like a vector, is conserved, and {A_x, A_y} = -2 m H L_z") {
  const auto system = mechanical_system<3>(Kepler{});
  const auto H = hamiltonian_of(system);
  const double energy = p.squaredNorm() / 4.0 - 3.0 / q.norm();
  CHECK_THAT(hamiltonian(system, q, p), WithinRel(energy, rounding));
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    CHECK_THAT(poisson_bracket(AngularMomentum{i}, Lenz{i}, q, p), WithinAbs(0.0, rounding));
    CHECK_THAT(poisson_bracket(AngularMomentum{i}, Lenz{j}, q, p), WithinAbs(Lenz{k}(q, p), rounding));
    CHECK_THAT(poisson_bracket(AngularMomentum{j}, Lenz{i}, q, p), WithinAbs(-Lenz{k}(q, p), rounding));
    CHECK_THAT(poisson_bracket(Lenz{i}, Lenz{j}, q, p), WithinAbs(-4.0 * energy * AngularMomentum{k}(q, p), 10.0 * rounding));
    CHECK_THAT(poisson_bracket(Lenz{i}, H, q, p), WithinAbs(0.0, rounding));
  }
}

TEST_CASE("H of a heavy top and Hamilton's equations are those of the textbook") {
  const scenes::HeavyTop top;
  const auto system = mechanical_system<3>(top);
  const Vector3d at(0.6, 0.2, -0.4), momenta(0.3, 4.1, 5.2);
  const double c = std::cos(at[0]), s = std::sin(at[0]), d = momenta[1] - momenta[2] * c;
  CHECK_THAT(hamiltonian(system, at, momenta),
             WithinRel(0.5 * 0.09 / top.I1 + 0.5 * d * d / (top.I1 * s * s) + 0.5 * 5.2 * 5.2 / top.I3 + top.m * top.g * top.l * c, rounding));
  const auto rates = phase_velocity(system, at, momenta);
  CHECK_THAT(rates.qdot[0], WithinRel(0.3 / top.I1, rounding));
  CHECK_THAT(rates.qdot[1], WithinRel(d / (top.I1 * s * s), rounding));
  CHECK_THAT(rates.qdot[2], WithinRel(momenta[2] / top.I3 - c * d / (top.I1 * s * s), rounding));
  CHECK_THAT(rates.pdot[0], WithinRel(d * d * c / (top.I1 * s * s * s) - d * momenta[2] / (top.I1 * s) + top.m * top.g * top.l * s, 10.0 * rounding));
  CHECK_THAT(rates.pdot[1], WithinAbs(0.0, rounding));
  CHECK_THAT(rates.pdot[2], WithinAbs(0.0, rounding));
}

TEST_CASE("momenta that are not linear in the velocities are solved for them, and H can be differentiated twice") {
  const auto system = mechanical_system<1>(Relativistic{});
  const Vector<double, 1> x(0.3), fast(30.0);
  CHECK_THAT(velocities_of_momenta(system, x, fast)[0], WithinRel(30.0 / std::sqrt(901.0), rounding));
  const Vector<double, 1> slow(0.75);  // v = 0.6
  CHECK_THAT(hamiltonian(system, x, slow), WithinRel(1.25 + 0.045, rounding));
  // ∂²H/∂p² = (1 + p²)^(−3/2)
  const auto curvature = hessian([&](const auto& y) {
    using S = typename std::remove_cvref_t<decltype(y)>::Scalar;
    return hamiltonian(system, Vector<S, 1>(S(0.3)), y);
  }, slow);
  CHECK_THAT(curvature(0, 0), WithinRel(1.0 / (1.25 * 1.25 * 1.25), 10.0 * rounding));
  CHECK_THROWS_WITH(velocities_of_momenta(system, x, Vector<double, 1>(1e12)), StartsWith("there must be a velocity with the given momenta"));
}
