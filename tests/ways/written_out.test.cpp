// SPDX-License-Identifier: MIT
//
// Written-out energies where straight-line code is used: against equations derived by hand, and against the same energies as they are.
#include "catch2_bridge.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "bench/chain_energies.hpp"
#include "bench/hand_derived.hpp"
#include "mechanics/shaken_chain.hpp"
#include "qdot/effects/forces.hpp"
#include "qdot/effects/scene_motion.hpp"
#include "qdot/mechanics/acceleration_jacobian.hpp"
#include "qdot/mechanics/ensemble.hpp"
#include "qdot/mechanics/written_out.hpp"

using namespace qdot;

namespace {

// Rounding of both, times the condition of M.
constexpr double rounded = 1e-12;
constexpr double rounded_derivatives = 1e-11;

template <int n>
double difference_from_hand() {
  const auto system = mechanical_system<n>(written_out<n>(bench::LoopedChain{}));
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-2.0, 2.0);
  double worst = 0.0;
  for (int sample = 0; sample < 20; ++sample) {
    Vector<double, n> q, v, a, line;
    for (int i = 0; i < n; ++i) {
      q[i] = uniform(random);
      v[i] = uniform(random);
    }
    bench::chain_by_hand<n>(q.data(), v.data(), a.data());
    const detail::AccelerationTo<n> use{line.data(), detail::singular_pivot<double>(n)};
    if (!detail::straight_line_equations<n>(system.energies(), detail::AtState{q.data(), v.data(), 0.0}, use)) return 1.0;
    worst = std::max({worst, (a - acceleration(system, q, v)).norm() / (1.0 + a.norm()), (a - line).norm() / (1.0 + a.norm())});
  }
  return worst;
}

// The worst relative difference of M and X L by the list from those by nested duals, which call T and V themselves.
template <int n, class E>
double difference_from_nested_duals(const E& written) {
  REQUIRE(written.replays());
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0.1, 0.9);
  double worst = 0.0;
  for (int sample = 0; sample < 5; ++sample) {
    Vector<double, n> q, v;
    for (int i = 0; i < n; ++i) {
      q[i] = uniform(random);
      v[i] = uniform(random);
    }
    const double t = uniform(random);
    const auto L = detail::euler_lagrange_of<n>(written, q.data(), v.data(), t);
    const Matrix<double, n> M = detail::kinetic_hessian<n>(written, q, v, t);
    const Vector<double, n> r = detail::lagrange_rhs<n>(written, q, v, t);
    const double scale = 1.0 + M.cwiseAbs().maxCoeff() + r.cwiseAbs().maxCoeff();
    unroll<n>([&](auto i) { worst = std::max(worst, std::abs(L.template x<i>() - r[i]) / scale); });
    unroll<n*(n + 1) / 2>([&](auto k) {
      const double entry = M(detail::triangle_row(k), detail::triangle_column(k));
      worst = std::max(worst, std::abs(L.template h<k>() - entry) / scale);
    });
  }
  return worst;
}

// f of arguments that have every derivative there is.
template <class F>
struct EnergyOf {
  constexpr auto T(const auto& q, const auto& v, const auto& t) const {
    return F()(0.3 + 0.1 * q[0] * v[0] + 0.1 * t * v[0] * v[0], 0.4 + 0.2 * q[0] - 0.1 * v[0]);
  }
  constexpr auto V(const auto& q) const { return F()(0.5 * q[0], 0.3 + 0.1 * q[0]); }
};
template <class F>
double difference_of(const F&) {
  return difference_from_nested_duals<1>(written_out<1>(EnergyOf<F>{}));
}

