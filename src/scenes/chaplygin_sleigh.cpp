// SPDX-License-Identifier: MIT
#include "scenes/chaplygin_sleigh.hpp"

#include "program/effect_variants.hpp"
#include "qdot/effects/constraints.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_chaplygin_sleigh() {
  return runnable_with(
      [](const scenes::ChaplyginSleigh&) {
        return std::tuple(nonholonomic("blade", [](const auto& q, const auto& qdot, const auto&) {
          using std::cos, std::sin;
          return qdot[1] * cos(q[2]) - qdot[0] * sin(q[2]);
        }));
      },
      scenes::chaplygin_sleigh());
}

}  // namespace qdot::program
