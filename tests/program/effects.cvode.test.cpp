// SPDX-License-Identifier: MIT
//
// Effects and constraints on the command line, against closed forms.
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

// Default tolerances are 1e-10 a step; the motions below last some dozens of steps.
constexpr double growth_of_local_errors = 1e-8;
constexpr double kept_by_projection = 1e-13;

double number(const json& value) { return value.get<double>(); }

}  // namespace

TEST_CASE("a damped small swing is a damped oscillation") {
  // theta'' = -(g/l) theta - c/(m l^2) theta' to third order in the amplitude 1e-4.
  const json run = run_json("pendulum --set q0=1e-4 --with damping=0.4 --t-end 3 --atol 1e-16");
  const double decay = 0.2, rate = std::sqrt(9.81 - decay * decay);
  const double expected = 1e-4 * std::exp(-decay * 3) * (std::cos(rate * 3) + decay / rate * std::sin(rate * 3));
  CHECK_THAT(number(run["q"][0]), WithinAbs(expected, 1e-11));
  CHECK(run["effects"] == json::array({{{"name", "damping"}, {"value", 0.4}}}));
}

TEST_CASE("off equals absent") {
  for (const char* effects : {"--with damping --without damping", "--with damping --with drive --without damping --without drive"}) {
    INFO(effects);
    const json bare = run_json("pendulum --t-end 2");
    const json off = run_json("pendulum --t-end 2 " + std::string(effects));
    CHECK(bare["q"] == off["q"]);
    CHECK(bare["qdot"] == off["qdot"]);
    CHECK(bare["evaluations"] == off["evaluations"]);
    CHECK(off["effects"] == json::array());
  }
  const json damped = run_json("pendulum --t-end 2 --with damping");
  CHECK(damped["q"] == run_json("pendulum --t-end 2 --with drive --with damping --without drive")["q"]);
  CHECK(damped["q"] != run_json("pendulum --t-end 2")["q"]);
}

TEST_CASE("a motor takes an empty cart to the speed where its current vanishes") {
  // U = k v at i = 0: 12 V / (2 V s/m). The pole is nearly massless, and hangs.
  const json run = run_json("cartpole --set m=1e-9 --set q1=0 --with motor=12 --t-end 60");
  CHECK_THAT(number(run["qdot"][0]), WithinRel(6.0, 1e-6));
}

TEST_CASE("a rod in tension pulls with m (g cos theta + v^2/l)") {
  const json run = run_json("cartesian_pendulum --set q0=0 --set q1=-1 --set qdot0=2 --t-end 1");
  // At the end; lambda l is minus the tension.
  const double x = number(run["q"][0]), y = number(run["q"][1]), vx = number(run["qdot"][0]), vy = number(run["qdot"][1]);
  CHECK_THAT(std::hypot(x, y), WithinAbs(1.0, kept_by_projection));
  CHECK_THAT(-number(run["reactions"][0]["lambda"]), WithinRel(-9.81 * y + vx * vx + vy * vy, 1e-9));
  CHECK(number(run["constraint_residual_max"]) < kept_by_projection);
  CHECK(number(run["constraint_velocity_max"]) < 10 * kept_by_projection);
}

#ifdef QDOT_PROGRAM_IS_SANITIZED
constexpr const char* many_periods = "2139.13760055869";  // a thousand: at least fifty times slower
#else
constexpr const char* many_periods = "21391.3760055869";  // ten thousand
#endif

TEST_CASE("ten thousand periods leave the circle and its tangent by rounding only") {
  // 4 K(sin^2 1/2)/sqrt(9.81) a period, at default tolerances.
  const json run = run_json(std::string("cartesian_pendulum --samples 2 --t-end ") + many_periods);
  CHECK(number(run["constraint_residual_max"]) < 1e-12);
  CHECK(number(run["constraint_velocity_max"]) < 1e-12);
}

TEST_CASE("with the constraint and without, the pendulum is at the same angle to the accuracy that was asked for") {
  const std::string span = " --t-end 213.913760055869 --samples 2 --accuracy 1e-8";  // a hundred periods
  const json held = run_json("cartesian_pendulum" + span);
  const json free = run_json("pendulum --set q0=1 --method dop853" + span);
  CHECK_THAT(std::atan2(number(held["q"][0]), -number(held["q"][1])), WithinAbs(number(free["q"][0]), 1e-8));
}

