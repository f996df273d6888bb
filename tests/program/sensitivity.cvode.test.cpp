// SPDX-License-Identifier: MIT
//
// qdot sensitivity, against closed forms, and what it refuses.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "catch2_bridge.hpp"
#include "command.hpp"

using nlohmann::json;
using program_test::content;
using program_test::qdot;

namespace {

constexpr double integrated = 1e-9;  // at the default tolerance, 1e-11 in each step

struct Answer {
  json found;

  explicit Answer(const std::string& arguments) {
    const auto ended = qdot("sensitivity " + arguments + " --json");
    INFO(arguments << ": " << ended.err);
    REQUIRE(ended.status == 0);
    found = json::parse(ended.out);
  }
  double operator()(const std::string& of, const std::string& to, const char* what = "derivative") const {
    for (std::size_t i = 0; i < found["of"].size(); ++i)
      for (std::size_t j = 0; j < found["to"].size(); ++j)
        if (found["of"][i] == of && found["to"][j]["name"] == to) return found[what][i][j].get<double>();
    FAIL("there is no derivative of " << of << " by " << to);
    return 0.0;
  }
};

}  // namespace

TEST_CASE("an oscillator depends on its mass, its spring and its start as the cosine says") {
  // x = cos ωt, ω² = k/m
  const double k = 4.0, m = 1.0, t = 3.0, omega = 2.0;
  const Answer d("harmonic_oscillator --t-end 3");
  CHECK_THAT(d("x", "k"), WithinAbs(-std::sin(omega * t) * t / (2.0 * omega * m), integrated));
  CHECK_THAT(d("x", "m"), WithinAbs(std::sin(omega * t) * t * k / (2.0 * omega * m * m), integrated));
  CHECK_THAT(d("x", "x at the start"), WithinAbs(std::cos(omega * t), integrated));
  CHECK_THAT(d("x", "xdot at the start"), WithinAbs(std::sin(omega * t) / omega, integrated));
  CHECK_THAT(d("xdot", "x at the start"), WithinAbs(-omega * std::sin(omega * t), integrated));
  for (const json& row : d.found["error"])
    for (const json& error : row) CHECK(error.get<double>() < integrated);
}

TEST_CASE("a ball behind a bounce depends on everything as the closed form says") {
  // y = e v s − g s²/2 with the impact at t₁ = √(2h/g), v = g t₁ and s = t − t₁
  const double h = 1.0, g = 9.81, e = 0.8, t = 1.0, t1 = std::sqrt(2.0 * h / g), v = g * t1, s = t - t1;
  const Answer d("bouncing_ball --t-end 1");
  const auto by = [&](double t1_slope, double v_slope, double g_slope) {
    return e * v_slope * s - e * v * t1_slope + g * s * t1_slope - 0.5 * s * s * g_slope;
  };
  CHECK_THAT(d("y", "e"), WithinAbs(v * s, integrated));
  CHECK_THAT(d("y", "y at the start"), WithinAbs(by(1.0 / v, g / v, 0.0), integrated));
  CHECK_THAT(d("y", "g"), WithinAbs(by(-h / (g * v), h / v, 1.0), integrated));
  CHECK_THAT(d("y", "m"), WithinAbs(0.0, integrated));
}

TEST_CASE("on a rod a motion depends on gravity as the motion in an angle does, and a start is put onto the rod") {
  const Answer angle("pendulum --t-end 2 --set q0=1"), rod("cartesian_pendulum --t-end 2 --set q0=0.8414709848078965 --set q1=-0.5403023058681398");
  const double theta = angle.found["values"][0].get<double>();
  CHECK_THAT(rod("x", "g"), WithinAbs(std::cos(theta) * angle("theta", "g"), integrated));
  CHECK_THAT(rod("y", "g"), WithinAbs(std::sin(theta) * angle("theta", "g"), integrated));
  CHECK_THAT(rod("x", "x at the start"), WithinAbs(std::cos(theta) * angle("theta", "theta at the start") * std::cos(1.0), integrated));
}

