// SPDX-License-Identifier: MIT
//
// qdot section, where the points are known, and what it refuses.
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "catch2_bridge.hpp"
#include "command.hpp"

using nlohmann::json;
using program_test::content;
using program_test::qdot;

namespace {
constexpr double settled = 1e-8;  // of some periods at the default tolerance
}

// Modes of 4 and 4.8: the masses move alike, x = y = sin 2t, or against each other.
TEST_CASE("a plane is passed once in each period of a mode") {
  const auto alike = qdot("section coupled_oscillators --set q0=0 --set q1=0 --set qdot0=2 --set qdot1=2 --plane x=0 --count 3 --json");
  INFO(alike.err);
  REQUIRE(alike.status == 0);
  const json found = json::parse(alike.out);
  CHECK(found["surface"] == "x = 0, rising");
  REQUIRE(found["motions"].size() == 1);
  const json& motion = found["motions"][0];
  CHECK(motion["outcome"] == "complete");
  for (std::size_t k = 0; k < 3; ++k) {
    CHECK_THAT(motion["t"][k].get<double>(), WithinAbs(std::numbers::pi * static_cast<double>(k + 1), settled));
    CHECK_THAT(motion["y"][k][1].get<double>(), WithinAbs(0.0, settled));
    CHECK_THAT(motion["y"][k][3].get<double>(), WithinAbs(2.0, settled));
  }
}

TEST_CASE("starts of one energy lie on its level, and those that cannot are left out") {
  const program_test::Directory directory;
  const std::string out = directory.file("stars");
  const auto ended = qdot(
      "section henon_heiles --set q0=0 --set q1=0 --set qdot0=0.5 --set qdot1=0 --plane q0=0 --over q1=0,0.1,0.9 --keep-energy xdot --count 5 --json --out " +
      out);
  INFO(ended.err);
  REQUIRE(ended.status == 0);
  const json found = json::parse(ended.out);
  CHECK(found["left_out"] == json::array({"y = 0.9"}));  // V = 0.162 > 1/8
  REQUIRE(found["motions"].size() == 2);
  for (const json& motion : found["motions"])
    for (const json& point : motion["y"]) {
      const double y = point[1], v2 = point[2].get<double>() * point[2].get<double>() + point[3].get<double>() * point[3].get<double>();
      CHECK_THAT(0.5 * (v2 + y * y) - y * y * y / 3.0, WithinAbs(0.125, settled));
    }
  CHECK(content(out + ".csv").starts_with("start,t,x,y,xdot,ydot\n0,"));
  CHECK(content(out + ".svg").find("y = 0.1") != std::string::npos);
  CHECK(content(out + ".html").find("10 points of 2 motions at x = 0, rising") != std::string::npos);
}

TEST_CASE("a stroboscope shows a state once in each period, constraints are kept, and what was not reached is status 1") {
  const auto seen = qdot("section harmonic_oscillator --every 3.141592653589793 --count 4 --json");
  REQUIRE(seen.status == 0);
  for (const json& point : json::parse(seen.out)["motions"][0]["y"]) CHECK_THAT(point[0].get<double>(), WithinAbs(1.0, settled));
  const auto swing = qdot("section cartesian_pendulum --plane x=0 --count 2 --json");
  INFO(swing.err);
  REQUIRE(swing.status == 0);
  for (const json& point : json::parse(swing.out)["motions"][0]["y"]) CHECK_THAT(std::abs(point[1].get<double>()), WithinAbs(1.0, settled));
  const auto missed = qdot("section harmonic_oscillator --plane x=5 --t-end 20");
  CHECK(missed.status == 1);
  CHECK(missed.out.find("t_end_reached: 0 of 200 crossings of 'x = 5, rising' up to t = 20; its function went from -") != std::string::npos);
}

// Without gravity both arms of the double pendulum hang on together: m = l = 1, released stretched out, they turn as one at a constant rate.
TEST_CASE("a plane of an angle is passed in each turn, and angles are shown without their turns") {
  for (const std::string rate : {"2", "-2"}) {
    const std::string direction = rate == "2" ? "rising" : "falling";
    const auto turns = qdot("section double_pendulum --set g=0 --set q0=0.5 --set q1=0.5 --set qdot0=" + rate + " --set qdot1=" + rate +
                            " --plane q0=0 --angle q0 --angle q1 --direction " + direction + " --count 5 --t-end 100 --json");
    INFO(turns.err);
    REQUIRE(turns.status == 0);
    const json motion = json::parse(turns.out)["motions"][0];
    for (std::size_t k = 0; k < 5; ++k) {
      const double until = rate == "2" ? 2 * std::numbers::pi - 0.5 : 0.5;
      CHECK_THAT(motion["t"][k].get<double>(), WithinAbs((until + 2 * std::numbers::pi * static_cast<double>(k)) / 2.0, settled));
      for (const std::size_t angle : {0U, 1U}) CHECK_THAT(motion["y"][k][angle].get<double>(), WithinAbs(0.0, settled));
    }
  }
}

TEST_CASE("a section that cannot be is refused in words") {
  const auto err = [](const std::string& arguments) {
    const auto ended = qdot("section " + arguments);
    CHECK(ended.status == 2);
    return ended.err;
  };
  CHECK(err("pendulum --plane q0=0 --angle qdot0") == "qdot section: --angle: must be a coordinate, given qdot0\n");
  CHECK(err("pendulum") == "qdot section: --plane: must be given, NAME=VALUE with a coordinate or velocity, or --every T in its place, given neither\n");
  CHECK(err("pendulum --plane q0=0 --every 1").ends_with("given both\n"));
  CHECK(err("pendulum --plane x=0").starts_with("qdot section: --plane: must be a coordinate or velocity of pendulum, given \"x\""));
  CHECK(err("pendulum --plane q0=0 --count 0").starts_with("qdot section: --count: must be a whole number from 1 to 10000000"));
  CHECK(err("pendulum --plane q0=0 --direction up").starts_with("qdot section: --direction: must be a direction, given \"up\""));
  CHECK(err("pendulum --every 0") == "qdot section: --every: must be positive, given 0\n");
  CHECK(err("pendulum --plane q0=0 --show q0") == "qdot section: --show: must have the form NAME,NAME, given \"q0\"\n");
  CHECK(err("pendulum --plane q0=0 --keep-energy qdot0").starts_with("qdot section: --keep-energy: must stand with --over"));
  CHECK(err("pendulum --plane q0=0 --over q0=0:1:3 --keep-energy q0") == "qdot section: --keep-energy: must be a velocity, given q0\n");
  CHECK(err("cartesian_pendulum --plane q0=0 --over q0=0:1:3").starts_with("qdot section: --over: must be left out where there are constraints"));
  CHECK(err("pendulum --plane q0=0 --out nowhere/") == "qdot section: --out: must be a path whose last part is a file's name, given \"nowhere/\"\n");
}
