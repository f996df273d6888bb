// SPDX-License-Identifier: MIT
//
// Chains that the benchmark derives by hand have the library's accelerations, to rounding, by the ways that exist with the optimizer on. What an optimizer
// makes of them is asked in tests/optimized/hand_derived.test.cpp.
#include <algorithm>
#include <random>

#include "bench/chain_energies.hpp"
#include "bench/hand_derived.hpp"
#include "catch2_bridge.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"

using namespace qdot;

namespace {

// Rounding of both, times the condition of M.
constexpr double rounded = 1e-12;
constexpr double rounded_long_chain = 1e-11;

template <int n, class E>
double difference(const E& energies) {
  const auto system = mechanical_system<n>(energies);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-2.0, 2.0);
  double worst = 0.0;
  for (int sample = 0; sample < 20; ++sample) {
    Vector<double, n> q, v, a;
    for (int i = 0; i < n; ++i) {
      q[i] = uniform(random);
      v[i] = uniform(random);
    }
    bench::chain_by_hand<n>(q.data(), v.data(), a.data());
    const Vector<double, n> b = acceleration(system, q, v);
    worst = std::max(worst, (a - b).norm() / (1.0 + a.norm()));
  }
  return worst;
}

}  // namespace

TEST_CASE("hand-derived accelerations are those of T and V: chains summed with qdot::unroll") {
  CHECK(difference<1>(bench::UnrolledChain<1>{}) < rounded);
  CHECK(difference<2>(bench::UnrolledChain<2>{}) < rounded);
  CHECK(difference<3>(bench::UnrolledChain<3>{}) < rounded);
  CHECK(difference<5>(bench::UnrolledChain<5>{}) < rounded);
}

TEST_CASE("hand-derived accelerations are those of T and V: chains summed with a plain loop") {
  CHECK(difference<1>(bench::LoopedChain{}) < rounded);
  CHECK(difference<4>(bench::LoopedChain{}) < rounded);
  CHECK(difference<8>(bench::LoopedChain{}) < rounded);
  CHECK(difference<12>(bench::LoopedChain{}) < rounded_long_chain);
  CHECK(difference<32>(bench::LoopedChain{}) < rounded_long_chain);
}
