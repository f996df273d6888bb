// SPDX-License-Identifier: MIT
//
// --accuracy: the error of the whole motion, or the outcome accuracy_not_reached.
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "catch2_bridge.hpp"
#include "command.hpp"
#include "run_json.hpp"

using nlohmann::json;
using program_test::qdot;
using program_test::run_json;

namespace {

// Of the larger of a position and its velocity's size; |y| of the run is at least that at its end.
double relative(double value, double exact, double size) { return std::abs(value - exact) / size; }

}  // namespace

TEST_CASE("an accuracy bounds the error of the motion, with whatever method") {
  // The pendulum of 1 rad at t = 10, from quadruple precision; sizes 1 rad and 2 sqrt(g) sin(1/2).
  for (const std::string asked : {"1e-4", "1e-8", "1e-11"}) {
    for (const std::string method : {"dop853", "auto"}) {
      const json run = run_json("pendulum --set q0=1 --t-end 10 --accuracy " + asked + " --method " + method);
      INFO(method << ", accuracy " << asked);
      const double accuracy = std::stod(asked);
      CHECK(run["outcome"] == "completed");
      CHECK(run["accuracy"] == accuracy);
      const double estimate = run["error_estimate"].get<double>();
      CHECK(estimate <= accuracy);
      CHECK(relative(run["q"][0].get<double>(), -0.46325276873178667, 1.0) <= 3 * estimate);
      CHECK(relative(run["qdot"][0].get<double>(), 2.6365495135496304, 3.0) <= 3 * estimate);
    }
  }
}

TEST_CASE("the forecast names three more digits, and what they cost") {
  const json run = run_json("double_pendulum --t-end 3 --accuracy 1e-6");
  REQUIRE(run["forecast"].size() == 3);
  double factor = 1.0, accuracy = 1e-6;
  for (const json& more : run["forecast"]) {
    CHECK_THAT(more["accuracy"].get<double>(), WithinRel(accuracy / 10, 1e-9));
    CHECK(more["factor"].get<double>() > factor);
    CHECK(more["seconds"].get<double>() > 0);
    factor = more["factor"].get<double>();
    accuracy /= 10;
  }
  CHECK(run_json("pendulum --t-end 1")["accuracy"].is_null());
  CHECK_FALSE(run_json("pendulum --t-end 1").contains("forecast"));
}

TEST_CASE("where chaos leaves no digits, the best run comes back with its estimate") {
  const json run = run_json("double_pendulum --t-end 60 --set q0=2 --set q1=2.5 --accuracy 1e-8", 1);
  CHECK(run["outcome"] == "accuracy_not_reached");
  CHECK(run["error_estimate"].get<double>() > 1e-6);
  CHECK(run["t"] == 60.0);
  CHECK(run["forecast"][0]["factor"].is_null());
}

TEST_CASE("an accuracy outside its range is refused") {
  for (const char* wrong : {"0", "-1e-6", "2"}) {
    const auto ended = qdot(std::string("run pendulum --accuracy ") + wrong);
    CHECK(ended.status == 2);
    CHECK(ended.err.find("accuracy") != std::string::npos);
  }
}
