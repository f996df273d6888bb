// SPDX-License-Identifier: MIT
//
// qdot orbit, where periods, multipliers and special points are known, and what it refuses.
#include <algorithm>
#include <cmath>
#include <complex>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "catch2_bridge.hpp"
#include "command.hpp"

using nlohmann::json;
using program_test::content;
using program_test::qdot;

namespace {

constexpr double closed = 1e-10;  // to which an orbit closes

json answer(const std::string& arguments) {
  const auto ended = qdot("orbit " + arguments + " --json");
  INFO(arguments << ": " << ended.err);
  REQUIRE(ended.status == 0);
  return json::parse(ended.out);
}

double number(const json& value) { return value.get<double>(); }

// 2π √(l/g) / agm(1, cos(amplitude/2)), for l = g.
double swing(double amplitude) {
  double a = 1.0, b = std::cos(0.5 * amplitude);
  for (int k = 0; k < 8; ++k) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  return 2.0 * std::numbers::pi / a;
}

}  // namespace

TEST_CASE("a pendulum swings with the period of the elliptic integral, as one by its angle and as one on a rod") {
  const json one = answer("pendulum --set g=1 --set q0=1.3");
  CHECK_THAT(number(one["period"]), WithinAbs(swing(1.3), closed));
  CHECK_THAT(number(one["energy"]), WithinAbs(-std::cos(1.3), closed));
  CHECK(one["stability"] == "stable to first order");
  CHECK(one["conserves_energy"] == true);
  for (const json& m : one["multipliers"]) CHECK(m["trivial"] == true);
  const json held = answer("pendulum --set g=1 --set q0=1 --period " + std::to_string(swing(1.3)));
  CHECK_THAT(number(held["energy"]), WithinAbs(-std::cos(1.3), 1e-6));  // of the six digits of the period
  const json rod = answer("cartesian_pendulum --set g=1 --set q0=0.8414709848078965 --set q1=-0.5403023058681398");
  CHECK_THAT(number(rod["period"]), WithinAbs(swing(1.0), closed));
}

TEST_CASE("an orbit may turn, bounce, or stand in a frame that is driven") {
  const json round = answer("pendulum --set g=1 --set q0=0 --set qdot0=6");
  // T = (4/v) K(k²) of k² = 4/v², K = π / (2 agm(1, √(1 − k²)))
  double a = 1.0, b = std::sqrt(1.0 - 4.0 / 36.0);
  for (int k = 0; k < 8; ++k) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  CHECK_THAT(number(round["period"]), WithinAbs(2.0 * std::numbers::pi / (6.0 * a), closed));
  const json ball = answer("bouncing_ball --set e=1 --set q0=2");
  CHECK_THAT(number(ball["period"]), WithinAbs(2.0 * std::sqrt(4.0 / 9.81), closed));
  // ẍ = −a x: the multipliers of rest over a period T are exp(±i √a T).
  const json rest = answer("mathieu --set a=2 --set q=0.0 --set q0=0.1 --period-guess 4");
  CHECK_THAT(number(rest["period"]), WithinAbs(std::sqrt(2.0) * std::numbers::pi, closed));
  const json driven = answer("mathieu --set a=2 --set q=1 --set q0=0 --period 3.141592653589793");
  const auto m = [&](std::size_t i) { return std::complex<double>(number(driven["multipliers"][i]["re"]), number(driven["multipliers"][i]["im"])); };
  CHECK_THAT(std::abs(m(0) * m(1)), WithinAbs(1.0, closed));  // areas are kept
}

TEST_CASE("a planet's ellipse has no multipliers but those of its symmetries, which are named") {
  const json planet = answer("kepler");
  CHECK_THAT(number(planet["period"]), WithinAbs(2.0 * std::numbers::pi, closed));
  CHECK(planet["stability"] == "stable to first order");
  CHECK(planet["symmetries"] == json({"time and energy", "rotation of (x, y) and its angular momentum"}));
  CHECK(planet["multipliers"].size() == 4);
  for (const json& m : planet["multipliers"]) CHECK(m["trivial"] == true);
  CHECK(qdot("orbit kepler").out.find("  symmetry       rotation of (x, y) and its angular momentum\n") != std::string::npos);
}

