// SPDX-License-Identifier: MIT
//
// What the benchmark calls hand-derived is the same acceleration as the library's, to rounding.
#include "catch2_bridge.hpp"

#include <random>

#include "bench/chain_energies.hpp"
#include "bench/hand_derived.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"
#include "scenes/double_pendulum.hpp"
#include "scenes/elastic_pendulum.hpp"
#include "scenes/heavy_top.hpp"
#include "scenes/kepler.hpp"
#include "scenes/rod_and_ring.hpp"
#include "scenes/spherical_pendulum.hpp"

using namespace qdot;

namespace {

// Rounding of both, times the condition of M.
constexpr double rounded = 1e-12;
constexpr double rounded_long_chain = 1e-11;

template <int n, class E, class Hand>
double difference(const E& energies, const Hand& hand, double low, double high) {
  const auto system = mechanical_system<n>(energies);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> position(low, high), velocity(-2.0, 2.0);
  double worst = 0.0;
  for (int sample = 0; sample < 20; ++sample) {
    Vector<double, n> q, v, a;
    for (int i = 0; i < n; ++i) {
      q[i] = position(random);
      v[i] = velocity(random);
    }
    hand(q.data(), v.data(), a.data());
    const Vector<double, n> b = acceleration(system, q, v);
    worst = std::max(worst, (a - b).norm() / (1.0 + a.norm()));
  }
  return worst;
}

}  // namespace

TEST_CASE("hand-derived accelerations are those of T and V: systems of few coordinates") {
  CHECK(difference<2>(scenes::RodAndRing{}, bench::RodAndRingByHand{}, 0.3, 1.2) < rounded);
  CHECK(difference<2>(scenes::SphericalPendulum{}, bench::SphericalPendulumByHand{}, 0.3, 1.2) < rounded);
  CHECK(difference<2>(scenes::Kepler{}, bench::KeplerByHand{}, 0.3, 1.2) < rounded);
  CHECK(difference<2>(scenes::ElasticPendulum{}, bench::ElasticPendulumByHand{}, 0.3, 1.2) < rounded);
  CHECK(difference<2>(scenes::DoublePendulum{}, bench::DoublePendulumByHand{}, -2.0, 2.0) < rounded);
  CHECK(difference<3>(scenes::HeavyTop{}, bench::HeavyTopByHand{}, 0.3, 1.2) < rounded);
}

TEST_CASE("hand-derived accelerations are those of T and V: chains") {
  CHECK(difference<1>(bench::UnrolledChain<1>{}, bench::chain_by_hand<1>, -2.0, 2.0) < rounded);
  CHECK(difference<2>(bench::UnrolledChain<2>{}, bench::chain_by_hand<2>, -2.0, 2.0) < rounded);
  CHECK(difference<4>(bench::UnrolledChain<4>{}, bench::chain_by_hand<4>, -2.0, 2.0) < rounded);
  CHECK(difference<4>(bench::LoopedChain{}, bench::chain_by_hand<4>, -2.0, 2.0) < rounded);
  CHECK(difference<12>(bench::LoopedChain{}, bench::chain_by_hand<12>, -2.0, 2.0) < rounded_long_chain);
}