TEST_CASE("on constraints columns are those of the start that is put onto them: a sleigh's side speed turns it") {
  // The nearest velocity in the metric of M: of ẏ the blade takes the impulse −J, J a = I_tip Δω with I_tip = I + m a².
  const double m = 1.0, I = 0.3, a = 0.5;
  const Answer d("chaplygin_sleigh --t-end 4");
  for (const char* of : {"x", "y", "theta", "xdot", "ydot", "thetadot"})
    CHECK_THAT(d(of, "ydot at the start"), WithinAbs(m * a / (I + m * a * a) * d(of, "thetadot at the start"), integrated));
}

TEST_CASE("on constraints all columns are those of differences of runs, with starts that go with parameters") {
  // Order six, and runs at 1e-13.
  constexpr double h = 1e-4, differenced = 2e-7;
  const std::string scene = GENERATE(std::string("four_bar"), "slider_crank", "cartesian_pendulum --set q0=1.2");  // the last one off its rod
  const Answer d(scene + " --t-end 1");
  const auto end = [&](const std::string& name, double value) {
    const auto ran = qdot("run " + scene + " --t-end 1 --rtol 1e-13 --atol 1e-13 --json --quiet --set " + name + "=" + json(value).dump());
    REQUIRE(ran.status == 0);
    return json::parse(ran.out)["q"][0].get<double>();
  };
  for (const json& to : d.found["to"]) {
    const std::string whole = to["name"], name = whole.substr(0, whole.find(' '));
    INFO(scene << " by " << name);
    const double value = to["value"];
    double slope = 0.0;
    const double weights[] = {0.75, -0.15, 1 / 60.0};
    for (int k = 1; k <= 3; ++k) slope += weights[k - 1] * (end(name, value + k * h) - end(name, value - k * h)) / h;
    CHECK_THAT(d(d.found["of"][0], whole), WithinAbs(slope, differenced * (1.0 + std::abs(slope))));
  }
}

TEST_CASE("effects that are on are what a motion depends on, and a rope does not ask for the mass that it holds") {
  const Answer d("pendulum --with damping=0.5 --of theta --to damping,l,thetadot --t-end 4"),
      less("pendulum --with damping=0.49999 --of theta --to l --t-end 4"),
      more("pendulum --with damping=0.50001 --of theta --to l --t-end 4");
  REQUIRE(d.found["of"].size() == 1);
  REQUIRE(d.found["to"].size() == 3);
  constexpr double differenced = 1e-6;
  CHECK_THAT(d("theta", "damping"), WithinAbs((more.found["values"][0].get<double>() - less.found["values"][0].get<double>()) / 2e-5, differenced));
  const Answer rope("rope_pendulum --t-end 3");  // slack, taut and slack again
  CHECK_THAT(rope("y", "m"), WithinAbs(0.0, integrated));
  CHECK(std::abs(rope("y", "l")) > 1.0);
}

TEST_CASE("the option --out of sensitivity writes the whole motion, and stdout has the largest first") {
  const program_test::Directory directory;
  const std::string out = directory.file("x");
  const auto ended = qdot("sensitivity harmonic_oscillator --of x --t-end 1 --samples 10 --out " + out);
  REQUIRE(ended.status == 0);
  CHECK(ended.out.starts_with("harmonic_oscillator: completed at t = 1 s\n\nx = -0.41614684 m depends on\n"));
  CHECK(ended.out.find("  m                      0.90929742") < ended.out.find("  xdot at the start      0.4546487"));
  const std::string table = content(out + ".csv");
  CHECK(table.starts_with("t [s],x [m],d(x)/d(m) [m/kg],d(x)/d(xdot at the start) [m/(m/s)],d(x)/d(x at the start),d(x)/d(k) [m/(N/m)]\n0,1,0,0,1,0\n"));
  CHECK(std::count(table.begin(), table.end(), '\n') == 12);
  CHECK(content(out + ".html").find("x at t = 1 s depends on") != std::string::npos);
  CHECK(content(out + ".svg").find("What x depends on") != std::string::npos);
}

