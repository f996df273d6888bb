// SPDX-License-Identifier: MIT
#include "qdot/integrate/outcome.hpp"

#include <cctype>
#include <set>
#include <string>

#include "catch2_bridge.hpp"

using qdot::Outcome;

namespace {
constexpr int last = static_cast<int>(Outcome::solver_error);
}

TEST_CASE("every outcome has a snake_case name of its own") {
  std::set<std::string> names;
  for (int i = 0; i <= last; ++i) {
    const std::string name(qdot::name(static_cast<Outcome>(i)));
    REQUIRE(!name.empty());
    REQUIRE(name != "unknown");
    for (const char c : name) REQUIRE((c == '_' || std::islower(static_cast<unsigned char>(c))));
    REQUIRE(names.insert(name).second);
  }
  REQUIRE(qdot::name(Outcome::completed) == "completed");
}

TEST_CASE("every outcome has one sentence of advice that ends in a full stop") {
  for (int i = 0; i <= last; ++i) {
    const std::string advice(qdot::advice(static_cast<Outcome>(i)));
    REQUIRE(advice.size() > 10);
    REQUIRE(advice.back() == '.');
    REQUIRE(advice.find(". ") == std::string::npos);
  }
}

TEST_CASE("a run failed unless it was completed or somebody stopped it") {
  REQUIRE(!qdot::failed(Outcome::completed));
  REQUIRE(!qdot::failed(Outcome::stopped_by_observer));
  REQUIRE(!qdot::failed(Outcome::stopped_by_model));
  REQUIRE(!qdot::failed(Outcome::stopped_by_event));
  REQUIRE(qdot::failed(Outcome::zeno));
  REQUIRE(qdot::failed(Outcome::step_limit));
  REQUIRE(qdot::failed(Outcome::non_finite));
}
