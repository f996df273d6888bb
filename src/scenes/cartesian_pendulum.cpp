// SPDX-License-Identifier: MIT
#include "scenes/cartesian_pendulum.hpp"

#include "program/effect_variants.hpp"
#include "qdot/effects/constraints.hpp"
#include "qdot/effects/dissipation.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_cartesian_pendulum() {
  using scenes::CartesianPendulum, scenes::optional_effect, scenes::Range;
  return runnable_with(
      [](const CartesianPendulum& s) {
        return std::tuple(holonomic("rod", [l = s.l](const auto& q) { return 0.5 * (q[0] * q[0] + q[1] * q[1] - l * l); }));
      },
      scenes::cartesian_pendulum(),
      optional_effect<CartesianPendulum>("drag", 0.1, "kg/m", Range::non_negative, "force per squared speed against the motion",
                                         [](const CartesianPendulum&, double b) {
                                           return quadratic_drag([](const auto& q) { return q; }, b);
                                         }));
}

}  // namespace qdot::program
