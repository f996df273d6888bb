// SPDX-License-Identifier: MIT
//
// Written-out energies where straight-line code is used: against equations derived by hand, and against the same energies as they are.
#include "catch2_bridge.hpp"

#include <algorithm>
#include <random>

#include "bench/chain_energies.hpp"
#include "bench/hand_derived.hpp"
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
    if (!detail::straight_line_acceleration<n>(system.energies(), q.data(), v.data(), 0.0, line.data())) return 1.0;
    worst = std::max({worst, (a - acceleration(system, q, v)).norm() / (1.0 + a.norm()), (a - line).norm() / (1.0 + a.norm())});
  }
  return worst;
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
    const auto pushed = [](const auto& system) { return scene(system, generalized_force([](const auto& at, const auto& u) { return Vector<typename std::decay_t<decltype(at)>::Scalar, 2>(0.3 * at - 0.1 * u); })); };
    CHECK((acceleration(pushed(plain), q, v) - acceleration(pushed(written), q, v)).norm() < rounded);
  }
}
