// SPDX-License-Identifier: MIT
//
// Equations of chains that the compiler has derived, against nested duals and against those derived by hand.
#include "catch2_bridge.hpp"

#include "mechanics/closed_form_difference.hpp"

using namespace qdot;

namespace {

// Rounding of both, times the condition of M, which grows with the square of the length.
constexpr double rounded = 1e-12;
constexpr double rounded_long_chain = 1e-11;

constexpr bool under_forces = true;  // where coordinates are eliminated, one is left, or some are: forces do not look at T and V

}  // namespace

TEST_CASE("derived equations of motion are those of T and V: short chains") {
  CHECK(difference_of_ways<1>(bench::LoopedChain{.g = 1.6}, -2.0, 2.0) < rounded);
  CHECK(difference_of_ways<2>(bench::LoopedChain{.g = 1.6}, -2.0, 2.0) < rounded);
  CHECK(difference_of_ways<3, under_forces>(bench::LoopedChain{.g = 1.6}, -2.0, 2.0) < rounded);
}

TEST_CASE("derived equations of motion are those that one derives by hand: as many coordinates as are multiplied out") {
  CHECK(difference_from_hand<8>() < rounded_long_chain);
}
