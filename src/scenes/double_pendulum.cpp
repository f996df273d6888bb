// SPDX-License-Identifier: MIT
#include "scenes/double_pendulum.hpp"

#include "program/effect_variants.hpp"
#include "qdot/effects/dissipation.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_double_pendulum() {
  using scenes::DoublePendulum, scenes::optional_effect, scenes::Range;
  return runnable(scenes::double_pendulum(),
                  optional_effect<DoublePendulum>(
                      "joint_friction", 0.1, "N m s", Range::non_negative, "torque per angular velocity in each joint",
                      [](const DoublePendulum&, double c) {
                        return rayleigh([c](const auto&, const auto& qdot) {
                          const auto bend = qdot[1] - qdot[0];
                          return 0.5 * c * (qdot[0] * qdot[0] + bend * bend);
                        });
                      }));
}

}  // namespace qdot::program