TEST_CASE("a start off the constraints is moved onto them, and the run says how far") {
  const json run = run_json("cartesian_pendulum --set q0=0 --set q1=-1.1 --t-end 0.1");
  CHECK_THAT(number(run["start_moved"]["q"]), WithinAbs(0.1, 1e-12));
}

TEST_CASE("the crank's slider is where the closed form puts it after many turns") {
  const std::string method = GENERATE("dop853", "bdf");
  const json run = run_json("slider_crank --t-end 20 --method " + method);
  const double theta = number(run["q"][0]), s = std::sin(theta);
  CHECK(theta > 100.0);
  CHECK_THAT(number(run["q"][2]), WithinAbs(0.3 * std::cos(theta) + std::sqrt(0.64 - 0.09 * s * s), 1e-12));
  CHECK(number(run["energy_drift_max"]) < 1e-5);
}

TEST_CASE("a four-bar linkage stays closed and keeps its energy") {
  const json run = run_json("four_bar --t-end 5");
  const double q1 = number(run["q"][0]), q2 = number(run["q"][1]), q3 = number(run["q"][2]);
  CHECK_THAT(0.3 * std::cos(q1) + 0.9 * std::cos(q2) - 0.7 * std::cos(q3), WithinAbs(1.0, kept_by_projection));
  CHECK_THAT(0.3 * std::sin(q1) + 0.9 * std::sin(q2) - 0.7 * std::sin(q3), WithinAbs(0.0, kept_by_projection));
  CHECK(number(run["energy_drift_max"]) < 1e-6);
}

TEST_CASE("round bodies roll down with g sin alpha / (1 + kappa), held back by friction") {
  const double kappa = GENERATE(1.0, 0.5, 0.4);
  const json run = run_json("rolling_hoop --t-end 2 --set kappa=" + std::to_string(kappa));
  const double a = 9.81 * std::sin(0.3) / (1 + kappa);
  CHECK_THAT(number(run["q"][0]), WithinRel(2 * a, growth_of_local_errors));
  CHECK_THAT(number(run["reactions"][0]["lambda"]), WithinRel(-kappa * a, growth_of_local_errors));
}

TEST_CASE("Chaplygin's sleigh goes straight in the end") {
  // v = V tanh kt, omega = omega0 sech kt.
  const json run = run_json("chaplygin_sleigh --t-end 6");
  const double theta = number(run["q"][2]);
  const double v = number(run["qdot"][0]) * std::cos(theta) + number(run["qdot"][1]) * std::sin(theta);
  CHECK_THAT(v, WithinRel(0.964053630663094, growth_of_local_errors));
  CHECK_THAT(number(run["qdot"][2]), WithinAbs(0.0135242008876143, growth_of_local_errors));
  CHECK(number(run["energy_drift_max"]) < growth_of_local_errors);
}

TEST_CASE("a charge in crossed fields drifts with E/B across both") {
  // omega = 0: x = d (1 - cos(B t)) with d = E/B^2 (unit mass and charge), y = -E/B t + d sin(B t).
  const json run = run_json("charged_particle --set omega=0 --set qdot0=0 --t-end 10");
  const double d = 0.3 / 4;
  CHECK_THAT(number(run["q"][0]), WithinAbs(d * (1 - std::cos(20.0)), growth_of_local_errors));
  CHECK_THAT(number(run["q"][1]), WithinAbs(-0.15 * 10 + d * std::sin(20.0), growth_of_local_errors));
}

TEST_CASE("qdot effects shows the bare scene, each effect, and all of them") {
  const auto ended = qdot("effects cartpole --json");
  REQUIRE(ended.status == 0);
  const json rows = json::parse(ended.out)["rows"];
  REQUIRE(rows.size() == 6);
  CHECK(rows[0]["effects"] == "bare");
  CHECK(rows[1]["effects"] == "motor");
  CHECK(rows[4]["effects"] == "all");
  for (const json& row : rows) {
    CHECK(number(row["ns"]) > 0);
    CHECK_THAT(number(row["ratio"]), WithinRel(number(row["ns"]) / number(rows[0]["ns"]), 1e-12));
  }
}
