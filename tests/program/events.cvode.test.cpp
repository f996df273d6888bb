// SPDX-License-Identifier: MIT
//
// Scenes with events, as a user of the program sees them.
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "../catch2_bridge.hpp"
#include "command.hpp"
#include "run_json.hpp"

using nlohmann::json;
using program_test::qdot;
using program_test::run_json;

namespace {

std::vector<double> times(const json& run, const std::string& name) {
  std::vector<double> result;
  for (const json& e : run["events"])
    if (e["name"] == name) result.push_back(e["t"].get<double>());
  return result;
}

}  // namespace

TEST_CASE("a bouncing ball's forty impacts come when the closed form says, and then it lies on the floor") {
  const json run = run_json("bouncing_ball --set e=0.9 --t-end 10");
  const auto impacts = times(run, "floor");
  REQUIRE(impacts.size() >= 40);
  double t = std::sqrt(2.0 / 9.81), flight = 2 * t;
  for (std::size_t i = 0; i < 40; ++i) {
    CHECK_THAT(impacts[i], WithinAbs(t, 1e-10));
    t += flight *= 0.9;
  }
  CHECK(run["outcome"] == "completed");
  CHECK(run["q"][0] == 0.0);
  CHECK(run["qdot"][0] == 0.0);
  CHECK(run["events"].back()["name"] == "floor rests");
}

TEST_CASE("a block with dry friction sticks after seven half swings") {
  const json run = run_json("friction_block --rtol 1e-12 --atol 1e-12");
  CHECK(times(run, "block turns").size() == 6);
  REQUIRE(times(run, "block sticks").size() == 1);
  CHECK_THAT(times(run, "block sticks")[0], WithinAbs(3.5 * std::acos(-1.0), 1e-9));
  CHECK_THAT(run["q"][0].get<double>(), WithinAbs(0.05, 1e-9));
  CHECK_THAT(run["energy_work"].get<double>(), WithinAbs(-0.3 * 6.65, 1e-9));  // F times the way
  CHECK(run["energy_balance_max"].get<double>() < 1e-9);
}

TEST_CASE("the ring leaves the rod, or hits a stop and in the end rests against it") {
  const json open = run_json("rod_and_ring --with open_end --t-end 3");
  CHECK(open["outcome"] == "stopped_by_event");
  CHECK_THAT(open["q"][0].get<double>(), WithinAbs(1.5, 1e-12));
  CHECK(open["t"] == open["events"][0]["t"]);
  const json stopped = run_json("rod_and_ring --with end_stop=0.5 --t-end 3");
  CHECK(stopped["events"][0]["t"] == open["events"][0]["t"]);
  CHECK(stopped["events"].back()["name"] == "end stop rests");
  CHECK_THAT(stopped["q"][0].get<double>(), WithinAbs(1.5, 1e-12));
}

TEST_CASE("a restitution that would create energy is a bad argument") {
  const auto run = qdot("run bouncing_ball --set e=1.5");
  CHECK(run.status == 2);
  CHECK(run.err.find("must lie between 0 and 1, but is 1.5") != std::string::npos);
}

TEST_CASE("the page of a run has its events as marks in the plots against time, and counts them") {
  const program_test::Directory directory;
  const auto run = qdot("run bouncing_ball --t-end 3 --out '" + directory.file("ball") + "'");
  REQUIRE(run.status == 0);
  const std::string page = program_test::content(directory.file("ball.html"));
  // Six impacts until t = 3; √(2/g) is the first. Plots of place, velocity, energies and their change have them, the phase plane has not.
  const std::string title = "<title>floor, 0.451524</title>";
  std::size_t plots = 0;
  for (std::size_t at = page.find(title); at != std::string::npos; at = page.find(title, at + 1)) ++plots;
  CHECK(plots >= 4);
  CHECK(page.find("6×, t = 0.451524 to ") != std::string::npos);
}
