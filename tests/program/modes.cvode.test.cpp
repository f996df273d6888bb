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

TEST_CASE("along its angular velocity a hoop's bead leaves the lowest point at Omega^2 = g/R, and rests at cos theta = g/(Omega^2 R)") {
  const program_test::Directory directory;
  const std::string out = directory.file("bead");
  const json found = answer("equilibria bead_on_hoop --along Omega=1:6 --set R=2 --out " + out);
  constexpr double located = 1e-9;  // of the range
  REQUIRE(found["branches"].size() == 3);
  const json& below = found["branches"][0]["points"];
  std::string kinds;
  for (const json& point : below) kinds += point["kind"].get<std::string>()[0];
  kinds.erase(std::remove(kinds.begin(), kinds.end(), 'r'), kinds.end());
  CHECK(kinds == "sbe");
  for (const json& point : below) {
    const double Omega = number(point["p"]), pitchfork = std::sqrt(9.81 / 2.0);
    CHECK_THAT(number(point["q"][0]), WithinAbs(0.0, rounding));
    if (point["kind"] == "branch") CHECK_THAT(Omega, WithinAbs(pitchfork, located));
    else CHECK(point["stability"] == (Omega < pitchfork ? "stable in the linear approximation" : "unstable"));
  }
  for (const std::size_t side : {1U, 2U}) {
    CHECK(found["branches"][side]["from"]["branch"] == 0);
    const json& end = found["branches"][side]["points"].back();
    CHECK(number(end["p"]) == 6.0);
    CHECK_THAT(number(end["q"][0]), WithinAbs((side == 1 ? 1.0 : -1.0) * std::acos(9.81 / 72.0), located));
    CHECK(end["stability"] == "stable in the linear approximation");
  }
  CHECK(program_test::content(out + ".csv").starts_with("branch,kind,Omega [rad/s],theta [rad],growing,largest_re [1/s]\n1,0,1,0,0,"));
  const std::string picture = program_test::content(out + ".svg");
  for (const char* part : {"stroke-dasharray", ">unstable<", ">branch point<", ">Ω [rad/s]<"}) CHECK(picture.find(part) != std::string::npos);
  CHECK(program_test::content(out + ".html").find("stable in the linear approximation, then unstable") != std::string::npos);
}

TEST_CASE("a branch begins and ends where the values that a scene takes do") {
  for (const std::string along : {"bead_on_hoop --along Omega=0:1", "bead_on_hoop --along Omega=1:0", "pendulum --with damping --along damping=0:1",
                                  "pendulum --with damping --along damping=1:0", "pendulum --along g=9:0"}) {
    INFO(along);
    const auto ended = qdot("equilibria " + along);
    CHECK(ended.status == 0);
    CHECK(ended.out.find("1: from the start; reached the end of the range\n") != std::string::npos);
  }
}

// The crank of a four-bar linkage carries the weight of all bars, and a torque; the largest torque that it can carry is the largest dV/dθ₁, the places of
// the bars from two circles.
TEST_CASE("what a branch is followed in may be an effect that is on, and it turns back where no more can be carried") {
  const auto V = [](double crank) {
    const double a = 0.3, b = 0.9, c = 0.7, d = 1.0, x = a * std::cos(crank) - d, y = a * std::sin(crank), e = std::hypot(x, y);
    const double rocker = std::atan2(y, x) - std::acos((c * c + e * e - b * b) / (2.0 * c * e));
    const double coupler = std::atan2(c * std::sin(rocker) - y, c * std::cos(rocker) - x);
    return 9.81 * (0.5 * a * a * std::sin(crank) + b * (a * std::sin(crank) + 0.5 * b * std::sin(coupler)) + 0.5 * c * c * std::sin(rocker));
  };
  constexpr double h = 1e-4, differenced = 1e-6;
  double most = 0.0, at = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const double crank = 5.5 + 1e-4 * i, slope = (8.0 * (V(crank + h) - V(crank - h)) - (V(crank + 2.0 * h) - V(crank - 2.0 * h))) / (12.0 * h);
    if (slope > most) most = slope, at = crank;
  }
  const json found = answer("equilibria four_bar --with torque=0 --along torque=:8");
  REQUIRE(found["branches"].size() == 1);
  int folds = 0;
  for (const json& point : found["branches"][0]["points"]) {
    if (point["kind"] != "fold") continue;
    ++folds;
    CHECK_THAT(number(point["p"]), WithinAbs(most, differenced));
    CHECK_THAT(number(point["q"][0]), WithinAbs(at, 2e-4));  // twice the distance of the places above
  }
  CHECK(folds == 1);
  CHECK_THAT(number(found["branches"][0]["points"].back()["p"]), WithinAbs(0.0, rounding));
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
        "modes mathieu", "modes pendulum --out /dev/null/x", "modes pendulum --with wind"}) {
    INFO(arguments);
    const auto ended = qdot(arguments);
    CHECK(ended.status == 2);
    CHECK(ended.out.empty());
    CHECK(ended.err.find('\n') == ended.err.size() - 1);
  }
  for (const char* arguments :
       {"equilibria bead_on_hoop --along Omega", "equilibria bead_on_hoop --along Omega=5:", "equilibria bead_on_hoop --along nothing=1:2",
        "equilibria bead_on_hoop --along Omega=2:2", "equilibria bead_on_hoop --along Omega=:5", "equilibria chain --along n=2:5",
        "equilibria pendulum --along damping=0:1", "equilibria projectile --along g=1:2", "equilibria bead_on_hoop --show theta",
        "equilibria bead_on_hoop --along Omega=1:2 --show thetadot", "equilibria pendulum --with drive --along drive=1:2"}) {
    INFO(arguments);
    const auto ended = qdot(arguments);
    CHECK(ended.status == 2);
    CHECK(ended.out.empty());
    CHECK(ended.err.find('\n') == ended.err.size() - 1);
  }
  const auto lost = qdot("equilibria pendulum --along g=1:-1 --set q0=0.1");
  CHECK(lost.status == 1);
  CHECK(lost.out.find("lost at p = ") != std::string::npos);
  CHECK(qdot("modes projectile").err.find("SCENE: must rest near its start") != std::string::npos);
}
