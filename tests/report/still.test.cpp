// SPDX-License-Identifier: MIT
#include "qdot/report/still.hpp"

#include <cmath>
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

TEST_CASE("a still of a picture in space is that of the plane picture that its camera sees") {
  // From 25° to the side and 20° above: x goes to (cos 25°, −sin 20° sin 25°), y to (sin 25°, sin 20° cos 25°), z to (0, cos 20°).
  const Animation space{.drawing = in_space({line({0, 1, 2, 3})}), .times = {0.0}, .frames = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
  const Animation plane{.drawing = {.shapes = {line({0, 1, 2, 3})}},
                        .times = {0.0},
                        .frames = {{{0, 0}, {0.90630778703665, -0.14454395845}, {0.42261826174070, 0.30997551921}, {0, 0.93969262078591}}}};
  CHECK(still_svg(space, 0.0, Plot{}) == still_svg(plane, 0.0, Plot{}));
  const Point above = seen_from({.side = 0, .above = 90}, {1, 2, 3});  // a map, north up
  CHECK(above.x == 1);
  CHECK(std::abs(above.y - 2) < 1e-15);
}

TEST_CASE("an arrow of a still is a line with a head at its second point, and nothing where it has no length") {
  Animation animation{.drawing = {.shapes = {arrow(0, 1, 3), arrow(0, 0, 4)}}, .times = {0.0}, .frames = {{{0, 0}, {1, 0}}}};
  const std::string text = still_svg(animation, 0.0, Plot{});
  // 332 px for the one unit between margins of 24 px, at half height; the head is 9 px long, the line ends inside of it.
  CHECK(text.find("M24 190L348.8 190") != std::string::npos);
  CHECK(text.find("M356 190L347 194.05L347 185.95z\" style=\"fill:var(--s3)\"") != std::string::npos);
  CHECK(text.find("stroke:var(--s4)") == std::string::npos);
}
