// SPDX-License-Identifier: MIT
//
// Equations of many coordinates that the compiler has derived, against those derived by hand.
#include "catch2_bridge.hpp"

#include "mechanics/closed_form_difference.hpp"

using namespace qdot;

namespace {

// Rounding of both, times the condition of M, which grows with the square of the length.
constexpr double rounded_long_chain = 1e-11;

}  // namespace

// Twelve of them, which are solved without blocks: tests/optimized/closed_form.test.cpp.
TEST_CASE("derived equations of motion are those that one derives by hand: more coordinates than are multiplied out") {
  CHECK(difference_from_hand<16>() < rounded_long_chain);
}
