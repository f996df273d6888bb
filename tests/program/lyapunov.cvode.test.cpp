// SPDX-License-Identifier: MIT
//
// qdot lyapunov, at a point where the exponents are known, and what it refuses.
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "catch2_bridge.hpp"
#include "command.hpp"

using nlohmann::json;
using program_test::qdot;

TEST_CASE("above its support a pendulum falls at sqrt(g/l)") {
  // What pi lacks in double, 1e-16, has grown to 1e-9 at the end; deviations are in their directions up to exp(-12) when they are counted.
  constexpr double settled = 1e-5;
  const auto ended = qdot("lyapunov pendulum --set q0=3.141592653589793 --t-end 5 --settle 2 --interval 0.1 --json");
  INFO(ended.err);
  REQUIRE(ended.status == 0);
  const json found = json::parse(ended.out);
  CHECK_THAT(found["lambda"][0].get<double>(), WithinAbs(std::sqrt(9.81), settled));
  CHECK_THAT(found["lambda"][1].get<double>(), WithinAbs(-std::sqrt(9.81), settled));
  CHECK(found["outcome"] == "completed");
  CHECK(found["intervals"] == 30);
}

TEST_CASE("what has constraints or cannot be measured so is refused in words") {
  const auto err = [](const std::string& arguments) {
    const auto ended = qdot("lyapunov " + arguments);
    CHECK(ended.status == 2);
    return ended.err;
  };
  CHECK(err("cartesian_pendulum").find("must have no constraints and nothing that switches, for exponents") != std::string::npos);
  CHECK(err("pendulum --interval 0") == "qdot lyapunov: --interval: must be positive, given 0\n");
  CHECK(err("pendulum --settle 7 --t-end 7") == "qdot lyapunov: --settle: must lie from 0 to the duration of the run, 7, given 7\n");
  CHECK(err("pendulum --out nowhere/") == "qdot lyapunov: --out: must be a path whose last part is a file's name, given \"nowhere/\"\n");
  CHECK(err("pendulum --t-end 0") == "qdot lyapunov: --t-end: must differ from the time of the start, given 0\n");
}
