// SPDX-License-Identifier: MIT
//
// What the benchmark calls hand-derived is the same acceleration as the library's, to rounding: here with the optimizer on and no
// sanitizer, for the ways by which small systems are evaluated exist only then.
#include "catch2_bridge.hpp"

#include <cmath>
#include <cstdlib>
#include <new>
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

static long allocations = 0;

void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

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

// More of them are in tests/ways/chains_by_hand.test.cpp.
TEST_CASE("hand-derived accelerations are those of T and V: chains") {
  CHECK(difference<3>(bench::UnrolledChain<3>{}, bench::chain_by_hand<3>, -2.0, 2.0) < rounded);
  CHECK(difference<3>(bench::LoopedChain{}, bench::chain_by_hand<3>, -2.0, 2.0) < rounded);
  CHECK(difference<32>(bench::LoopedChain{}, bench::chain_by_hand<32>, -2.0, 2.0) < rounded_long_chain);
}

TEST_CASE("accelerations of systems of fixed size allocate nothing, but for the first, which derives the equations") {
  const Vector<double, 3> q3(0.4, -0.7, 1.1), v3(0.3, 0.8, -0.5);
  const Vector<double, 32> q32 = Vector<double, 32>::LinSpaced(-1.0, 1.0), v32 = Vector<double, 32>::LinSpaced(0.5, -0.5);
  const auto unrolled = mechanical_system<3>(bench::UnrolledChain<3>{});
  const auto looped = mechanical_system<3>(bench::LoopedChain{});
  const auto loose = mechanical_system<32>(bench::LoopedChain{});
  const auto top = mechanical_system<3>(scenes::HeavyTop{});
  const double first = acceleration(unrolled, q3, v3).sum() + acceleration(looped, q3, v3).sum() + acceleration(loose, q32, v32).sum() +
                       acceleration(top, q3, v3).sum();
  const long before = allocations;
  const double sum = first + acceleration(unrolled, q3, v3).sum() + acceleration(looped, q3, v3).sum() + acceleration(loose, q32, v32).sum() +
                     acceleration(top, q3, v3).sum();
  const long after = allocations;
  CHECK(std::isfinite(sum));
  CHECK(after == before);
}

TEST_CASE("accelerations of duals carry the derivatives of those of doubles") {
  // The perturbations of the caller and those inside stay apart: ∂q̈/∂q along a direction against a quotient of differences.
  const auto system = mechanical_system<3>(bench::UnrolledChain<3>{});
  const Vector<double, 3> q(0.4, -0.7, 1.1), v(0.3, 0.8, -0.5), direction(0.6, -0.2, 0.3);
  using D = Dual<double, 1>;
  Vector<D, 3> x, y;
  for (int i = 0; i < 3; ++i) {
    x[i] = D(q[i]);
    x[i].tangent[0] = direction[i];
    y[i] = D(v[i]);
  }
  const Vector<D, 3> a = acceleration(system, x, y);
  constexpr double h = 1e-5;
  const Vector<double, 3> slope = (acceleration(system, Vector<double, 3>(q + h * direction), v) -
                                   acceleration(system, Vector<double, 3>(q - h * direction), v)) / (2.0 * h);
  for (int i = 0; i < 3; ++i) CHECK(a[i].tangent[0] == Approx(slope[i]).epsilon(1e-7));
}
