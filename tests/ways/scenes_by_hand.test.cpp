// SPDX-License-Identifier: MIT
//
// What `qdot bench scenes` calls hand-derived is the same acceleration, with the same multipliers, as the library's, to rounding: here with
// the optimizer on and no sanitizer, for the ways by which small scenes are evaluated exist only then. Rigid bodies are in
// tests/mechanics/bodies_by_hand.test.cpp.
#include "catch2_bridge.hpp"

#include "mechanics/scenes_by_hand.hpp"

using namespace qdot;

namespace {

// Rounding of both, times the condition of M and of J M⁻¹ Jᵀ.
constexpr double rounded = 1e-12;
constexpr double rounded_long_chain = 1e-11;

}  // namespace

TEMPLATE_TEST_CASE("hand-derived scenes are those of their effects and constraints", "", bench::CartpoleWithMotorAndFriction,
                   bench::CartesianPendulumInAir, bench::TautRope, bench::DrivenFourBar, bench::SliderAndCrank,
                   bench::RollingHoopHolonomic, bench::RollingHoopNonholonomic, bench::SleighOnBlade, bench::SlidingBlock,
                   bench::SprungDoublePendulum) {
  CHECK(difference_by_hand<TestType>() < rounded);
}

TEST_CASE("hand-derived chains with damping and a guided tip are those of their effects and constraints") {
  const auto check = []<class Way>(Way) {
    CHECK(difference_by_hand<bench::DampedChain<Way, 4>>() < rounded);
    CHECK(difference_by_hand<bench::DampedGuidedChain<Way, 4>>() < rounded);
    CHECK(difference_by_hand<bench::DampedGuidedChain<Way, 8>>() < rounded_long_chain);
  };
  check(bench::LoopedEnergies());
  check(bench::LoopsInARun());
}
