// SPDX-License-Identifier: MIT
//
// Energies that are gone through as lists, against the same energies called directly and against equations derived by hand. A build without
// optimization has no straight-line way; lists are looked at through the scalars that it evaluates. The rest is in tests/optimized.
#include "catch2_bridge.hpp"

#include <cmath>
#include <random>
#include <string>

#include "bench/chain_energies.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"
#include "qdot/mechanics/written_out.hpp"

using namespace qdot;

namespace {

// A hundred operations on numbers of order one to a hundred.
constexpr double rounded = 1e-12;

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

// A chain with other masses than those that the compiler met, and a pivot that is moved by force.
struct ShakenChain {
  double m = 1.0, l = 1.0, g = 9.81, w = 2.0;
  constexpr auto T(const auto& q, const auto& qdot, const auto& t) const {
    using std::cos, std::sin;
    using S = typename std::decay_t<decltype(q)>::Scalar;
    S vx = w * cos(w * t), vy(0.0), sum(0.0);
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      vx += l * cos(q[k]) * qdot[k];
      vy += l * sin(q[k]) * qdot[k];
      sum += 0.5 * m * (vx * vx + vy * vy);
    }
    return sum;
  }
  constexpr auto V(const auto& q, const auto& t) const {
    using std::cos;
    using S = typename std::decay_t<decltype(q)>::Scalar;
    S y(0.0), sum(0.0);
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      y -= l * cos(q[k]);
      sum += m * g * y * (1.0 + 0.1 * t);
    }
    return sum;
  }
};

// As many bodies as the object says.
struct SomeMasses {
  double m = 1.0;
  int bodies = 2;
  constexpr auto T(const auto& qdot) const {
    using S = typename std::decay_t<decltype(qdot)>::Scalar;
    S sum(0.0);
    for (int k = 0; k < 2; ++k) sum += 0.5 * (k < bodies ? m : 3.0 * m) * qdot[k] * qdot[k];
    for (int k = 2; k < bodies; ++k) sum += qdot[0] * qdot[0];
    return sum;
  }
  constexpr auto V(const auto& q) const { return 0.5 * q.squaredNorm(); }
};

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

}  // namespace

TEST_CASE("a list gives the M and the rhs of the functors that it was made from: chains with loops") {
  CHECK(difference_from_nested_duals<1>(written_out<1>(bench::LoopedChain{})) < rounded);
  CHECK(difference_from_nested_duals<2>(written_out<2>(bench::LoopedChain{})) < rounded);
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

TEST_CASE("a written-out system is the same system: energies, accelerations") {
  const ShakenChain chain{.m = 0.3, .l = 2.1, .g = 1.62, .w = 0.7};
  const auto plain = mechanical_system<2>(chain);
  const auto written = mechanical_system<2>(written_out<2>(chain));
  const Vector<double, 2> q(0.4, -0.7), v(1.1, 0.3);
  const double t = 0.6;
  CHECK(kinetic_energy(written, q, v, t) == kinetic_energy(plain, q, v, t));
  CHECK(potential_energy(written, q, t) == potential_energy(plain, q, t));
  CHECK((acceleration(written, q, v, t) - acceleration(plain, q, v, t)).norm() < rounded);
  static_assert(!decltype(written)::autonomous);
}

TEST_CASE("an object that does other operations than the compiler met does not go by the list") {
  CHECK(written_out<2>(SomeMasses{}).replays());
  CHECK(written_out<2>(SomeMasses{.m = 5.0}).replays());
  CHECK(!written_out<2>(SomeMasses{.m = 1.0, .bodies = 4}).replays());
  const auto system = mechanical_system<2>(written_out<2>(SomeMasses{.m = 2.0, .bodies = 4}));
  const Vector<double, 2> q(0.4, -0.7), v(1.1, 0.3);
  const Vector<double, 2> a = acceleration(system, q, v);  // M = diag(m + 2·2, m)
  CHECK_THAT(a[0], WithinAbs(-0.4 / 6.0, rounded));
  CHECK_THAT(a[1], WithinAbs(0.7 / 2.0, rounded));
}

TEST_CASE("a list of another object is refused, not used") {
  const auto other = written_out<2>(SomeMasses{.m = 1.0, .bodies = 4});
  const Vector<double, 2> q(0.4, -0.7), v(1.1, 0.3);
  CHECK_THROWS_AS(detail::euler_lagrange_of<2>(other, q.data(), v.data(), 0.0), InvalidValue);
}
