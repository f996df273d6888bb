// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench scenes`: scenes of the catalogue with their effects.
#include "bench/scenes.hpp"

#include <vector>

#include "bench/measured_scenes.hpp"

namespace qdot::bench {

std::vector<SceneRow> system_scene_rows() {
  std::vector<SceneRow> rows = rows_of_cases<CartpoleWithMotor, CartpoleWithMotorAndFriction, CartesianPendulumOnRod, CartesianPendulumInAir, TautRope,
                                             FourBarLinkage, DrivenFourBar, SliderAndCrank, RollingHoopHolonomic, RollingHoopNonholonomic, SleighOnBlade,
                                             SlidingBlock, SprungDoublePendulum>();
  const std::vector<SceneRow> in_a_run =
      rows_in_a_run<CartpoleWithMotor, CartpoleWithMotorAndFriction, CartesianPendulumOnRod, CartesianPendulumInAir, TautRope, FourBarLinkage, DrivenFourBar,
                    SliderAndCrank, RollingHoopHolonomic, SleighOnBlade>();
  rows.insert(rows.end(), in_a_run.begin(), in_a_run.end());
  return rows;
}

}  // namespace qdot::bench
