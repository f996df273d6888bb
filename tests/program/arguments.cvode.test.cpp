// SPDX-License-Identifier: MIT
//
// Bad arguments: status 2, nothing on stdout, and one line on stderr with argument, rule, value, and nearest name.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "catch2_bridge.hpp"
#include "command.hpp"

using program_test::Directory;
using program_test::qdot;

namespace {

struct Refusal {
  const char* arguments;
  const char* message;
};

}  // namespace

TEST_CASE("a bad argument gets one line that says what is wrong") {
  const Refusal refusal = GENERATE(values<Refusal>({
      {"",
       "qdot: command: must be one of list, new, run, accuracy, effects, equations, modes, equilibria, conserved, lyapunov, section, orbit, sensitivity, sweep, bench; see qdot --help\n"},
      {"rnu",
       "qdot: command: must be a command, given \"rnu\"; the nearest is \"run\" (of list, new, run, accuracy, effects, equations, modes, equilibria, conserved, lyapunov, section, orbit, sensitivity, sweep, bench)\n"},
      {"run pendulum --set lenght=2",
       "qdot run: --set: must be a parameter or initial value of pendulum, given \"lenght\"; the nearest is \"l\" (of m, l, g, "
       "theta, q0, thetadot, qdot0)\n"},
      {"run bead_on_hoop --set omega=1", "qdot run: --set: must be a parameter or initial value of bead_on_hoop, given \"omega\"; the nearest is \"Omega\""},
      {"run bead_on_hoop --set thta=1", "qdot run: --set: must be a parameter or initial value of bead_on_hoop, given \"thta\"; the nearest is \"theta\""},
      {"run pendulum --set xy=1", "qdot run: --set: must be a parameter or initial value of pendulum, given \"xy\"; there are (m, l, g, theta, q0, "},
      {"run pendulum --set l=0", "qdot run: --set: l (length of the rod) must be positive, given 0\n"},
      {"run pendulum --set m=-1", "qdot run: --set: m (mass of the bob) must be positive, given -1\n"},
      {"run pendulum --set l=nan", "qdot run: --set l: must be a finite number, given \"nan\"; type one such as 0.5, 1e-3, pi/2, -3*pi/4 or 90deg\n"},
      {"run pendulum --set q0=1x", "qdot run: --set q0: must be a finite number, given \"1x\"; type one such as 0.5, 1e-3, pi/2, -3*pi/4 or 90deg\n"},
      {"run pendulum --set q0=pi/0", "qdot run: --set q0: must be a finite number, given \"pi/0\"; type one such as "},
      {"run pendulum --set l", "qdot run: --set: must have the form NAME=VALUE, given \"l\"\n"},
      {"run chain --set n=2.5",
       "qdot run: --set: n (number of links) must be a whole number from 1 to 500, given 2.5\n"},
      {"run pendulum --t-end 0", "qdot run: --t-end: must be after the start, t = 0, given 0\n"},
      {"run pendulum --t-end -1", "qdot run: --t-end: must be after the start, t = 0, given -1\n"},
      {"run pendulum --t-end nan", "qdot run: --t-end: must be a finite number, given \"nan\"; type one such as 0.5, 1e-3, pi/2, -3*pi/4 or 90deg\n"},
      {"run pendulum --t-end", "qdot run: --t-end: must be followed by one value, given none\n"},
      {"run pendulum --rtol 0", "qdot run: --rtol: must be positive, given 0\n"},
      {"run pendulum --atol -1e-3", "qdot run: --atol: must be positive, given -1e-3\n"},
      {"run pendulum --method adam",
       "qdot run: --method: must be a method, given \"adam\"; the nearest is \"adams\""},
      {"run kepler --with friction=0.1",
       "qdot run: --with: must name an effect of the scene; kepler has no effect \"friction\" (it has none)\n"},
      {"run pendulum --with dampin=0.1",
       "qdot run: --with: must be an effect of pendulum, given \"dampin\"; the nearest is \"damping\" (of damping, drive)\n"},
      {"run pendulum --without dampin",
       "qdot run: --without: must be an effect of pendulum, given \"dampin\"; the nearest is \"damping\" (of damping, drive)\n"},
      {"run pendulum --with damping=-1",
       "qdot run: --with: damping (torque per angular velocity in the pivot) must be zero or positive, given -1\n"},
      {"effects pendulm", "qdot effects: SCENE: must be a scene, given \"pendulm\"; the nearest is \"pendulum\""},
      {"equations pendulm", "qdot equations: SCENE: must be a scene, given \"pendulm\"; the nearest is \"pendulum\""},
      {"equations", "qdot equations: SCENE"},
      {"equations kepler --latex --mathml", "qdot equations: --latex: must stand without --mathml, given together with it\n"},
      {"equations kepler --latex --c kepler.c", "qdot equations: --c: must stand without --latex and --mathml, given together with one\n"},
      {"equations kepler --c", "qdot equations: --c: must be followed by one value, given none\n"},
      {"equations four_bar --c four_bar.c",
       "qdot equations: --c: a C file must be of T and V alone, but there are also 2 constraints; take coordinates that meet them by themselves\n"},
      {"equations kepler --set m=1", "qdot equations: --set"},
      {"equations chain --set n=17", "qdot equations: SCENE: must have at most 16 coordinates for formulas of it, but has 17\n"},
      {"run pendulum --samples 1", "qdot run: --samples: must be a whole number from 2 to 10000000, given \"1\"\n"},
      {"run pendulum --out ''",
       "qdot run: --out: must be a path whose last part is a file's name, given \"\"\n"},
      {"bench foo", "qdot bench: NAME: must be a benchmark, given \"foo\""},
      {"run pendulm", "qdot run: SCENE: must be a scene, given \"pendulm\"; the nearest is \"pendulum\""},
      {"list cartpol", "qdot list: SCENE: must be a scene, given \"cartpol\"; the nearest is \"cartpole\""},
      {"list cartpole kepler", "qdot list: arguments: must be options after the first, given \"kepler\"\n"},
      {"run double", "qdot run: SCENE: must be a scene, given \"double\"; the nearest is \"double_pendulum\""},
      {"run pendulum --jsno", "qdot run: --jsno: must be an option of qdot run, given \"--jsno\"; the nearest is \"--json\""},
      {"run pendulum --rtol 1e-20", "qdot run: rtol must lie between 2.3e-15"},
  }));
  const auto ended = qdot(refusal.arguments);
  INFO(refusal.arguments);
  CHECK(ended.status == 2);
  CHECK(ended.out.empty());
  CHECK(ended.err.substr(0, std::string(refusal.message).size()) == refusal.message);
  CHECK(std::count(ended.err.begin(), ended.err.end(), '\n') == 1);
}

