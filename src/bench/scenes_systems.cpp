// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench scenes`: scenes of the catalogue with their effects.
#include "bench/measured_scenes.hpp"
#include "bench/scenes.hpp"

namespace qdot::bench {

std::vector<SceneRow> system_scene_rows() {
  return rows_of_cases<CartpoleWithMotor, CartpoleWithMotorAndFriction, CartesianPendulumOnRod, CartesianPendulumInAir, TautRope,
                       FourBarLinkage, DrivenFourBar, SliderAndCrank, RollingHoopHolonomic, RollingHoopNonholonomic, SleighOnBlade,
                       SlidingBlock, SprungDoublePendulum>();
}

}  // namespace qdot::bench
