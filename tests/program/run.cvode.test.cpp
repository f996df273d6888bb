// SPDX-License-Identifier: MIT
//
// The command-line contract, from outside.
#include <cmath>
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

namespace {

// Eight digits, as the contract asks; the reference below was computed in quadruple precision.
constexpr double eight_digits = 5e-9;

}  // namespace

TEST_CASE("the lecture's rod and ring is where it should be after a second") {
  const json run = run_json(
      "rod_and_ring --set M=2 --set L=1.5 --set m=0.3 --set g=9.81 --set q0=0.4 --set q1=0.2 --set qdot0=0.1 "
      "--set qdot1=1 --t-end 1 --rtol 1e-12 --atol 1e-12");
  CHECK_THAT(run["q"][0].get<double>(), WithinRel(3.2329996316785996, eight_digits));
  CHECK_THAT(run["q"][1].get<double>(), WithinRel(-2.3493856325149203, eight_digits));
  CHECK_THAT(run["qdot"][0].get<double>(), WithinRel(11.033246474122167, eight_digits));
  CHECK_THAT(run["qdot"][1].get<double>(), WithinRel(-1.12282143766159, eight_digits));
  CHECK_THAT(run["energy_initial"].get<double>(), WithinRel(3.93279273886127, 1e-14));
}

TEST_CASE("a run's JSON has the keys of the contract") {
  const json run = run_json("pendulum --t-end 2");
  for (const char* key : {"scene", "parameters", "effects", "method", "rtol", "atol", "outcome", "t", "q", "qdot",
                          "energy_initial", "energy_final", "energy_drift_max", "constraint_residual_max", "steps", "rejected",
                          "evaluations", "wall_seconds", "events"}) {
    INFO(key);
    CHECK(run.contains(key));
  }
  CHECK(run["scene"] == "pendulum");
  CHECK(run["parameters"] == json{{"m", 1.0}, {"l", 1.0}, {"g", 9.81}});
  CHECK(run["outcome"] == "completed");
  CHECK(run["t"] == 2.0);
  CHECK(run["effects"] == json::array());
  CHECK(run["events"] == json::array());
  CHECK(run["constraint_residual_max"].is_null());
  CHECK(run["steps"].get<long>() > 0);
}

TEST_CASE("numbers go in and come out unchanged") {
  const json run = run_json("pendulum --set l=0.1234567890123456 --set q0=-1.1000000000000001e-3 --t-end 0.3");
  CHECK(run["parameters"]["l"].get<double>() == 0.1234567890123456);
  CHECK(run["q_initial"][0].get<double>() == -1.1000000000000001e-3);
  CHECK(run["t"].get<double>() == 0.3);
}

TEST_CASE("both methods find the pendulum of the literature") {
  // theta0 = 1 at rest, t = 10; state from an integration in quadruple precision.
  const std::string method = GENERATE("adams", "bdf");
  const json run = run_json("pendulum --set q0=1 --t-end 10 --rtol 1e-11 --atol 1e-11 --method " + method);
  constexpr double growth_of_local_errors = 1e-7;
  CHECK_THAT(run["q"][0].get<double>(), WithinAbs(-0.46325276873178667, growth_of_local_errors));
  CHECK_THAT(run["qdot"][0].get<double>(), WithinAbs(2.6365495135496304, growth_of_local_errors));
  CHECK(run["method"] == method);
}

TEST_CASE("an accuracy is that of the whole motion, and chooses the tolerances") {
  // theta1, theta2 of the double pendulum from (1.7, 1.7) at rest, t = 3, from quadruple precision.
  const json run = run_json("double_pendulum --t-end 3 --accuracy 1e-9");
  CHECK_THAT(run["q"][0].get<double>(), WithinAbs(1.9234881444441958, 1e-9));
  CHECK_THAT(run["q"][1].get<double>(), WithinAbs(1.1485248782344042, 1e-9));
  CHECK(run["error_estimate"].get<double>() <= 1e-9);
  CHECK(run["rtol"].get<double>() < 1e-9);
}

