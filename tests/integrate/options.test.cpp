// SPDX-License-Identifier: MIT
#include "qdot/integrate/options.hpp"

#include <string>

#include "catch2_bridge.hpp"
#include "first_order_systems.hpp"

using qdot::Options;

namespace {

std::string complaint(const Options& options, Eigen::Index size = 2) {
  try {
    qdot::detail::require_valid(options, size);
  } catch (const qdot::Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("the default options are valid for every size") {
  REQUIRE(complaint({}, 1).empty());
  REQUIRE(complaint({}, 100).empty());
}

TEST_CASE("atol is one number for all components or one for each") {
  REQUIRE(complaint({.atol = {1e-9, 1e-6}}).empty());
  REQUIRE(Options{.atol = 1e-9}.atol[1] == 1e-9);
  REQUIRE(Options{.atol = {1e-9, 1e-6}}.atol[1] == 1e-6);
  REQUIRE(complaint({.atol = {1e-9, 1e-9, 1e-9}}) ==
          "atol must have 2 entries, but has 3; give one number for all components, or one for each (positions first, "
          "then velocities)");
  REQUIRE_THROWS_AS(qdot::detail::require_valid({.atol = {1e-9, 1e-9, 1e-9}}, 2), qdot::DimensionError);
}

TEST_CASE("an option outside its range is named with the rule, the value and a remedy") {
  REQUIRE(complaint({.rtol = 0}) ==
          "rtol must lie between 2.3e-15 (double has no more digits) and 1, but is 0; try 1e-9");
  REQUIRE(complaint({.atol = -1e-9}) ==
          "atol must be finite and not negative, but is -1e-09; give the size below which the component no longer matters");
  REQUIRE(complaint({.atol = 1e-310}) ==
          "atol must be 0 or at least 2.3e-308 (smaller numbers lose their digits), but is 1e-310; give the size below which the component no "
          "longer matters");
  REQUIRE(complaint({.atol = {1e-9, -1.0}}) ==
          "atol[1] must be finite and not negative, but is -1; give the size below which the component no longer matters");
  REQUIRE(complaint({.max_step = 0}) == "max_step must be positive, but is 0; leave it out for no limit");
  REQUIRE(
      complaint({.initial_step = 2, .max_step = 1}) ==
      "initial_step must lie between 0 (chosen by the method) and max_step, but is 2; leave it out; the sign is that "
      "of the run");
}

TEST_CASE("NaN is no valid value of any option") {
  REQUIRE(!complaint({.rtol = test::nan}).empty());
  REQUIRE(!complaint({.atol = test::nan}).empty());
  REQUIRE(!complaint({.initial_step = test::nan}).empty());
  REQUIRE(!complaint({.max_step = test::nan}).empty());
  REQUIRE(!complaint({.max_wall_seconds = test::nan}).empty());
  REQUIRE(!complaint({.state_norm_limit = test::nan}).empty());
  REQUIRE(!complaint({.stop_times = {test::nan}}).empty());
  REQUIRE(!complaint({.output_times = {test::nan}}).empty());
  REQUIRE(!complaint({.max_steps = 0}).empty());
  REQUIRE(!complaint({.max_evaluations = 0}).empty());
}
