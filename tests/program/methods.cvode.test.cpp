// SPDX-License-Identifier: MIT
//
// Methods by their names, from outside.
#include <nlohmann/json.hpp>
#include <string>

#include "catch2_bridge.hpp"
#include "command.hpp"
#include "run_json.hpp"

using nlohmann::json;
using program_test::qdot;
using program_test::run_json;

namespace {

std::string refused(const std::string& arguments) {
  const auto ended = qdot("run " + arguments);
  CHECK(ended.status == 2);
  CHECK(ended.err.find('\n') == ended.err.size() - 1);
  return ended.err;
}

}  // namespace

TEST_CASE("every method finds the pendulum of the literature") {
  // theta0 = 1 at rest, t = 10; state from an integration in quadruple precision.
  const std::string method = GENERATE("taylor", "dopri5", "gauss4", "gauss6", "gauss8", "blanes_moan_4", "kahan_li_6", "blanes_moan_6", "kahan_li_8");
  INFO(method);
  const json run = run_json("pendulum --set q0=1 --t-end 10 --rtol 1e-9 --atol 1e-9 --method " + method);
  constexpr double growth_of_local_errors = 1e-6;
  CHECK_THAT(run["q"][0].get<double>(), WithinAbs(-0.46325276873178667, growth_of_local_errors));
  CHECK(run["method"] == method);
  CHECK(run["method_reason"].is_null());
  CHECK(run["step"].is_null() == (method == "taylor" || method == "dopri5"));
}

TEST_CASE("a cart with a motor moves the same by every method that takes effects") {
  const std::string method = GENERATE("taylor", "gauss6", "gauss8");
  INFO(method);
  const std::string span = "cartpole --with motor=6 --with joint_damping --t-end 2 --rtol 1e-10 --atol 1e-10 --method ";
  const json run = run_json(span + method),
             exact = run_json("cartpole --with motor=6 --with joint_damping --t-end 2 --rtol 1e-13 --atol 1e-13 --method dop853");
  constexpr double growth_of_local_errors = 1e-8;
  for (const char* const of : {"q", "qdot"})
    for (std::size_t i = 0; i < 2; ++i) CHECK_THAT(run[of][i].get<double>(), WithinAbs(exact[of][i].get<double>(), growth_of_local_errors));
}

TEST_CASE("a pendulum in Cartesian coordinates is at rest again after its period by every method that takes constraints") {
  const std::string method = GENERATE("dop853", "bdf", "gauss4", "gauss8", "rattle4", "rattle6");
  INFO(method);
  // From 1 rad, l = 1 m and g = 9.81 m/s²: 4 sqrt(l/g) K(sin² 1/2).
  const json run = run_json(
      "cartesian_pendulum --set q0=0.8414709848078965 --set q1=-0.5403023058681398 --t-end 2.13913760055869 --rtol 1e-9 --atol 1e-9 --method " +
      method);
  CHECK_THAT(run["q"][0].get<double>(), WithinAbs(0.8414709848078965, 1e-6));
  CHECK_THAT(run["qdot"][0].get<double>(), WithinAbs(0.0, 1e-6));
  CHECK(run["constraint_residual_max"] < 1e-12);
}

TEST_CASE("a fixed step is the one asked for") {
  const json run = run_json("pendulum --t-end 10 --method verlet --step 0.01");
  CHECK(run["steps"] == 1000);
  CHECK(run["step"] == 0.01);
}

TEST_CASE("without a method the program chooses, and says what and why") {
  const json smooth = run_json("pendulum");
  CHECK(smooth["method"] == "auto");
  CHECK(smooth["method_chosen"] == "taylor");
  CHECK(smooth["method_reason"].get<std::string>().find("taylor: ") == 0);
  const json stiff = run_json("pendulum --with damping=1e5 --t-end 50 --rtol 1e-6 --atol 1e-6");
  CHECK(stiff["method_chosen"] == "taylor, cvode_bdf");
  CHECK(stiff["evaluations"] < 2000);
  const json driven = run_json("cartpole --with motor=6");
  CHECK(driven["method_chosen"] == "taylor");
  CHECK(driven["method_reason"].get<std::string>().find("taylor: T, V and the forces are formulas") == 0);
  const json constrained = run_json("cartesian_pendulum");
  CHECK(constrained["method_chosen"] == "taylor");
  CHECK(constrained["method_reason"].get<std::string>().find("taylor: T, V, the forces and the constraints are formulas") == 0);
  CHECK(constrained["constraint_residual_max"] < 1e-9);
  const json switching = run_json("rope_pendulum");
  CHECK(switching["method_chosen"] == "dop853");
  CHECK(switching["method_reason"].get<std::string>().find("dop853: equations that switch have no power series") == 0);
  const auto text = qdot("run pendulum");
  CHECK(text.out.find("  chose taylor: ") != std::string::npos);
}

TEST_CASE("a method that does not fit is refused with the reason and what does fit") {
  CHECK(refused("double_pendulum --method verlet") ==
        "qdot run: --method: must fit double_pendulum, but verlet needs T(qdot), and the scene's T depends on the coordinates (what fits: auto, "
        "taylor, dop853, dopri5, adams, bdf, gauss2, gauss4, gauss6, gauss8)\n");
  CHECK(refused("pendulum --with damping --method verlet") ==
        "qdot run: --method: must fit pendulum, but verlet takes T and V alone, and the scene has effects (what fits: auto, taylor, dop853, "
        "dopri5, adams, bdf, gauss2, gauss4, gauss6, gauss8)\n");
  CHECK(refused("rope_pendulum --method taylor").find("must fit rope_pendulum, but taylor takes no contacts or dry friction (what fits: ") !=
        std::string::npos);
  CHECK(refused("cartesian_pendulum --with drag --method rattle4").find("but rattle4 needs T(qdot), V(q) and holonomic constraints, and no forces") !=
        std::string::npos);
  CHECK(refused("cartesian_pendulum --method adams") ==
        "qdot run: --method: must fit cartesian_pendulum, but adams cannot keep constraints (what fits: auto, taylor, dop853, dopri5, bdf, gauss2, "
        "gauss4, gauss6, gauss8, rattle2, rattle4, rattle6)\n");
  CHECK(refused("pendulum --step 0.1").find("--step: must stand with a method of fixed step") != std::string::npos);
  CHECK(refused("pendulum --method gauss4 --step 0").find("--step: must be positive") != std::string::npos);
}

TEST_CASE("the list of scenes ends with the methods") {
  const json methods = json::parse(qdot("list --json").out)["methods"];
  CHECK(methods[0] == "auto");
  CHECK(methods.size() == 20);
  CHECK(qdot("list").out.find("\nbdf ") != std::string::npos);
}