TEST_CASE("along the energy a pendulum's period grows as the elliptic integral does") {
  const program_test::Directory directory;
  const std::string out = directory.file("family");
  const json family = answer("pendulum --set g=1 --set q0=0.3 --along energy=-0.9:0.5 --out " + out);
  CHECK(family["outcome"] == "reached");
  CHECK_THAT(number(family["orbits"][0]["energy"]), WithinAbs(-0.9, closed));
  CHECK(number(family["orbits"].back()["value"]) == number(family["orbits"].back()["energy"]));
  for (const json& orbit : family["orbits"]) CHECK_THAT(number(orbit["period"]), WithinAbs(swing(std::acos(-number(orbit["energy"]))), 10.0 * closed));
  CHECK(content(out + ".csv").starts_with("kind,energy [J],T [s],h [J],stability,largest_re,largest_im,theta [rad],thetadot [rad/s]\n0,-0.9,"));
  CHECK(content(out + ".svg").find(">T [s]<") != std::string::npos);
  CHECK(content(out + ".html").find("Orbits of the family") != std::string::npos);
}

TEST_CASE("along a parameter Mathieu's rest changes where a periodic solution branches off") {
  // Characteristic values of q = 1: b₁ and a₁ of period 2π, by the tridiagonal matrices of the Fourier coefficients in 25 digits.
  const json family = answer("mathieu --set q=1 --set q0=0 --period 3.141592653589793 --along a=-0.2:2.5");
  std::vector<double> doublings;
  for (const json& orbit : family["orbits"])
    if (orbit["kind"] == "period_doubling") doublings.push_back(number(orbit["value"]));
  REQUIRE(doublings.size() == 2);
  constexpr double located = 1e-6;
  CHECK_THAT(doublings[0], WithinAbs(-0.1102488169920971, located));
  CHECK_THAT(doublings[1], WithinAbs(1.8591080725143634, located));
  for (const json& orbit : family["orbits"])
    if (orbit["kind"] == "regular")
      CHECK((orbit["stability"] == "unstable") == (number(orbit["value"]) > doublings[0] && number(orbit["value"]) < doublings[1]));
}

TEST_CASE("a driven pendulum folds twice, and where its swing ceases to be symmetric one multiplier is 1") {
  const json family = answer("pendulum --with damping --with drive --period 3.009100021065971 --set q0=0 --along drive=1:6");
  std::string kinds;
  for (const json& orbit : family["orbits"]) {
    const std::string kind = orbit["kind"];
    if (kind == "regular") continue;
    kinds += kind + " ";
    if (kind != "fold" && kind != "branch") continue;
    CHECK_THAT(number(orbit["multipliers"][0]["re"]),
               WithinAbs(1.0, 1e-5));  // places are located to 1e-8 of a step, along which multipliers go by some hundreds
    CHECK(number(orbit["multipliers"][0]["im"]) == 0.0);
  }
  CHECK(kinds == "start fold fold branch end ");
}

TEST_CASE("the option --out of orbit writes one period, and stdout says what was found") {
  const program_test::Directory directory;
  const std::string out = directory.file("x");
  const auto ended = qdot("orbit pendulum --set q0=1.3 --out " + out);
  REQUIRE(ended.status == 0);
  CHECK(ended.out.starts_with("pendulum: periodic orbit, stable to first order\n  period         2.24107415 s"));
  CHECK(content(out + ".csv").starts_with("t [s],theta [rad],thetadot [rad/s]\n0,1.3,"));
  CHECK(content(out + ".html").find("unit circle") != std::string::npos);
  CHECK(content(out + ".svg").find("Periodic orbit, stable to first order") != std::string::npos);
}

TEST_CASE("two coupled masses that begin between their modes swing in one of them, once in its period, and it is said that this is far from the start") {
  const double together = std::numbers::pi;
  const json found = answer("coupled_oscillators");
  CHECK(number(found["period"]) < together + closed);  // that of the other mode, or of this one
  CHECK(found["swings"] == json({1, 1}));
  CHECK(found["rounds"] == json({0, 0}));
  CHECK_THAT(number(found["moved"][1]), WithinAbs(0.5, 1e-2));  // from 0 to the end of its swing
  const auto said = qdot("orbit coupled_oscillators");
  CHECK(said.out.find("at the start, swings once; sought from 0 m\n") != std::string::npos);
  CHECK(said.out.find("  far from the start that was given, in ") != std::string::npos);
  const json in_mode = answer("coupled_oscillators --set q0=1 --set q1=1");
  CHECK_THAT(number(in_mode["period"]), WithinAbs(together, closed));
  CHECK(qdot("orbit coupled_oscillators --set q0=1 --set q1=1").out.find("far from") == std::string::npos);
}

