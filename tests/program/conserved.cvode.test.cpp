// SPDX-License-Identifier: MIT
//
// qdot conserved, of scenes whose symmetries are known.
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "catch2_bridge.hpp"
#include "command.hpp"

using nlohmann::json;
using program_test::qdot;

namespace {

json answer(const std::string& arguments) {
  const auto ended = qdot(arguments + " --json");
  INFO(ended.err);
  REQUIRE(ended.status == 0);
  return json::parse(ended.out);
}

std::vector<std::string> names(const json& list) {
  std::vector<std::string> all;
  for (const json& entry : list) all.push_back(entry["name"]);
  return all;
}
using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("a heavy top conserves two momenta and the energy") {
  const json top = answer("conserved heavy_top");
  CHECK(names(top["conserved"]) == Names{"p_phi", "p_psi", "h", "T + V"});
  CHECK(names(top["not_found"]) == Names{"p_theta"});
  // p_psi = I3 (psidot + phidot cos theta), p_phi = p_psi cos theta with the axis at rest
  CHECK_THAT(top["conserved"][1]["at_start"].get<double>(), WithinRel(5.6, 1e-14));
  CHECK_THAT(top["conserved"][0]["at_start"].get<double>(), WithinRel(5.6 * std::cos(0.6), 1e-14));
}

TEST_CASE("a driven hoop conserves Jacobi's integral alone, and drag leaves nothing") {
  CHECK(names(answer("conserved bead_on_hoop")["conserved"]) == Names{"h"});
  CHECK(names(answer("conserved cartesian_pendulum")["conserved"]) == Names{"h", "T + V"});
  CHECK(names(answer("conserved cartesian_pendulum --with drag")["conserved"]).empty());
}

TEST_CASE("what friction that sticks does is not found, and said so") {
  const json block = answer("conserved friction_block");
  CHECK(names(block["conserved"]).empty());
  CHECK(block["not_found"][1]["reason"] == "an effect switches or is no formula, so it is not known whether it does work");
}
