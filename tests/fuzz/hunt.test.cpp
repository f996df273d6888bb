// SPDX-License-Identifier: MIT
//
// A short hunt, for every build; tests/fuzz/hunt.sh is the long one.
#include <cstdint>
#include <string>

#include "catch2_bridge.hpp"
#include "door_cases.hpp"
#include "motions.hpp"
#include "qdot/integrate/cvode.hpp"
#include "seed.hpp"

namespace {

// Cases of one kind, and what they found.
template <class Hunt>
std::string findings(int cases, const Hunt& hunt) {
  fuzz::Report report;
  for (int i = 0; i < cases; ++i) {
    report.where = "case " + std::to_string(i);
    fuzz::Dice dice{fuzz::seed() + 7919 * static_cast<std::uint64_t>(i)};
    hunt(report, fuzz::Dice{dice.next()});
  }
  REQUIRE(report.compared > 0);
  std::string all;
  for (const std::string& finding : report.findings) all += finding + "\n";
  return all;
}

}  // namespace

TEST_CASE("what random T and V give is what hyperdual numbers in quadruple precision give, or an error where these do not exist") {
  INFO(fuzz::seed_text());
  CHECK(findings(15, fuzz::interpreted_energies<2, fuzz::Arguments::state_and_time>) == "");
}

TEST_CASE("four methods bring a random scene to where quadruple precision does, also past an event that changes what its functors read") {
  INFO(fuzz::seed_text());
  CHECK(findings(2, fuzz::captured_constants<2>) == "");
}
