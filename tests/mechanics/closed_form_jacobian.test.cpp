// SPDX-License-Identifier: MIT
//
// q̈ and its derivatives in closed form, against nested duals that call T and V themselves.
#include "../catch2_bridge.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "bench/chain_energies.hpp"
#include "qdot/mechanics/acceleration_jacobian.hpp"
#include "qdot/mechanics/written_out.hpp"
#include "scenes/heavy_top.hpp"
#include "scenes/kepler.hpp"

using namespace qdot;

namespace {

// Rounding of both ways, times the condition of M twice.
constexpr double rounded = 1e-11;

template <int n, class E>
double difference(const System<E, n>& system, double low, double high) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> position(low, high), velocity(-2.0, 2.0);
  double worst = 0.0;
  for (int sample = 0; sample < 5; ++sample) {
    Vector<double, n> q, v, a;
    for (int i = 0; i < n; ++i) {
      q[i] = position(random);
      v[i] = velocity(random);
    }
    const double t = position(random);
    AccelerationJacobian<n> expected{Vector<double, n>(n), Matrix<double, n>(n, n), Matrix<double, n>(n, n)};
    detail::jacobian_by_duals(system, q, v, t, expected);
    Matrix<double, n> d_q, d_qdot;
    if (!system.energies().jacobian_in_closed_form(q.data(), v.data(), t, a.data(), d_q.data(), d_qdot.data())) return HUGE_VAL;
    const double scale = 1.0 + expected.d_q.cwiseAbs().maxCoeff() + expected.d_qdot.cwiseAbs().maxCoeff();
    worst = std::max({worst, (a - expected.qddot).cwiseAbs().maxCoeff() / (1.0 + expected.qddot.cwiseAbs().maxCoeff()),
                      (d_q - expected.d_q).cwiseAbs().maxCoeff() / scale, (d_qdot - expected.d_qdot).cwiseAbs().maxCoeff() / scale});
  }
  return worst;
}

// A body in space, its angles Euler's, on a spring that is moved.
struct SpringBody {
  double m = 1.3, A = 0.4, B = 0.6, C = 0.9, k = 3.0;
  constexpr auto T(const auto& q, const auto& v) const {
    using std::cos, std::sin;
    const auto x = v[3] * sin(q[4]) * sin(q[5]) + v[4] * cos(q[5]);
    const auto y = v[3] * sin(q[4]) * cos(q[5]) - v[4] * sin(q[5]);
    const auto z = v[3] * cos(q[4]) + v[5];
    return 0.5 * m * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) + 0.5 * (A * x * x + B * y * y + C * z * z);
  }
  constexpr auto V(const auto& q, const auto& t) const {
    using std::sin, std::sqrt;
    const auto dx = q[0] - 0.2 * sin(q[3]) - sin(t);
    return 0.5 * k * sqrt(1.0 + dx * dx + q[1] * q[1]) + m * q[2] * q[4];
  }
};

TEST_CASE("the derived Jacobian of a chain is the one by nested duals") {
  CHECK(difference(mechanical_system<5>(written_out<5>(bench::LoopedChain{.g = 3.7})), -2.0, 2.0) < rounded);
}

TEST_CASE("the derived Jacobian of few coordinates is the one by nested duals") {
  CHECK(difference(mechanical_system<1>(written_out<1>(bench::LoopedChain{.g = 3.7})), -2.0, 2.0) < rounded);
  CHECK(difference(mechanical_system<2>(written_out<2>(scenes::Kepler{})), 0.4, 1.4) < rounded);
  CHECK(difference(mechanical_system<3>(written_out<3>(scenes::HeavyTop{})), 0.4, 1.4) < rounded);
}

TEST_CASE("where V has no value there is no derived Jacobian") {
  const auto system = mechanical_system<2>(written_out<2>(scenes::Kepler{}));
  const Vector<double, 2> q{0.0, 0.0}, v{0.3, 0.2};
  Vector<double, 2> a;
  Matrix<double, 2> d_q, d_qdot;
  CHECK_FALSE(system.energies().jacobian_in_closed_form(q.data(), v.data(), 0.0, a.data(), d_q.data(), d_qdot.data()));
  CHECK_THROWS_AS(acceleration_jacobian(system, q, v), NonFinite);
}

TEST_CASE("the derived Jacobian of a body on a spring is the one by nested duals") {
  CHECK(difference(mechanical_system<6>(written_out<6>(SpringBody{.m = 0.7, .B = 1.1})), 0.3, 1.2) < rounded);
}

TEST_CASE("where M is singular there is no derived Jacobian") {
  const auto system = mechanical_system<6>(written_out<6>(SpringBody{}));
  const Vector<double, 6> q{0.1, 0.2, 0.3, 0.4, 0.0, 0.6}, zero = Vector<double, 6>::Zero();
  Vector<double, 6> a;
  Matrix<double, 6> d_q, d_qdot;
  CHECK_FALSE(system.energies().jacobian_in_closed_form(q.data(), zero.data(), 0.0, a.data(), d_q.data(), d_qdot.data()));
  CHECK_THROWS_AS(acceleration_jacobian(system, q, zero), SingularMassMatrix);
}

}  // namespace
