// SPDX-License-Identifier: MIT
#include "qdot/report/still.hpp"

#include <string>

#include "catch2_bridge.hpp"

using namespace qdot::report;

namespace {

Animation swinging() {
  return {.drawing = {.shapes = {trail(1), line({0, 1}), spring(0, 1), pivot(0), disk(1), box(1, 0.5, 0.25), ellipse(0, 1, 2)}},
          .times = {0.0, 1.0, 2.0},
          .frames = {{{0, 0}, {-1, -1}, {1, 1}}, {{0, 0}, {0, -1}, {1, 1}}, {{0, 0}, {1, -1}, {1, 1}}}};
}

}  // namespace

TEST_CASE("a still shows the last frame that is not after its time, and the way there") {
  // The plane from −1 to 1 fills 380 px less margins of 24 px: 166 px per unit, the origin in the middle.
  const std::string text = still_svg(swinging(), 1.5, Plot{});
  CHECK(text.find("<circle cx=\"190\" cy=\"356\" r=\"9\"") != std::string::npos);  // the bob at (0, −1)
  CHECK(text.find("d=\"M24 356L190 356\"") != std::string::npos);                   // its trail from (−1, −1)
  CHECK(text.find("nan") == std::string::npos);
}

TEST_CASE("a still of an animation without frames is refused") {
  CHECK_THROWS_AS(still_svg(Animation{}, 0.0, Plot{}), qdot::InvalidValue);
}

TEST_CASE("an arrow of a still is a line with a head at its second point, and nothing where it has no length") {
  Animation animation{.drawing = {.shapes = {arrow(0, 1, 3), arrow(0, 0, 4)}}, .times = {0.0}, .frames = {{{0, 0}, {1, 0}}}};
  const std::string text = still_svg(animation, 0.0, Plot{});
  // 332 px for the one unit between margins of 24 px, at half height; the head is 9 px long, the line ends inside of it.
  CHECK(text.find("M24 190L348.8 190") != std::string::npos);
  CHECK(text.find("M356 190L347 194.05L347 185.95z\" style=\"fill:var(--s3)\"") != std::string::npos);
  CHECK(text.find("stroke:var(--s4)") == std::string::npos);
}
