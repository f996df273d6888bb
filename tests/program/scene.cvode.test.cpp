// SPDX-License-Identifier: MIT
//
// What one says about a scene, as data.
#include <limits>
#include <vector>

#include "catch2_bridge.hpp"
#include "scenes/scene.hpp"

using namespace qdot;
using namespace qdot::scenes;
using qdot::scenes::Scene;

namespace {

struct Parameters {
  double l = 3.0;
};

}  // namespace

TEST_CASE("a range says which values are physical, and how") {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  CHECK(Range::any.holds(-1e300));
  CHECK_FALSE(Range::any.holds(infinity));
  CHECK_FALSE(Range::any.holds(std::numeric_limits<double>::quiet_NaN()));
  CHECK_FALSE(Range::positive.holds(0.0));
  CHECK(Range::positive.holds(1e-300));
  CHECK(Range::non_negative.holds(0.0));
  CHECK_FALSE(Range::non_negative.holds(-1e-300));
  CHECK(Range::between(0, 1).holds(1.0));
  CHECK_FALSE(Range::between(0, 1).holds(1.1));
  CHECK(Range::any.text() == "any");
  CHECK(Range::positive.text() == "positive");
  CHECK(Range::non_negative.text() == "zero or positive");
  CHECK(Range::between(-1, 2.5).text() == "from -1 to 2.5");
}

TEST_CASE("a start is a list of coordinates, with velocities or at rest, a state, or a function of the parameters") {
  const Parameters p;
  const Start<Parameters, 2> at_rest = {1.0, 2.0}, moving = {1.0, 2.0, 3.0, 4.0}, nowhere = {};
  CHECK(at_rest(p).q == Vector<double, 2>(1.0, 2.0));
  CHECK(at_rest(p).qdot == Vector<double, 2>(0.0, 0.0));
  CHECK(moving(p).q == Vector<double, 2>(1.0, 2.0));
  CHECK(moving(p).qdot == Vector<double, 2>(3.0, 4.0));
  CHECK_FALSE(nowhere);
  const Start<Parameters, 2> later = State<2>{5.0, {1.0, 2.0}, {0.0, 0.0}};
  CHECK(later(p).t == 5.0);
  const Start<Parameters, 2> by_length = [](const Parameters& s) { return State<2>{0.0, {s.l, 0.0}, {0.0, 0.0}}; };
  CHECK(by_length(p).q[0] == 3.0);
  const Start<Parameters, 2> three = {1.0, 2.0, 3.0};
  CHECK_THROWS_WITH(three(p), "start must have one number for each coordinate, or those and one for each velocity, 2 or 4 of them, but has 3");
}

TEST_CASE("coordinates and drawings are lists or functions of the parameters, and positions may depend on the time") {
  Scene<Parameters, 1> scene{.coordinates = {{"theta", "rad"}}, .drawing = {report::line({0, 1})}};
  const Parameters p;
  REQUIRE(scene.coordinates(p).size() == 1);
  CHECK(scene.coordinates(p)[0].name == "theta");
  CHECK(scene.coordinates(p)[0].unit == "rad");
  CHECK(scene.drawing(p).shapes.size() == 1);
  CHECK_FALSE(scene.positions);
  scene.drawing = [](const Parameters& s) -> Drawing { return {.backdrop = {{{0.0, 0.0}, {s.l, 0.0}}}}; };
  CHECK(scene.drawing(p).backdrop[0][1].x == 3.0);
  scene.positions = [](const Parameters& s, const auto& q) -> std::vector<Point> { return {{s.l, q[0]}}; };
  CHECK(scene.positions(p, Vector<double, 1>(7.0), 0.0)[0].y == 7.0);
  scene.positions = [](const Parameters&, const auto& q, double t) -> std::vector<Point> { return {{t, q[0]}}; };
  CHECK(scene.positions(p, Vector<double, 1>(7.0), 2.0)[0].x == 2.0);
}