TEST_CASE("a number may have factors, pi and degrees, and is the double of the same expression in C++") {
  constexpr double pi = std::numbers::pi;
  const std::vector<std::pair<std::string, double>> meant = {
      {"pi/2", pi / 2.0}, {"-pi/4", -pi / 4.0}, {"+pi", pi}, {"2*pi/3", 2.0 * pi / 3.0}, {"0.5*pi", 0.5 * pi}, {".5pi", 0.5 * pi}, {"90deg", pi / 2.0},
      {"-60deg", -60.0 / 180.0 * pi}, {"1/3", 1.0 / 3.0}, {"1e-3", 1e-3}, {"1/2*3", 0.5 * 3.0}, {"1e1deg/2", 10.0 / 180.0 * pi / 2.0}};
  for (const auto& [text, value] : meant) {
    INFO(text);
    const auto ended = qdot("run pendulum --t-end pi/100 --json --set q0=" + text);
    REQUIRE(ended.status == 0);
    const auto run = nlohmann::json::parse(ended.out);
    CHECK(run["q_initial"][0].get<double>() == value);
    CHECK(run["t"].get<double>() == pi / 100.0);
  }
  for (const std::string text : {"", "-", "--1", "+-1", "pi2", "pipi", "2**pi", "2*", "/2", "*pi", "2*-pi", "90 deg", "deg", "pideg", "90degdeg", "90d", "Pi",
                                 "pi/0", "1e", "1e999", "0x10", "inf"}) {
    INFO(text);
    const auto ended = qdot("run pendulum --t-end 1 --set 'q0=" + text + "'");
    CHECK(ended.status == 2);
    CHECK(ended.err == "qdot run: --set q0: must be a finite number, given \"" + text + "\"; type one such as 0.5, 1e-3, pi/2, -3*pi/4 or 90deg\n");
  }
}

TEST_CASE("numbers with pi stand in ranges, conditions and lists as well") {
  const auto rows = [](const std::string& over, const std::string& angle) {
    const auto ended = qdot("sweep pendulum --over q0=" + over + " --record 't(|theta|=" + angle + ")' --t-end 2 --json --quiet");
    INFO(over << " " << angle << ": " << ended.err);
    REQUIRE(ended.status == 0);
    return nlohmann::json::parse(ended.out)["rows"];
  };
  const auto plain = rows("-1.5707963267948966,0,1.5707963267948966", "0.7853981633974483");
  CHECK(plain[0][1].is_number());
  CHECK(rows("-pi/2:pi/2:3", "pi/4") == plain);
  CHECK(rows("-90deg,0,pi/2", "45deg") == plain);
}