TEST_CASE("the period of an orbit is the shortest, whatever was guessed, and remains what --period gives") {
  CHECK_THAT(number(answer("coupled_oscillators --set q0=1 --set q1=1 --period-guess 21*pi")["period"]), WithinAbs(std::numbers::pi, closed));
  CHECK_THAT(number(answer("harmonic_oscillator --period-guess 4*pi")["period"]), WithinAbs(std::numbers::pi, closed));
  const json held = answer("harmonic_oscillator --period 4*pi");
  CHECK(number(held["period"]) == 4.0 * std::numbers::pi);
  CHECK(held["swings"] == json({4}));
  const json once = answer("pendulum --set g=1 --set q0=0 --set qdot0=6"), twice = answer("pendulum --set g=1 --set q0=0 --set qdot0=6 --period-guess 2.13");
  CHECK(once["rounds"] == json({1}));
  CHECK(twice["rounds"] == json({1}));
  CHECK_THAT(number(twice["period"]), WithinAbs(number(once["period"]), 10.0 * closed));
}

TEST_CASE("the double pendulum and the star of Hénon and Heiles have orbits, to which an early return leads") {
  for (const std::string scene : {"double_pendulum", "henon_heiles"}) {
    const json orbit = answer(scene);
    CHECK(orbit["outcome"] == "found");
    CHECK(orbit["stability"] == "unstable");
  }
}

TEST_CASE("each swing of an orbit has 64 points in what --out writes") {
  const program_test::Directory directory;
  const std::string out = directory.file("x");
  const json orbit = answer("elastic_pendulum --out " + out);
  int most = 0;
  for (const json& swings : orbit["swings"]) most = std::max(most, swings.get<int>());
  REQUIRE(most > 6);
  const std::string csv = content(out + ".csv");
  CHECK(std::count(csv.begin(), csv.end(), '\n') == 1 + 64 * most + 1);
}

TEST_CASE("a family that shrinks into an equilibrium has one branch point, where the bead rests with the energy of the family") {
  const double g = 9.81;  // of a bead of mass 1 on a hoop of radius 1: h = −½ (g²/Ω² + Ω²) at cos θ = g/Ω²
  const json found = json::parse(qdot("orbit bead_on_hoop --along Omega=:0 --json").out);
  int branches = 0;
  for (const json& orbit : found["orbits"]) {
    if (orbit["kind"] != "branch") continue;
    ++branches;
    const double h = orbit["energy"];
    CHECK_THAT(orbit["value"].get<double>(), WithinAbs(std::sqrt(std::sqrt(h * h - g * g) - h), 1e-5));  // a swing of a few milliradians is left
  }
  CHECK(branches == 1);
}

TEST_CASE("where there is no periodic orbit, the status is 1, and it is said how far the search came") {
  const auto damped = qdot("orbit pendulum --with damping");
  CHECK(damped.status == 1);
  CHECK(damped.out.starts_with("pendulum: no periodic orbit, equilibrium\n"));
  const auto block = qdot("orbit friction_block --json");
  CHECK(block.status == 1);
  CHECK(json::parse(block.out)["outcome"] == "not_closed");
  CHECK(json::parse(block.out)["stability"].is_null());
}

TEST_CASE("what qdot orbit cannot do is refused in words") {
  const auto err = [](const std::string& arguments) {
    const auto ended = qdot("orbit " + arguments);
    INFO(arguments);
    CHECK(ended.status == 2);
    CHECK(ended.out.empty());
    return ended.err;
  };
  CHECK(err("mathieu").find("--period: must be given where something depends on the time") != std::string::npos);
  CHECK(err("pendulum --period 0") == "qdot orbit: --period: must be positive, given 0\n");
  CHECK(err("pendulum --period 2 --hold energy").find("--hold: must be left out where --period holds the period") != std::string::npos);
  CHECK(err("pendulum --hold omega").find("--hold: must be a coordinate or velocity of pendulum") != std::string::npos);
  CHECK(err("pendulum --along energy=1").find("must have the form NAME=FROM:TO") != std::string::npos);
  CHECK(err("pendulum --along l=1:1").find("--along l: must go to another value") != std::string::npos);
  CHECK(err("pendulum --show theta").find("--show: must have the form NAME,NAME") != std::string::npos);
  CHECK(err("mathieu --period 3 --along energy=1:2").find("--along: must name a parameter where the period is that of a drive") != std::string::npos);
  CHECK(err("chain --along n=2:5").find("is a count") != std::string::npos);
}
