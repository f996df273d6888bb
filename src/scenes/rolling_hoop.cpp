// SPDX-License-Identifier: MIT
#include "scenes/rolling_hoop.hpp"

#include "program/effect_variants.hpp"
#include "qdot/effects/constraints.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_rolling_hoop() {
  using scenes::RollingHoop;
  return runnable_with(
      [](const RollingHoop& p) { return std::tuple(holonomic("rolling", [R = p.R](const auto& q) { return q[0] - R * q[1]; })); },
      scenes::rolling_hoop());
}

}  // namespace qdot::program