TEST_CASE("every method that takes derivatives along finds those of the oscillator, and those of a rod that it keeps") {
  const double t = 3.0, omega = 2.0;  // ω² = k/m = 4
  for (const auto& [method, error] : {std::pair{"dop853", 1e-9}, {"dopri5", 1e-9}, {"adams", 1e-7}, {"bdf", 1e-6}, {"taylor", 1e-10},
                                      {"gauss4", 1e-7}, {"gauss8", 1e-9}}) {
    INFO(method);
    const Answer d(std::string("harmonic_oscillator --t-end 3 --method ") + method);
    CHECK(d.found["method"] == method);
    CHECK_THAT(d("x", "k"), WithinAbs(-std::sin(omega * t) * t / (2.0 * omega), error));
    CHECK_THAT(d("x", "m"), WithinAbs(std::sin(omega * t) * t, 4.0 * error));
    CHECK_THAT(d("x", "xdot at the start"), WithinAbs(std::sin(omega * t) / omega, error));
  }
  const std::string start =
      " --t-end 2 --set q0=0.8414709848078965 --set q1=-0.5403023058681398 --set qdot0=0.5403023058681398 --set qdot1=0.8414709848078965 --with drag=0.2";
  const Answer known("cartesian_pendulum" + start);
  // What bdf says of itself is the difference to a run of another tolerance, which by chance may be less than its error of 4e-9.
  for (const auto& [method, more] : {std::pair{"taylor", 0.0}, {"gauss8", 0.0}, {"bdf", 4e-9}}) {
    INFO(method);
    const Answer rod("cartesian_pendulum" + start + " --method " + std::string(method));
    for (const char* to : {"g", "l", "drag", "xdot at the start"}) {
      CHECK_THAT(rod("y", to), WithinAbs(known("y", to), integrated + more + rod("y", to, "error")));  // as far as it says itself
      CHECK(rod("y", to, "error") < 1e-4);
    }
  }
}

TEST_CASE("where a motion has no derivative the status is 1, and what was asked wrongly is refused") {
  const auto grazing = qdot("sensitivity bouncing_ball --set q0=0 --set qdot0=-1 --t-end 1");  // begins in the moment of an impact
  CHECK(grazing.status == 1);
  const auto err = [](const std::string& arguments) {
    const auto ended = qdot("sensitivity " + arguments);
    INFO(arguments);
    CHECK(ended.status == 2);
    CHECK(ended.out.empty());
    return ended.err;
  };
  CHECK(err("pendulum --of omega").find("--of: must be a coordinate or velocity of pendulum") != std::string::npos);
  CHECK(err("pendulum --to damping")
            .find("--to: must be a parameter, an effect that is on, or a coordinate or velocity of the start, given \"damping\"") !=
        std::string::npos);
  CHECK(err("pendulum --t-end 0") == "qdot sensitivity: --t-end: must differ from the time of the start, given 0\n");
  CHECK(err("pendulum --method verlet") ==
        "qdot sensitivity: --method: must fit pendulum and take its derivatives along, but verlet makes steps of the motion alone "
        "(what fits: taylor, dop853, dopri5, adams, bdf, gauss2, gauss4, gauss6, gauss8)\n");
  CHECK(err("pendulum --method auto").find("but auto chooses by the motion alone (what fits: taylor") != std::string::npos);
  CHECK(err("bouncing_ball --method gauss4")
            .find("but gauss4 takes no contacts or dry friction with derivatives (what fits: dop853, dopri5, ") != std::string::npos);
  CHECK(
      err("cartesian_pendulum --method adams").find("but adams cannot keep constraints (what fits: taylor, dop853, dopri5, bdf, gauss2") !=
      std::string::npos);
  CHECK(err("pendulum --method euler").find("--method: must be a method") != std::string::npos);
  CHECK(
      err("pendulum --step 0.1") ==
      "qdot sensitivity: --step: must stand with a method of fixed step, gauss2 … gauss8, given with dop853, which chooses its steps by --rtol\n");
  CHECK(err("pendulum --rtol 0") == "qdot sensitivity: --rtol: must be positive, given 0\n");
}
