// SPDX-License-Identifier: MIT
//
// Recordings that are given values take the branch of these values, and note on which guards it depends.

#include "qdot/ad/formula/branches.hpp"

#include <vector>

#include "catch2_bridge.hpp"
#include "qdot/ad/formula/recording.hpp"
#include "qdot/error.hpp"

using namespace qdot;
using formula::Recorded;

namespace {

// f(x) at x, on the branch of x, or on that of the answers.
struct Run {
  formula::Branches branches{};
  formula::Recording recording{};
  double value = 0.0;

  Run(const auto& f, double x, const std::vector<formula::Guard>* answers = nullptr) {
    branches.variables = {x};
    branches.answers = answers;
    recording.branches = &branches;
    const Recorded result = f(Recorded(recording, formula::variable_in(recording, 0)));
    const int node = result.node_in(recording);
    std::vector<double> values;
    formula::evaluate_nodes(recording.graph, branches.variables, values, recording.graph.nodes().size());
    value = values[static_cast<std::size_t>(node)];
  }
  double guard(std::size_t k) const {
    const formula::Guard& g = branches.met[k];
    return g.sign * (branches.values[static_cast<std::size_t>(g.node)] - g.level);
  }
};

}  // namespace

TEST_CASE("a recording with values takes their branch and keeps how far its guards are") {
  const auto wall = [](const auto& x) { return x < 2.0 ? 3.0 * x : x * x + 2.0; };
  const Run below(wall, 0.5), beyond(wall, 5.0);
  CHECK(below.value == 1.5);
  CHECK(beyond.value == 27.0);
  REQUIRE(below.branches.met.size() == 1);
  CHECK(below.guard(0) == 1.5);   // 2 − x
  CHECK(beyond.guard(0) == 3.0);  // x − 2
  CHECK_FALSE(below.branches.met[0].closed);
  CHECK(beyond.branches.met[0].closed);  // x < 2 is false at 2
  CHECK(below.branches.met[0].what == "the comparison < in T or V");
}

TEST_CASE("given answers hold on the other side, too") {
  const auto wall = [](const auto& x) { return x < 2.0 ? 3.0 * x : x * x + 2.0; };
  const Run below(wall, 0.5);
  const Run forced(wall, 5.0, &below.branches.met);
  CHECK(forced.value == 15.0);
}

TEST_CASE("abs, max, min, floor and ceil are branches") {
  CHECK(Run([](const auto& x) { return abs(x) + max(x, Recorded(1.0)) + min(x, Recorded(1.0)); }, -3.0).value == 3.0 + 1.0 - 3.0);
  const Run stair([](const auto& x) { return x - floor(x) + ceil(x); }, 2.25);
  CHECK(stair.value == 0.25 + 3.0);
  REQUIRE(stair.branches.met.size() == 4);
  CHECK(stair.guard(0) == 0.25);  // x − 2
  CHECK(stair.guard(1) == 0.75);  // 3 − x
}

TEST_CASE("the root of a square is a magnitude") {
  const Run root([](const auto& x) { return sqrt(x * x); }, -3.0);
  CHECK(root.value == 3.0);
  CHECK(root.branches.met.size() == 1);
}

TEST_CASE("without values a comparison is refused") {
  formula::Recording recording;
  const Recorded x(recording, formula::variable_in(recording, 0));
  CHECK_THROWS_AS((void)(x < 1.0), NotAnalytic);
  CHECK_THROWS_AS(floor(x), NotAnalytic);
}
