// SPDX-License-Identifier: MIT
#include <cmath>

#include "../catch2_bridge.hpp"
#include "qdot/mechanics/energy.hpp"

namespace {

using Eigen::Vector2d;
using qdot::mechanical_system;

// Rounding of a dozen operations on numbers of order ten.
constexpr double rounding = 1e-14;

// A bead on a hoop of radius 1 that turns at W about its vertical diameter, written in the turning angle:
// T = ½ θ̇² + ½ W² sin²θ, V = −g cos θ.
constexpr double W = 5.0;
constexpr double g = 9.81;
const auto hoop = mechanical_system<1>(
    [](const auto& q, const auto& qdot) {
      using std::sin;
      return 0.5 * (qdot[0] * qdot[0] + W * W * sin(q[0]) * sin(q[0]));
    },
    [](const auto& q) {
      using std::cos;
      return -g * cos(q[0]);
    });

TEST_CASE("energies and momenta of the rotating hoop equal the formulas") {
  const qdot::Vector<double, 1> q(0.7);
  const qdot::Vector<double, 1> qdot_(1.3);
  const double T = 0.5 * (1.3 * 1.3 + W * W * std::pow(std::sin(0.7), 2));
  const double V = -g * std::cos(0.7);
  CHECK_THAT(kinetic_energy(hoop, q, qdot_), WithinAbs(T, rounding));
  CHECK_THAT(potential_energy(hoop, q), WithinAbs(V, rounding));
  CHECK_THAT(lagrangian(hoop, q, qdot_), WithinAbs(T - V, rounding));
  CHECK_THAT(energy(hoop, q, qdot_), WithinAbs(T + V, rounding));
  CHECK_THAT(conjugate_momenta(hoop, q, qdot_)[0], WithinAbs(1.3, rounding));
  // ∂L/∂θ = W² sin θ cos θ − g sin θ
  CHECK_THAT(lagrangian_gradient(hoop, q, qdot_)[0],
             WithinAbs(W * W * std::sin(0.7) * std::cos(0.7) - g * std::sin(0.7), rounding));
}

TEST_CASE("Jacobi's energy function drops the part of T that no velocity moves") {
  // h = ½ θ̇² − ½ W² sin²θ + V, which is not T + V
  const qdot::State<1> s{0.0, qdot::Vector<double, 1>(0.7), qdot::Vector<double, 1>(1.3)};
  const double T0 = 0.5 * W * W * std::pow(std::sin(0.7), 2);
  CHECK_THAT(jacobi_energy(hoop, s), WithinAbs(0.5 * 1.3 * 1.3 - T0 - g * std::cos(0.7), rounding));
  CHECK_THAT(energy(hoop, s) - jacobi_energy(hoop, s), WithinAbs(2.0 * T0, rounding));
}

TEST_CASE("Jacobi's energy function equals T + V when T is quadratic in the velocities") {
  const auto polar = mechanical_system<2>(
      [](const auto& q, const auto& qdot) { return 0.5 * (qdot[0] * qdot[0] + q[0] * q[0] * qdot[1] * qdot[1]); },
      [](const auto& q) { return -1.0 / q[0]; });
  const Vector2d q(1.2, 0.4);
  const Vector2d qdot_(-0.3, 0.8);
  CHECK_THAT(jacobi_energy(polar, q, qdot_), WithinAbs(energy(polar, q, qdot_), rounding));
  CHECK_THAT(conjugate_momenta(polar, q, qdot_)[1], WithinAbs(1.2 * 1.2 * 0.8, rounding));
}

TEST_CASE("explicit time reaches both energies") {
  const auto swept = mechanical_system<1>(
      [](const auto& q, const auto& qdot, const auto& t) { return t * qdot[0] * qdot[0] + 0.0 * q[0]; },
      [](const auto& q, const auto& t) { return q[0] * t * t; });
  const qdot::Vector<double, 1> q(3.0);
  const qdot::Vector<double, 1> qdot_(2.0);
  CHECK(energy(swept, q, qdot_, 5.0) == 5.0 * 4.0 + 3.0 * 25.0);
  CHECK(conjugate_momenta(swept, q, qdot_, 5.0)[0] == 20.0);
}

TEST_CASE("a state of the wrong size is refused with both sizes") {
  const auto free = mechanical_system(3, [](const auto& qdot) { return 0.5 * qdot.squaredNorm(); });
  const Eigen::VectorXd three = Eigen::VectorXd::Zero(3);
  const Eigen::VectorXd two = Eigen::VectorXd::Zero(2);
  CHECK_THROWS_AS(energy(free, two, three), qdot::DimensionError);
  CHECK_THROWS_WITH(energy(free, three, two),
                    "qdot must have 3 entries, but has 2; pass one entry for each coordinate of the system");
}

}  // namespace
