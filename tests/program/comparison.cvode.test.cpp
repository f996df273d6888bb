// SPDX-License-Identifier: MIT
//
// Runs of a scene beside each other.
#include <nlohmann/json.hpp>
#include <string>

#include "catch2_bridge.hpp"
#include "command.hpp"
#include "run_json.hpp"

using nlohmann::json;
using program_test::content;
using program_test::Directory;
using program_test::qdot;
using program_test::run_json;

TEST_CASE("a run beside another is the run that it is alone") {
  const json both = run_json("double_pendulum --t-end 2 --compare 'q0=1,l1=1.2' --compare method=dop853,rtol=1e-8");
  REQUIRE(both["runs"].size() == 3);
  CHECK(both["runs"][0]["q"] == run_json("double_pendulum --t-end 2")["q"]);
  CHECK(both["runs"][1]["q"] == run_json("double_pendulum --t-end 2 --set q0=1 --set l1=1.2")["q"]);
  CHECK(both["runs"][2]["q"] == run_json("double_pendulum --t-end 2 --method dop853 --rtol 1e-8")["q"]);
  CHECK(run_json("cartpole --t-end 1 --compare 'with motor=6'")["runs"][1]["q"] == run_json("cartpole --t-end 1 --with motor=6")["q"]);
}

TEST_CASE("coordinates and velocities go by their names and by their numbers in --set, --over and --compare") {
  const json by_number = run_json("pendulum --t-end 1 --set q0=1 --set qdot0=0.5 --compare q0=2")["runs"];
  const json by_name = run_json("pendulum --t-end 1 --set theta=1 --set thetadot=0.5 --compare theta=2")["runs"];
  for (std::size_t k : {0U, 1U}) CHECK(by_name[k]["q"] == by_number[k]["q"]);
  const auto swept = [](const std::string& name) { return json::parse(qdot("sweep pendulum --t-end 1 --quiet --json --over " + name + "=1,2").out)["rows"]; };
  CHECK(swept("theta") == swept("q0"));
  CHECK(swept("thetadot") == swept("qdot0"));
}

TEST_CASE("the summary says how far two runs are apart, and the files show both") {
  const Directory directory;
  const auto ended = qdot("run pendulum --quiet --t-end 2 --set q0=1e-3 --compare q0=3e-3 --out '" + directory.file("both") + "'");
  REQUIRE(ended.status == 0);
  CHECK(ended.out.find("q0=3e-3: apart by 0.002 in theta at t = 0") != std::string::npos);  // small swings keep their phase
  for (const char* name : {"both.csv", "both.npz", "both.html", "both.svg", "both_2.csv", "both_2.npz"}) CHECK(!content(directory.file(name)).empty());
  CHECK(directory.entries() == 6);
  const std::string page = content(directory.file("both.html"));
  CHECK(page.find("Beside it") != std::string::npos);
  CHECK(page.find("largest |Δq|") != std::string::npos);
}

TEST_CASE("settings that cannot be compared are refused with their name before anything runs") {
  const auto no_value = qdot("run pendulum --compare l");
  CHECK(no_value.status == 2);
  CHECK(no_value.err.find("--compare: must have the form NAME=VALUE") != std::string::npos);
  const auto unknown = qdot("run pendulum --compare lenght=2");
  CHECK(unknown.status == 2);
  CHECK(unknown.err.find("lenght") != std::string::npos);
  CHECK(qdot("run pendulum --compare method=nonsense").status == 2);
  CHECK(qdot("run pendulum --compare ''").status == 2);
}