TEST_CASE("an output that cannot be written is refused before the run and leaves nothing") {
  const Directory directory;
  { std::ofstream file(directory.file("file")); }
  const auto ended = qdot("run pendulum --out " + directory.file("file/x"));
  CHECK(ended.status == 2);
  CHECK(ended.out.empty());
  CHECK(ended.err.find("--out: ") != std::string::npos);
  CHECK(ended.err.find("file/x.csv") != std::string::npos);
  CHECK(directory.entries() == 1);
}

TEST_CASE("a directory to write to is made where it is missing") {
  const Directory directory;
  REQUIRE(qdot("run pendulum --t-end 1 --quiet --out " + directory.file("new/and/below/x")).status == 0);
  CHECK_FALSE(program_test::content(directory.file("new/and/below/x.csv")).empty());
}

TEST_CASE("without the program of a benchmark beside it qdot bench says how to build that") {
  const Directory directory;
  std::filesystem::copy_file(QDOT_PROGRAM, directory.file("qdot"));
  const auto alone = program_test::ended(directory.file("qdot"), "bench eom");
  CHECK(alone.status == 2);
  CHECK(alone.out.empty());
  CHECK(alone.err == "qdot bench: bench: must find the program qdot-bench-eom beside qdot, but " + directory.file("qdot-bench-eom") +
                         " cannot be started; build the target qdot_bench_eom, or type ./run bench eom\n");
}

TEST_CASE("qdot bench runs the benchmarks beside it in turn, and makes one object of them") {
  const Directory directory;
  std::filesystem::copy_file(QDOT_PROGRAM, directory.file("qdot"));
  std::string object;
  for (const std::string name : {"eom", "scenes", "ensemble", "many", "large", "steppers", "energy", "sensitivities", "hard", "compile"}) {
    const std::string program = directory.file("qdot-bench-" + name);
    { std::ofstream(program) << "#!/bin/sh\nprintf '  \"" << name << "\": \"%s\"' \"$*\"\n" << (name == "hard" ? "exit 1\n" : ""); }
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    object += (object.empty() ? "{\n  \"" : ",\n  \"") + name + "\": \"member\"";
  }
  const auto all = program_test::ended(directory.file("qdot"), "bench --json");
  CHECK(all.out == object + "\n}\n");
  CHECK(all.status == 1);
  CHECK(program_test::ended(directory.file("qdot"), "bench many --json").out == "  \"many\": \"json\"");
  CHECK(program_test::ended(directory.file("qdot"), "bench hard --page p").out == "  \"hard\": \"text p\"");
  CHECK(program_test::ended(directory.file("qdot"), "bench many --page p").status == 2);
}

TEST_CASE("a scene can be listed alone, with the units and meanings of its parameters, its start and its effects") {
  const auto listed = qdot("list cartpole");
  CHECK(listed.status == 0);
  CHECK(listed.err.empty());
  CHECK(listed.out.starts_with("cartpole: Cart and pole\n"));
  for (const char* row : {"  M                           2  kg         mass of the cart; positive\n", "  q1                        2.8  rad        theta\n",
                          "  qdot1                       0  rad/s      thetadot\n", "  joint_damping "})
    CHECK(listed.out.find(row) != std::string::npos);
  CHECK(listed.out.find("pendulum hung") != std::string::npos);
  CHECK(listed.out.find("\n  T = ½ ") != std::string::npos);
  CHECK(listed.out.find("\n  V = ") != std::string::npos);
  CHECK(listed.out.ends_with("\nfor example: qdot run cartpole --set M=4 --with motor=12 --out out/cartpole\n"));
  CHECK(listed.out.find("kepler") == std::string::npos);
  const auto json = qdot("list cartpole --json");
  CHECK(json.status == 0);
  CHECK(json.out.find("\"cartpole\"") != std::string::npos);
  CHECK(json.out.find("\"kepler\"") == std::string::npos);
}

TEST_CASE("help and version are no errors") {
  CHECK(qdot("--help").status == 0);
  CHECK(qdot("run --help").out.find("--t-end") != std::string::npos);
  CHECK(qdot("--version").out.substr(0, 5) == "qdot ");
}

TEST_CASE("nothing is printed on stderr when all goes well") { CHECK(qdot("run pendulum --t-end 1").err.empty()); }

TEST_CASE("output that is not taken is no success") {
  if (!std::filesystem::exists("/dev/full")) return;  // a device of Linux
  for (const std::string arguments : {"list", "run pendulum --t-end 1 --json", "sweep pendulum --over l=1,2 --t-end 1", "--version"}) {
    const auto ended = program_test::ended("/bin/sh", "-c '" QDOT_PROGRAM " " + arguments + " > /dev/full'");
    CHECK(ended.status == 1);
    CHECK(ended.err.find(": standard output must take all that is printed, but did not; make room where it goes, or send it elsewhere\n") != std::string::npos);
  }
}
