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
