// SPDX-License-Identifier: MIT
//
// What accuracy costs, on the command line.
#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "catch2_bridge.hpp"
#include "command.hpp"

using nlohmann::json;
using program_test::content;
using program_test::Directory;
using program_test::qdot;

TEST_CASE("a study of a scene names method, tolerance, error and cost of every run") {
  const auto ended = qdot("accuracy pendulum --quick --t-end 2 --method dop853 --method adams --json");
  INFO(ended.err);
  REQUIRE(ended.status == 0);
  CHECK(ended.err.empty());
  const json study = json::parse(ended.out);
  CHECK(study["scene"] == "pendulum");
  CHECK(study["t_end"] == 2.0);
  CHECK(study["outputs"] == 32);
  CHECK(study["reference"]["uncertainty"].get<double>() < 1e-16);
  REQUIRE(study["measurements"].size() == 8);
  double before = 1;
  for (const json& m : study["measurements"]) {
    INFO(m.dump());
    CHECK(m["outcome"] == "completed");
    CHECK(m["evaluations"].get<long>() > 0);
    CHECK(m["cpu_minimum"].get<double>() > 0);
    CHECK(m["cpu_median"].get<double>() >= m["cpu_minimum"].get<double>());
    CHECK(m["largest_error"].get<double>() >= m["end_error"].get<double>());
    CHECK(m["constraint_residual"].is_null());
    if (m["method"] != "dop853") continue;
    CHECK(m["largest_error"].get<double>() < before);  // tolerances fall
    before = m["largest_error"].get<double>();
  }
  CHECK(before < 1e-11);
  REQUIRE(study["cheapest"].size() >= 11);
  CHECK(study["cheapest"][5]["largest_error"].get<double>() <= 1e-6);
}

TEST_CASE("the reference of a study is the motion that a run computes") {
  const json study = json::parse(qdot("accuracy double_pendulum --quick --method dop853 --set q0=0.5 --t-end 3 --json").out);
  const json run = json::parse(qdot("run double_pendulum --set q0=0.5 --t-end 3 --method dop853 --rtol 1e-13 --atol 1e-14 --json").out);
  for (const std::size_t i : {0U, 1U}) {
    CHECK_THAT(study["reference"]["q"][i].get<double>(), WithinAbs(run["q"][i].get<double>(), 1e-10));
    CHECK_THAT(study["reference"]["qdot"][i].get<double>(), WithinAbs(run["qdot"][i].get<double>(), 1e-10));
  }
}

TEST_CASE("where the equations hold in double only, two methods are each other's reference") {
  const auto ended = qdot("accuracy cartesian_pendulum --quick --t-end 1 --json");
  INFO(ended.err);
  REQUIRE(ended.status == 0);
  const json study = json::parse(ended.out);
  CHECK(study["reference"]["made_by"].get<std::string>().starts_with("double precision"));
  CHECK(study["reference"]["gain"].is_null());
  bool some = false;
  for (const json& m : study["measurements"]) {
    if (m["outcome"] != "completed") continue;
    some = true;
    CHECK(m["constraint_residual"].get<double>() < 1e-6);
  }
  CHECK(some);
}

TEST_CASE("a study is written as a table, a page and a picture") {
  const Directory directory;
  const auto ended = qdot("accuracy pendulum --quick --t-end 1 --method dop853 --with damping=0.2 --out " + directory.file("price"));
  INFO(ended.err);
  REQUIRE(ended.status == 0);
  CHECK(ended.out.find("below 1e-6") != std::string::npos);
  CHECK(directory.entries() == 3);
  const std::string csv = content(directory.file("price.csv"));
  CHECK(csv.starts_with("method,setting,setting_kind,outcome,t,end_error,largest_error,"));
  CHECK(std::count(csv.begin(), csv.end(), '\n') == 5);
  const std::string page = content(directory.file("price.html"));
  CHECK(page.starts_with("<!doctype html>"));
  CHECK(page.ends_with("</html>\n"));
  CHECK(page.find("nan") == std::string::npos);
  CHECK(page.find("http") == page.find("http://www.w3.org/2000/svg"));
  CHECK(content(directory.file("price.svg")).starts_with("<svg "));
}

TEST_CASE("a quick study prints the cheapest way first, then the runs that it names, and no more lines than a terminal has") {
  const auto quick = qdot("accuracy pendulum --quick --t-end 1");
  REQUIRE(quick.status == 0);
  const std::size_t way = quick.out.find("  largest error   cheapest method"), runs = quick.out.find("\n  method          set to");
  REQUIRE(way != std::string::npos);
  REQUIRE(runs != std::string::npos);
  CHECK(way < runs);
  CHECK(std::count(quick.out.begin(), quick.out.end(), '\n') <= 40);
  const std::size_t said = quick.out.find("  these are ");
  REQUIRE(said != std::string::npos);
  int shown = 0, all = 0;
  REQUIRE(std::sscanf(quick.out.c_str() + said, "  these are %d of %d runs", &shown, &all) == 2);
  CHECK(std::count(quick.out.begin() + static_cast<long>(runs) + 1, quick.out.begin() + static_cast<long>(said), '\n') == shown + 1);
  CHECK(shown < all);
  const Directory directory;
  const auto full = qdot("accuracy pendulum --samples 2 --t-end 0.1 --method dop853 --out " + directory.file("full"));
  REQUIRE(full.status == 0);
  CHECK(full.out.find("\n  method          set to") < full.out.find("  largest error   cheapest method"));
  const std::string csv = content(directory.file("full.csv"));
  const auto rows = std::count(csv.begin(), csv.end(), '\n') - 1;
  const auto place = [&](const char* text) { return full.out.begin() + static_cast<long>(full.out.find(text)); };
  const auto printed = std::count(place("\n  method ") + 1, place("\n  largest error "), '\n');
  CHECK(printed == rows + 1);
}

TEST_CASE("a study refuses what it cannot do in one line") {
  const auto refused = [](const std::string& arguments) {
    const auto ended = qdot("accuracy " + arguments);
    CHECK(ended.status == 2);
    CHECK(ended.out.empty());
    CHECK(std::count(ended.err.begin(), ended.err.end(), '\n') == 1);
    return ended.err;
  };
  CHECK(refused("pendulom").starts_with("qdot accuracy: SCENE: must be a scene"));
  CHECK(refused("pendulum --method dop835").find("the nearest is \"dop853\"") != std::string::npos);
  CHECK(refused("pendulum --t-end 0").starts_with("qdot accuracy: --t-end: must be after the start"));
  CHECK(refused("pendulum --samples 0").find("--samples") != std::string::npos);
  CHECK(refused("pendulum --out /dev/null/x").starts_with("qdot accuracy: --out:"));
}
