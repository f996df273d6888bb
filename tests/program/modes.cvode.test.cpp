// SPDX-License-Identifier: MIT
//
// qdot modes and qdot equilibria, against closed forms.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "catch2_bridge.hpp"
#include "command.hpp"

using nlohmann::json;
using program_test::qdot;

namespace {

constexpr double rounding = 1e-12;

json answer(const std::string& arguments) {
  const auto ended = qdot(arguments + " --json");
  INFO(ended.err);
  REQUIRE(ended.status == 0);
  return json::parse(ended.out);
}

double number(const json& value) { return value.get<double>(); }

}  // namespace

TEST_CASE("a damped pendulum hangs with omega_0 = sqrt(g/l) and zeta = c/(2 m l^2 omega_0)") {
  const json bare = answer("modes pendulum --set l=2 --set q0=0.3");
  CHECK(bare["stability"] == "stable in the linear approximation");
  CHECK_THAT(number(bare["modes"][0]["frequency"]), WithinRel(std::sqrt(9.81 / 2.0), rounding));
  const json damped = answer("modes pendulum --with damping=0.4 --set q0=0.3");
  CHECK(damped["stability"] == "asymptotically stable");
  CHECK_THAT(number(damped["modes"][0]["damping_ratio"]), WithinRel(0.2 / std::sqrt(9.81), rounding));
  CHECK_THAT(number(damped["q"][0]), WithinAbs(0.0, rounding));
}

TEST_CASE("a pendulum in Cartesian coordinates swings like one by its angle, and its rod carries the weight") {
  const json held = answer("modes cartesian_pendulum --set q0=0.1 --set q1=-1");
  REQUIRE(held["modes"].size() == 1);
  CHECK_THAT(number(held["modes"][0]["frequency"]), WithinRel(std::sqrt(9.81), rounding));
  CHECK_THAT(std::abs(number(held["reactions"][0]["lambda"])), WithinRel(9.81, rounding));
}

TEST_CASE("a bead on a fast hoop has four equilibria: two unstable poles and two places aside") {
  const json found = answer("equilibria bead_on_hoop --set Omega=5");
  REQUIRE(found["equilibria"].size() == 4);
  int aside = 0;
  for (const json& point : found["equilibria"]) {
    const double theta = number(point["q"][0]);
    if (std::abs(std::sin(theta)) < 1e-6) {
      CHECK(point["stability"] == "unstable");
      continue;
    }
    ++aside;
    CHECK_THAT(std::cos(theta), WithinRel(9.81 / 25.0, rounding));
    CHECK_THAT(number(point["modes"][0]["frequency"]), WithinRel(5.0 * std::abs(std::sin(theta)), 1e-10));
  }
  CHECK(aside == 2);
}

TEST_CASE("a sleigh goes straight on, and its turning dies out at the rate m a u/(I + m a^2) (Chaplygin)") {
  const json straight = answer(
      "modes chaplygin_sleigh --steady --set q2=0 --set qdot0=2 --set qdot1=0 --set qdot2=0 --set m=1 --set I=0.3 "
      "--set a=0.5");
  double fastest = 0.0;
  for (const json& lambda : straight["exponents"]) fastest = std::min(fastest, number(lambda[0]));
  CHECK_THAT(fastest, WithinRel(-0.5 * 2.0 / (0.3 + 0.25), rounding));
  CHECK(straight["states"].size() == 5);
}

TEST_CASE("the option --out of modes writes a table and a page, and stdout says where the scene rests") {
  const program_test::Directory directory;
  const auto ended = qdot("modes pendulum --set q0=0.3 --out '" + directory.file("x") + "'");
  REQUIRE(ended.status == 0);
  CHECK(ended.out.find("pendulum: equilibrium, stable in the linear approximation\n") == 0);
  CHECK(directory.entries() == 2);
  CHECK(program_test::content(directory.file("x.csv"))
            .find("point,re [1/s],im [rad/s],natural_frequency [rad/s],damping_ratio,theta [rad]\n1,0,3.132") == 0);
  CHECK(program_test::content(directory.file("x.html")).find("Exponents") != std::string::npos);
}

TEST_CASE("what has no equilibrium, and wrong arguments, end with status 2 and one line") {
  for (const char* arguments :
       {"modes projectile", "modes nothing", "modes pendulum --set x=1", "modes bouncing_ball", "equilibria projectile",
        "modes mathieu", "modes pendulum --out /nowhere/x", "modes pendulum --with wind"}) {
    INFO(arguments);
    const auto ended = qdot(arguments);
    CHECK(ended.status == 2);
    CHECK(ended.out.empty());
    CHECK(ended.err.find('\n') == ended.err.size() - 1);
  }
  CHECK(qdot("modes projectile").err.find("SCENE: must rest near its start") != std::string::npos);
}
