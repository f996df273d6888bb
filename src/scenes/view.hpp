#pragma once
// SPDX-License-Identifier: MIT
//
// How a plane picture shows space: parallel projection, seen from 25° to the side and 20° above; z stays upright.

#include "qdot/report/animation.hpp"

namespace qdot::scenes {

/// Where a point of space appears in the picture.
inline report::Point seen(double x, double y, double z) {
  constexpr double cos_side = 0.90630778703664996, sin_side = 0.42261826174069944;  // 25°
  constexpr double cos_above = 0.93969262078590838, sin_above = 0.34202014332566873;  // 20°
  return {cos_side * x + sin_side * y, cos_above * z + sin_above * (cos_side * y - sin_side * x)};
}

}  // namespace qdot::scenes