TEST_CASE("Jacobi's energy stays where T + V does not") {
  const json run = run_json("bead_on_hoop --rtol 1e-11 --atol 1e-11");
  CHECK(run["energy_drift_max"].get<double>() > 1.0);
  CHECK(run["jacobi_energy_drift_max"].get<double>() < 1e-7);
}

TEST_CASE("where T is not quadratic in the velocities the summary says what is conserved instead of T + V") {
  const std::string remark = "and Jacobi's h takes the place of T + V\n  Jacobi's h ";
  CHECK(qdot("run bead_on_hoop --quiet").out.find(remark) != std::string::npos);
  CHECK(qdot("run pendulum --quiet").out.find("Jacobi's") == std::string::npos);
}

TEST_CASE("the number of links of a chain is a parameter") {
  const json run = run_json("chain --set n=3 --set q2=0.5 --t-end 0.1");
  CHECK(run["parameters"]["n"].is_number_integer());
  CHECK(run["q"].size() == 3);
  CHECK(run["q_initial"][2] == 0.5);
}

TEST_CASE("the condition of M is looked at, and a double pendulum's is worst where it is straight") {
  // M = m l² [2, cos; cos, 1], scaled to unit diagonal: pivots 1 and 1 − cos²(q0 − q1)/2, one half at the start.
  const json run = run_json("double_pendulum --set m1=1 --set m2=1 --set q0=0.3 --set q1=0.3 --t-end 2");
  CHECK_THAT(run["mass_rcond_min"].get<double>(), WithinAbs(0.5, 1e-12));
}

TEST_CASE("T and V of a scene are formulas, whatever values its effects take") {
  CHECK(qdot("equations bouncing_ball").out.find("Accelerations\n") != std::string::npos);
  CHECK(qdot("list rope_pendulum").out.find("\n  V = m g y\n") != std::string::npos);
}

TEST_CASE("every scene of the list runs with its defaults") {
  const auto listed = qdot("list --json");
  REQUIRE(listed.status == 0);
  const json scenes = json::parse(listed.out)["scenes"];
  CHECK(scenes.size() >= 13);
  for (const json& scene : scenes) {
    const std::string name = scene["name"];
    INFO(name);
    const json run = run_json(name + " --t-end 0.5");
    CHECK(run["q"].size() == scene["degrees_of_freedom"]);
    for (const json& parameter : scene["parameters"]) {
      CHECK(run["parameters"][parameter["name"].get<std::string>()] == parameter["default"]);
    }
  }
}

TEST_CASE("every scene of the list moves alike by dual numbers, by lines and by machine code") {
  // A few hundredths of a second or year: q̇ differs by what rounding of q̈ adds up to in so short a time.
  constexpr double rounding = 1e-12;
  for (const json& scene : json::parse(qdot("list --json").out)["scenes"]) {
    const std::string name = scene["name"], run = name + " --method dop853 --rtol 1e-12 --atol 1e-12 --samples 2 --t-end 0.02 --by ";
    const json by_duals = run_json(run + "duals");
    INFO(name);
    CHECK(by_duals["evaluated_by"] == "dual numbers, as asked");
    for (const char* way : {"lines", "machine_code"}) {
      INFO(way);
      const json other = run_json(run + way);
      for (std::size_t i = 0; i < other["qdot"].size(); ++i) {
        const double expected = by_duals["qdot"][i], speed = other["qdot"][i];
        CHECK(std::abs(speed - expected) <= rounding * std::max(1.0, std::abs(expected)));
      }
    }
  }
}

TEST_CASE("a way to evaluate that does not exist is refused by the names of those that do") {
  const auto refused = qdot("run pendulum --by hand");
  CHECK(refused.status == 2);
  CHECK(refused.err.find("--by: must be a way to evaluate T and V, given \"hand\"") != std::string::npos);
}