// Two masses; with `third` another term.
struct Masses {
  double m = 1.0;
  bool third = false;
  constexpr auto T(const auto& q, const auto& v) const {
    using S = typename std::decay_t<decltype(v)>::Scalar;
    S sum(0.0);
    for (int k = 0; k < 2; ++k) sum += 0.5 * m * (1.0 + q[k] * q[k]) * v[k] * v[k];
    if (third) sum += 0.5 * v[0] * v[1];
    return sum;
  }
  constexpr auto V(const auto& q) const {
    using std::cos;
    return m * cos(q[0] - q[1]) + abs(q[1]);
  }
};

}  // namespace

TEST_CASE("hand-derived accelerations are those of T and V: chains with written-out loops") {
  CHECK(difference_from_hand<1>() < rounded);
  CHECK(difference_from_hand<2>() < rounded);
  CHECK(difference_from_hand<3>() < rounded);
  CHECK(difference_from_hand<4>() < rounded);
}

TEST_CASE("a list gives the M and the rhs of the functors that it was made from: energies that know the time") {
  CHECK(difference_from_nested_duals<2>(written_out<2>(ShakenChain{.m = 0.3, .l = 2.1, .g = 1.62, .w = 0.7})) < rounded);
}

TEST_CASE("a list gives the M and the rhs of the functors that it was made from: lambdas and what they capture") {
  const double m = 0.7, k = 12.0, a = 0.7;
  const auto T = [=](const auto& v) { return 0.5 * m * v.squaredNorm(); };
  const auto V = [=](const auto& q) {
    using std::cos;
    auto sum = 0.5 * k * q.dot(q);
    for (int i = 0; i < 2; ++i) sum += a * m * cos(q[i]) / (a + q(i) * q.norm());
    return sum + q.sum() * q.x() - q.y();
  };
  CHECK(difference_from_nested_duals<2>(written_out<2>(T, V)) < rounded);
  CHECK(difference_from_nested_duals<2>(written_out<2>(T)) < rounded);
  CHECK(difference_from_nested_duals<3>(written_out<3>([](const auto& q, const auto& v) { return (1.0 + q[0] * q[0]) * v.squaredNorm() + v[0] * v[2]; })) <
        rounded);
}

TEST_CASE("a list gives the M and the rhs of the functors that it was made from: kinks") {
  CHECK(difference_of([](const auto& x, const auto& y) { using std::abs, std::max, std::min; return abs(-x) * y + max(x, y) + min(y, x) * x; }) < rounded);
}

TEST_CASE("written-out energies have the accelerations and derivatives of the same energies as they are, whether the list fits or not") {
  const Vector<double, 2> q(0.4, -0.7), v(1.1, 0.3);
  for (const bool third : {false, true}) {
    const Masses masses{.m = 2.5, .third = third};
    const auto plain = mechanical_system<2>(masses);
    const auto written = mechanical_system<2>(written_out<2>(masses));
    CHECK(written.energies().replays() == !third);
    CHECK((acceleration(plain, q, v) - acceleration(written, q, v)).norm() < rounded);
    const auto a = acceleration_jacobian(plain, q, v), b = acceleration_jacobian(written, q, v);
    CHECK((a.qddot - b.qddot).norm() < rounded);
    CHECK((a.d_q - b.d_q).norm() + (a.d_qdot - b.d_qdot).norm() < rounded_derivatives);
    const Vector<Pack<2>, 2> x(Pack<2>(0.4), Pack<2>(-0.7)), y(Pack<2>(1.1), Pack<2>(0.3));
    const auto packs = accelerations(written, x, y);
    CHECK(packs.good.all());
    for (int i = 0; i < 2; ++i) CHECK(std::abs(packs.qddot[i][1] - b.qddot[i]) < rounded);
    const auto pushed = [](const auto& system) {
      return scene(system, generalized_force([](const auto& at, const auto& u) {
                     return Vector<typename std::decay_t<decltype(at)>::Scalar, 2>(0.3 * at - 0.1 * u);
                   }));
    };
    CHECK((acceleration(pushed(plain), q, v) - acceleration(pushed(written), q, v)).norm() < rounded);
  }
}
