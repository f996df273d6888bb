// SPDX-License-Identifier: MIT
#include "qdot/ad/formula/coefficient.hpp"

#include "catch2_bridge.hpp"

using namespace qdot::formula;

TEST_CASE("coefficients are alike up to the rounding of a sum, and no farther") {
  CHECK(are_alike(Coefficient(0.1) + 0.2, Coefficient(0.3)));
  CHECK_FALSE(0.1 + 0.2 == 0.3);
  CHECK_FALSE(are_alike(Coefficient(0.3), Coefficient(0.3 + 1e-12)));
  CHECK_FALSE(are_alike(Coefficient(0.0), Coefficient(1e-300)));
  CHECK(are_alike(-Coefficient(2.0), Coefficient(-2.0)));
}

TEST_CASE("powers of coefficients are what they are, where they exist") {
  CHECK(power_of(Coefficient(-2.0), -3.0).value == -0.125);
  CHECK(power_of(Coefficient(9.0), 0.5).value == 3.0);
  CHECK(can_be_raised(Coefficient(-2.0), 3.0));
  CHECK_FALSE(can_be_raised(Coefficient(-2.0), 0.5));
  CHECK_FALSE(can_be_raised(Coefficient(0.0), -1.0));
}
