// SPDX-License-Identifier: MIT
//
// What `qdot bench scenes` calls hand-derived is the same acceleration, with the same multipliers, as the library's, to rounding: here with
// the optimizer on and no sanitizer, for the ways by which small scenes are evaluated exist only then.
#include "catch2_bridge.hpp"

#include <random>

#include "bench/measured_scenes.hpp"
#include "bench/scenes.hpp"

using namespace qdot;

namespace {

// Rounding of both, times the condition of M and of J M⁻¹ Jᵀ.
constexpr double rounded = 1e-12;
constexpr double rounded_long_chain = 1e-11;

template <class Case>
double difference() {
  constexpr int n = Case::n, all = Case::n + Case::constraints;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> position(Case::lowest, Case::highest), velocity(-2.0, 2.0);
  double worst = 0.0;
  for (int sample = 0; sample < 20; ++sample) {
    Vector<double, n> q, v;
    for (int i = 0; i < n; ++i) {
      q[i] = position(random);
      v[i] = velocity(random);
    }
    Vector<double, all> a, b;
    bench::by_hand_of_scene<typename Case::Hand>(q.data(), v.data(), a.data());
    bench::by_scene<Case>(q.data(), v.data(), b.data());
    worst = std::max(worst, (a - b).norm() / (1.0 + a.norm()));
  }
  return worst;
}

}  // namespace

TEMPLATE_TEST_CASE("hand-derived scenes are those of their effects and constraints", "", bench::CartpoleWithMotorAndFriction,
                   bench::CartesianPendulumInAir, bench::TautRope, bench::DrivenFourBar, bench::SliderAndCrank, bench::RollingHoopHolonomic,
                   bench::RollingHoopNonholonomic, bench::SleighOnBlade, bench::SlidingBlock, bench::SprungDoublePendulum) {
  CHECK(difference<TestType>() < rounded);
}

TEST_CASE("hand-derived chains with damping and a guided tip are those of their effects and constraints") {
  using Way = bench::LoopedEnergies;
  CHECK(difference<bench::DampedChain<Way, 4>>() < rounded);
  CHECK(difference<bench::DampedGuidedChain<Way, 4>>() < rounded);
  CHECK(difference<bench::DampedGuidedChain<Way, 8>>() < rounded_long_chain);
}
