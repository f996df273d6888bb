// SPDX-License-Identifier: MIT
//
// Euler's equations in four sets of coordinates, as `qdot bench scenes` writes them by hand, are Lagrange's of T = ½ Ω·I Ω with the library's
// rotations, torque included.
#include "catch2_bridge.hpp"

#include "mechanics/scenes_by_hand.hpp"

using namespace qdot;

namespace {

constexpr double rounded = 1e-12;  // rounding of both, times the condition of M: angles stay 0.4 from the pole

}  // namespace

TEMPLATE_TEST_CASE("hand-derived rigid bodies are those of T and a torque", "", bench::EulerAnglesBody<true>, bench::RotationVectorBody<true>,
                   bench::QuaternionBody<true>, bench::UnitQuaternionBody<true>) {
  CHECK(difference_by_hand<TestType>() < rounded);
}
