// SPDX-License-Identifier: MIT
//
// Scenes of any number of bodies, from the command line. What they must come to is known by hand for one body, for the modes of a line, and from angles.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "catch2_bridge.hpp"
#include "command.hpp"
#include "run_json.hpp"

using nlohmann::json;
using program_test::content;
using program_test::Directory;
using program_test::qdot;
using program_test::run_json;

namespace {

constexpr double tight = 1e-8;  // of runs at 1e-10 over some swings

}  // namespace

TEST_CASE("a lattice of linear springs swings in its lowest mode with the frequency of the dispersion law") {
  // ω = 2 √(k/m) sin(π / (2n + 2)), and each mass is its first place times cos ωt.
  const double omega = 2 * std::sqrt(2.0) * std::sin(std::numbers::pi / 42);
  for (const std::string method : {"auto", "bdf", "verlet --step 1e-3"}) {
    INFO(method);
    const json run = run_json("lattice --set n=20 --set k=2 --set alpha=0 --t-end 30 --rtol 1e-10 --method " + method);
    const double within = method == "auto" ? tight : 1e-5;  // Verlet's phase: ω³ t h² / 24 and less; BDF's local errors add up
    for (const std::size_t i : {0u, 7u, 19u})
      CHECK_THAT(run["q"][i].get<double>(), WithinAbs(run["q_initial"][i].get<double>() * std::cos(30 * omega), within));
  }
}

TEST_CASE("a string of one mass and a net of one mass are oscillators with two and four springs") {
  // Small height: force per displacement 2 k (1 − l/a) and twice that; with k = 100, l = a/2, m = 0.02: ω² = 5e3 and 1e4.
  const json string = run_json("string --set n=1 --set h=1e-6 --t-end 0.5 --atol 1e-16");
  CHECK_THAT(string["q"][0].get<double>(), WithinAbs(string["q_initial"][0].get<double>() * std::cos(0.5 * std::sqrt(5e3)), 1e-13));
  const json net = run_json("net --set n=1 --set h=1e-6 --t-end 0.5 --atol 1e-16");
  CHECK_THAT(net["q"][0].get<double>(), WithinAbs(net["q_initial"][0].get<double>() * std::cos(50.0), 1e-13));
}

TEST_CASE("a chain of rods in Cartesian coordinates moves as the chain in angles does") {
  const json rods = run_json("rod_chain --set n=3 --set l=1 --t-end 1");
  std::string level;
  for (int k = 0; k < 3; ++k) level += " --set q" + std::to_string(k) + "=" + std::to_string(std::numbers::pi / 2).substr(0, 8);
  constexpr double rounded_angle = 1e-5;  // π/2 with six decimals
  const json angles = run_json("chain --set n=3 --t-end 1" + level);
  double x = 0, y = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    x += std::sin(angles["q"][k].get<double>());
    y -= std::cos(angles["q"][k].get<double>());
    CHECK_THAT(rods["q"][2 * k].get<double>(), WithinAbs(x, rounded_angle));
    CHECK_THAT(rods["q"][2 * k + 1].get<double>(), WithinAbs(y, rounded_angle));
  }
}

TEST_CASE("a bridge of one bay is a mass on two slanted bars") {
  // Stiff bars: v = −(g/ω²)(1 − cos ωt), ω² = 2 EA h² / (m l₀³); the correction is of the order v/h.
  const json bridge = run_json("truss --set n=1 --set EA=4e7 --t-end 0.01 --atol 1e-14");
  const double l0 = std::hypot(0.5, 0.8), omega2 = 2 * 4e7 * 0.64 / (20 * l0 * l0 * l0);
  const double v = -9.81 / omega2 * (1 - std::cos(0.01 * std::sqrt(omega2)));
  CHECK_THAT(bridge["q"][1].get<double>(), WithinRel(v, 1e-4));
  CHECK_THAT(bridge["q"][0].get<double>(), WithinAbs(0.0, 1e-13));
}

TEST_CASE("four thousand masses, and five hundred rods, run by every method that keeps to their neighbours") {
  for (const std::string method : {"auto", "dop853", "bdf --rtol 1e-6", "verlet --step 0.05"}) {
    INFO(method);
    const json run = run_json("lattice --set n=4000 --t-end 0.5 --method " + method);
    CHECK(run["outcome"] == "completed");
    CHECK(run["energy_drift_max"].get<double>() < 1e-4 * run["energy_initial"].get<double>());
  }
  for (const std::string method : {"auto", "bdf --rtol 1e-6"}) {
    const json run = run_json("rod_chain --set n=500 --t-end 0.02 --method " + method);
    CHECK(run["constraint_residual_max"].get<double>() < 1e-12);
    // While the chain is level but for its first rods, the last mass falls freely.
    CHECK_THAT(run["q"][999].get<double>(), WithinRel(-0.5 * 9.81 * 0.02 * 0.02, 1e-6));
  }
}

TEST_CASE("what works with dense matrices is refused for many coordinates, and a count beyond its range is") {
  const auto gauss = qdot("run lattice --set n=5000 --method gauss4 --step 0.1");
  CHECK(gauss.status == 2);
  CHECK(gauss.err.find("but gauss4 solves with dense matrices, and the scene has 5000 coordinates (what fits: auto, dop853") != std::string::npos);
  CHECK(qdot("run lattice --set n=1000001").err == "qdot run: --set: n (number of masses) must be a whole number from 1 to 1e+06, given 1000001\n");
  CHECK(qdot("run net --set n=1001").err == "qdot run: --set: n (masses along a side) must be a whole number from 1 to 1000, given 1001\n");
}

TEST_CASE("of very many coordinates a page shows some, and the summary the first") {
  const Directory directory;
  const auto ended = qdot("run string --set n=1000 --quiet --t-end 0.2 --samples 5 --out " + directory.file("string"));
  REQUIRE(ended.status == 0);
  CHECK(ended.out.find("… and 992 more coordinates") != std::string::npos);
  const std::string page = content(directory.file("string.html"));
  CHECK(page.find("y₁ … y₁₀₀₀") != std::string::npos);
  CHECK(page.size() < 2'000'000);
  const std::string csv = content(directory.file("string.csv"));
  CHECK(std::count(csv.begin(), csv.begin() + static_cast<std::ptrdiff_t>(csv.find('\n')), ',') == 2004);
}
