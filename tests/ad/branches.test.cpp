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

TEST_CASE("a functor that asks again, the other way round or with another sign, hears what it heard before") {
  // Sorting asks a < b and later b < a. On the other side of the first answer both must hold, though the value is on this side.
  const auto asks_again = [](const auto& x) {
    const auto a = x * x, b = x + 2.0;
    const bool below = a < b, above = b < a, again = a < b, minus = -b < -a;
    const double code = (below ? 1.0 : 0.0) + (above ? 2.0 : 0.0) + (again ? 4.0 : 0.0) + (minus ? 8.0 : 0.0);
    return code * x / x;
  };
  const Run here(asks_again, 1.0);
  CHECK(here.value == 1.0 + 4.0 + 8.0);
  std::vector<formula::Guard> flipped{here.branches.met[0]};
  flipped[0].sign = -flipped[0].sign;
  flipped[0].closed = !flipped[0].closed;
  CHECK(Run(asks_again, 1.0, &flipped).value == 2.0);
  const auto one_product = [](const auto& x) {  // a node, and the node times −1
    const auto p = x * sin(x);
    return ((p > 0.0 ? 1.0 : 0.0) + (-p > 0.0 ? 2.0 : 0.0) + (0.0 > p ? 4.0 : 0.0)) * x / x;
  };
  const Run positive(one_product, 1.0);
  CHECK(positive.value == 1.0);
  std::vector<formula::Guard> negative{positive.branches.met[0]};
  negative[0].sign = -negative[0].sign;
  negative[0].closed = !negative[0].closed;
  CHECK(Run(one_product, 1.0, &negative).value == 6.0);
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

TEST_CASE("a loop that waits for a comparison for too long is not recorded") {
  const auto waits = [](const auto& x, double step) {
    int n = 0;
    for (auto e = x * x + 1.0; e > 0.0; e = e - step) ++n;
    return n * x;
  };
  CHECK(Run([&](const auto& x) { return waits(x, 0.1); }, 2.0).value == 2.0 * 50);
  CHECK_THROWS_AS(Run([&](const auto& x) { return waits(x, 1e-7); }, 2.0), NotAnalytic);
}
