// SPDX-License-Identifier: MIT
#include "hard/car_axis.cpp"

#include "../catch2_bridge.hpp"

TEST_CASE("the car axis follows a road that stands in a constraint, with the work that the road does") {
  using namespace qdot::hard;
  const Row row = solved(problem(), axis(), By::dop853, {.rtol = 1e-11, .atol = 1e-12});
  CHECK(row.digits_reached > 9.5);
  CHECK(*row.energy_drift_max < 1e-9);  // of the balance; the energy itself changes by as much as there is
  CHECK(*row.constraint_residual_max < 1e-14);
}
