// SPDX-License-Identifier: MIT
//
// qdot sweep: its values from closed forms, the same bits for any number of threads, and what it refuses.
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <string>

#include "catch2_bridge.hpp"
#include "command.hpp"

using nlohmann::json;
using program_test::qdot;

namespace {

constexpr double integrated = 1e-6;  // over some seconds at the default tolerance of 1e-8

json swept(const std::string& arguments, int status = 0) {
  const auto ended = qdot("sweep " + arguments + " --json --quiet");
  INFO(ended.err);
  REQUIRE(ended.status == status);
  return json::parse(ended.out);
}

}  // namespace

TEST_CASE("a sweep over stiffness and start finds the oscillator's closed form in every cell, the first axis fastest") {
  const json found = swept("harmonic_oscillator --over k=1,4 --over q0=0.5:1.5:3 --record q0 --record 't(q0=0)' --record 'max(qdot0)' --t-end 2");
  REQUIRE(found["motions"] == 6);
  CHECK(found["over"] == json({"k", "q0"}));
  for (std::size_t i = 0; i < 6; ++i) {
    const json& row = found["rows"][i];
    const double k = row[0], start = row[1], omega = std::sqrt(k);
    CHECK(k == (i % 2 == 0 ? 1.0 : 4.0));
    CHECK(start == 0.5 + 0.5 * static_cast<double>(i / 2));
    CHECK_THAT(row[2].get<double>(), WithinAbs(start * std::cos(omega * 2.0), integrated));
    CHECK_THAT(row[3].get<double>(), WithinAbs(std::numbers::pi / (2 * omega), integrated));
    CHECK(row[5] == "completed");
  }
}

TEST_CASE("a sweep is the same bytes for one thread and four, also of a sample") {
  for (const std::string what : {"double_pendulum --over q0=-3:3:7 --over q1=-3:3:7 --record 't(|q1|=3.14159)' --t-end 3",
                                 "pendulum --random 40 --seed 5 --over 'l~normal(1,0.05)' --over 'q0~uniform(0,1)' --t-end 3"}) {
    const auto one = qdot("sweep " + what + " --json --quiet --threads 1"), four = qdot("sweep " + what + " --json --quiet --threads 4");
    CHECK(one.status == 0);
    CHECK(one.out == four.out);
  }
}

TEST_CASE("what a motion meets stands in its cell, and the others are there") {
  const json found = swept("kepler --over qdot1=0,1 --record t --t-end 3", 1);  // without angular momentum it falls into the centre
  CHECK(found["completed"] == 1);
  CHECK(found["rows"][0][2] != "completed");
  CHECK(found["rows"][1][2] == "completed");
  const json wrong = swept("pendulum --over l=1,-1 --record q0 --t-end 1", 1);
  CHECK(wrong["rows"][0][2] == "completed");
  CHECK(wrong["rows"][1][1].is_null());
}

TEST_CASE("a sweep writes a table with a line for each motion, arrays and a page") {
  const program_test::Directory directory;
  const std::string path = directory.file("sweep");
  const auto ended = qdot("sweep pendulum --over q0=0.1:1:4 --over l=1,2,3 --t-end 1 --quiet --out " + path);
  INFO(ended.err);
  REQUIRE(ended.status == 0);
  std::ifstream csv(path + ".csv"), page(path + ".html"), arrays(path + ".npz", std::ios::binary);
  std::string line;
  std::getline(csv, line);
  CHECK(line == "q0,l,theta,outcome");
  int lines = 0;
  while (std::getline(csv, line)) ++lines;
  CHECK(lines == 12);
  std::stringstream text;
  text << page.rdbuf();
  CHECK(text.str().find("class=\"heatmap\"") != std::string::npos);
  CHECK(text.str().find("http") == std::string::npos);
  CHECK(arrays.good());
}

TEST_CASE("a sweep that means nothing is refused by argument, rule and value") {
  const auto err = [](const std::string& arguments) {
    const auto ended = qdot("sweep " + arguments);
    CHECK(ended.status == 2);
    return ended.err;
  };
  CHECK(err("pendulum") == "qdot sweep: --over: must be given at least once, NAME=FROM:TO:COUNT, or NAME~normal(MEAN,SIGMA) with --random\n");
  CHECK(err("pendulum --over length=1,2").find("--over: must be a parameter or initial value of pendulum, given \"length\"; the nearest is \"l\"") != std::string::npos);
  CHECK(err("pendulum --over l=1:2") == "qdot sweep: --over: must be NAME=FROM:TO:COUNT, with :log behind it or not, or NAME=A,B,C, given l=1:2\n");
  CHECK(err("pendulum --over l=-1:2:5:log").find("must go between positive numbers with :log") != std::string::npos);
  CHECK(err("pendulum --over l=1,2 --over l=3,4") == "qdot sweep: --over: must name each quantity once, given l twice\n");
  CHECK(err("pendulum --over l=1,2 --record speed").find("--record: must be a coordinate, a velocity or a quantity of pendulum, given \"speed\"") != std::string::npos);
  CHECK(err("pendulum --random 5 --over l=1,2").find("must be NAME~uniform(A,B) or NAME~normal(MEAN,SIGMA) with --random") != std::string::npos);
  CHECK(err("pendulum --over l=1,2 --seed 3") == "qdot sweep: --seed: must stand with --random, given without\n");
  CHECK(err("pendulum --over l=1,2 --threads 0").find("--threads: must be") != std::string::npos);
}
