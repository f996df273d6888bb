#pragma once
// SPDX-License-Identifier: MIT
//
// How scenes showed space before pictures had cameras (report/animation.hpp): by a projection of their own, for ever from one side.

#include "qdot/report/animation.hpp"

namespace qdot::scenes {

[[deprecated("give the point {x, y, z} itself, and .drawing = in_space({...}), which the reader turns")]]
inline report::Point seen(double x, double y, double z) {
  return report::seen_from({}, {x, y, z});
}

}  // namespace qdot::scenes