TEST_CASE("the option --out writes the table, the arrays, the page and the picture, and nothing else") {
  const Directory directory;
  const auto ended = qdot("run double_pendulum --t-end 1 --samples 11 --out " + directory.file("dp"));
  REQUIRE(ended.status == 0);
  CHECK(directory.entries() == 4);
  const std::string csv = program_test::content(directory.file("dp.csv"));
  CHECK(csv.substr(0, csv.find('\n')) ==
        "t [s],theta1 [rad],theta2 [rad],theta1dot [rad/s],theta2dot [rad/s],kinetic_energy [J],potential_energy "
        "[J],energy [J],jacobi_energy [J]");
  CHECK(std::count(csv.begin(), csv.end(), '\n') == 12);
  CHECK(program_test::content(directory.file("dp.npz")).substr(0, 4) == "PK\x03\x04");
  const std::string page = program_test::content(directory.file("dp.html"));
  CHECK(page.find("<canvas") != std::string::npos);
  CHECK(page.find("</html>") != std::string::npos);
}

TEST_CASE("a run that fails ends with status 1, and its JSON says how far it came") {
  const Directory directory;
  const auto ended = qdot("run kepler --set qdot1=0 --json --out " + directory.file("fall"));
  CHECK(ended.status == 1);
  const json run = json::parse(ended.out);
  CHECK(run["outcome"] != "completed");
  // A fall from rest at r = 0.4 into mu = 1 takes pi sqrt(r^3 / 8).
  CHECK_THAT(run["t"].get<double>(), WithinAbs(3.141592653589793 * std::sqrt(0.064 / 8.0), 1e-6));
  CHECK(directory.entries() == 4);
}

TEST_CASE("equations that cannot be evaluated at the start are an outcome too") {
  const auto ended = qdot("run spherical_pendulum --set q0=0 --json");
  CHECK(ended.status == 1);
  const json run = json::parse(ended.out);
  CHECK(run["outcome"] == "singular_mass_matrix");
  CHECK(run["message"].get<std::string>().find("phi") != std::string::npos);
  CHECK(run["steps"] == 0);
}

TEST_CASE("equations are printed as formulas, and written as a C file") {
  const auto ended = qdot("equations rod_and_ring");
  CHECK(ended.status == 0);
  CHECK(ended.out.find("  r̈ = r φ̇² − g sin φ\n") != std::string::npos);
  CHECK(qdot("equations rod_and_ring --latex").out.find("\\ddot{r} &= r \\dot{\\phi}^{2} - g \\sin \\phi") != std::string::npos);
  CHECK(qdot("equations four_bar").out.find("  a sin θ₁ + b sin θ₂ − c sin θ₃ = 0\n") != std::string::npos);
  const Directory directory;
  CHECK(qdot("equations rod_and_ring --c '" + directory.file("rod.c") + "'").status == 0);
  CHECK(program_test::content(directory.file("rod.c")).find("int rod_and_ring_jacobian(") != std::string::npos);
}

TEST_CASE("forces that are asked for are arrows in the picture, and the page says how large the largest is") {
  const Directory directory;
  const auto ended = qdot("run cartesian_pendulum --quiet --t-end 2 --forces --out '" + directory.file("rod") + "'");
  INFO(ended.err);
  REQUIRE(ended.status == 0);
  const std::string page = content(directory.file("rod.html"));
  CHECK(page.find("longest arrow") != std::string::npos);
  CHECK(page.find("of constraint forces") != std::string::npos);
  CHECK(page.find("of applied forces") == std::string::npos);
  const auto pushed = qdot("run cartpole --quiet --t-end 1 --with motor=6 --forces --out '" + directory.file("push") + "'");
  REQUIRE(pushed.status == 0);
  CHECK(content(directory.file("push.html")).find("of applied forces") != std::string::npos);
}

TEST_CASE("arrows of forces that there are none of are refused before the run") {
  const Directory directory;
  const auto bare = qdot("run pendulum --forces --out '" + directory.file("x") + "'");
  CHECK(bare.status == 2);
  CHECK(bare.err.find("--forces: must stand with constraints or effects, but pendulum has T and V alone") != std::string::npos);
  CHECK(directory.entries() == 0);
  CHECK(qdot("run cartesian_pendulum --forces").err.find("--forces: must stand with --out PATH") != std::string::npos);
}
