// SPDX-License-Identifier: MIT
#include "hard/projected_pendulum.cpp"

#include "../catch2_bridge.hpp"

TEST_CASE("CVODE's pendulum keeps its rod where it is projected and loses it where it is not, as SUNDIALS' table has it") {
  using namespace qdot::hard;
  // Errors of y after fifteen periods at 1e-5, by SUNDIALS: 0.00225 and 0.898.
  const Row projected = beside(table[0], false), unprojected = beside(table[1], false);
  CHECK(table[0].projected);
  CHECK_FALSE(table[1].projected);
  CHECK(projected.digits_reached > 2.0);
  CHECK(unprojected.digits_reached < 1.0);
}
