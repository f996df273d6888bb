// SPDX-License-Identifier: MIT
#include "qdot/effects/impact.hpp"

#include <cmath>
#include <vector>

#include "../catch2_bridge.hpp"
#include "scenes/double_pendulum.hpp"

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using qdot::ImpactLaw;
using qdot::poisson_restitution;
using qdot::restitution;
using qdot::detail::impulses;

constexpr double rounding = 1e-13;

// A symmetric positive definite matrix and velocities, different for each number.
MatrixXd some_matrix(int k, int seed) {
  MatrixXd B(k, k);
  for (int i = 0; i < k; ++i)
    for (int j = 0; j < k; ++j) B(i, j) = std::sin(1.0 + 3.7 * i + 5.3 * j + 0.9 * seed);
  return B * B.transpose() + 0.1 * MatrixXd::Identity(k, k);
}

VectorXd some_velocities(int k, int seed) {
  VectorXd u(k);
  for (int i = 0; i < k; ++i) u[i] = std::cos(2.0 + 2.3 * i + 1.7 * seed);
  return u;
}

}  // namespace

TEST_CASE("one blow on one contact: Newton's and Poisson's laws agree, and an open contact gets none") {
  const MatrixXd A = MatrixXd::Constant(1, 1, 0.5);
  const VectorXd still = VectorXd::Constant(1, 1e-12);
  for (const ImpactLaw& law : {restitution(0.6), poisson_restitution(0.6)}) {
    VectorXd u = VectorXd::Constant(1, -2.0);
    CHECK_THAT(impulses(A, u, {law}, still)[0], WithinAbs(1.6 * 2.0 / 0.5, rounding));
    CHECK_THAT(u[0], WithinAbs(1.2, rounding));
    CHECK(impulses(A, u, {law}, still)[0] == 0.0);
  }
}

TEST_CASE("after any blows no contact approaches, no impulse pulls, and energy has not grown") {
  for (int k = 2; k <= 4; ++k)
    for (int seed = 0; seed < 25; ++seed) {
      const MatrixXd A = some_matrix(k, seed);
      const VectorXd before = some_velocities(k, seed), still = VectorXd::Constant(k, 1e-12);
      std::vector<ImpactLaw> laws;
      for (int i = 0; i < k; ++i) {
        const double e = 0.5 + 0.5 * std::sin(1.3 * i + seed);
        laws.push_back((i + seed) % 3 == 0 ? poisson_restitution(e) : restitution(e));
      }
      VectorXd u = before;
      const VectorXd impulse = impulses(A, u, laws, still);
      CHECK(impulse.minCoeff() >= 0.0);
      CHECK((u - before - A * impulse).cwiseAbs().maxCoeff() < 1e-10);
      CHECK(u.minCoeff() > -1e-9);
      CHECK(0.5 * impulse.dot(u + before) < 1e-10);  // the change of kinetic energy
    }
}

TEST_CASE("an elastic blow on one contact keeps the energy") {
  const MatrixXd A = some_matrix(2, 1);
  VectorXd u(2);
  u << -1.0, 5.0;
  const VectorXd before = u, impulse = impulses(A, u, {restitution(1.0), restitution(1.0)}, VectorXd::Constant(2, 1e-12));
  CHECK_THAT(impulse.dot(u + before), WithinAbs(0.0, 1e-12));
}

TEST_CASE("contacts that say the same twice share the blow") {
  const MatrixXd A = MatrixXd::Ones(2, 2);
  VectorXd u = VectorXd::Constant(2, -1.0);
  const VectorXd impulse = impulses(A, u, {restitution(0.5), restitution(0.5)}, VectorXd::Constant(2, 1e-12));
  CHECK_THAT(impulse.sum(), WithinAbs(1.5, rounding));
  CHECK_THAT(u[0], WithinAbs(0.5, rounding));
}

TEST_CASE("two blows at once: Poisson's law keeps back what was compressed, Newton's what was fast") {
  // Compression takes Λ = (0.8, 0.4) to u = 0. With e = (1, 0) Poisson's law returns 0.8 of it at the first contact,
  // Newton's asks for u₁ = 1, and then the second contact needs no impulse.
  MatrixXd A(2, 2);
  A << 1.0, 0.5, 0.5, 1.0;
  const VectorXd before = (VectorXd(2) << -1.0, -0.8).finished(), still = VectorXd::Constant(2, 1e-12);
  VectorXd u = before;
  const VectorXd poisson = impulses(A, u, {poisson_restitution(1.0), poisson_restitution(0.0)}, still);
  CHECK((poisson - (VectorXd(2) << 1.6, 0.4).finished()).norm() < rounding);
  CHECK((u - (VectorXd(2) << 0.8, 0.4).finished()).norm() < rounding);
  u = before;
  const VectorXd newton = impulses(A, u, {restitution(1.0), restitution(0.0)}, still);
  CHECK((newton - (VectorXd(2) << 2.0, 0.0).finished()).norm() < rounding);
  CHECK((u - (VectorXd(2) << 1.0, 0.2).finished()).norm() < rounding);
}

TEST_CASE("both laws in one blow do not let the energy grow") {
  // Λ = (532/39, 7, 370/13) would satisfy both laws, and raise the energy by 4/3.
  MatrixXd A(3, 3);
  A << 0.3, 0.3, -0.2, 0.3, 0.4, -0.2, -0.2, -0.2, 0.22;
  const VectorXd before = (VectorXd(3) << -0.5, -0.6, -0.9).finished();
  VectorXd u = before;
  const VectorXd impulse = impulses(A, u, {restitution(0.0), restitution(1.0), poisson_restitution(1.0)}, VectorXd::Constant(3, 1e-12));
  CHECK(impulse.minCoeff() >= 0.0);
  CHECK(u.minCoeff() > -1e-9);
  CHECK(0.5 * impulse.dot(u + before) < 1e-10);
}

TEST_CASE("the impact of a system throws it back along M⁻¹Jᵀ") {
  // A double pendulum's unit masses and lengths at rest angles hit a wall with the lower bob.
  const auto system = qdot::mechanical_system<2>(qdot::scenes::DoublePendulum{});
  const auto gap = [](const auto& q) {
    using std::sin;
    return 2.0 - sin(q[0]) - sin(q[1]);
  };
  const auto hit = qdot::impact(system, gap, restitution(0.7));
  const qdot::State<2> before{0.0, {0.3, 0.8}, {1.0, 0.5}};
  auto after = before;
  hit(after);
  const Eigen::Vector2d J(-std::cos(0.3), -std::cos(0.8));
  CHECK_THAT(J.dot(after.qdot), WithinAbs(-0.7 * J.dot(before.qdot), rounding));
  const Eigen::Vector2d impulse = mass_matrix(system, before.q, before.qdot) * (after.qdot - before.qdot);
  CHECK_THAT(impulse[0] * J[1] - impulse[1] * J[0], WithinAbs(0.0, rounding));
  const auto leaving = after;
  hit(after);
  CHECK(after.qdot == leaving.qdot);
}

TEST_CASE("a coefficient of restitution outside 0 … 1 is refused") {
  CHECK_THROWS_WITH(restitution(-0.1), "a coefficient of restitution must lie between 0 and 1, but is -0.100000; more than 1 would create energy");
  CHECK_THROWS_AS(poisson_restitution(std::nan("")), qdot::InvalidValue);
}
