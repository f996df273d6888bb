// SPDX-License-Identifier: MIT
#include "qdot/mechanics/written_out_kinematics.hpp"

#include <type_traits>

#include "bench/chain_energies.hpp"
#include "catch2_bridge.hpp"

using namespace qdot;

#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
TEST_CASE("the deprecated word written_out_kinematic_system is kinematic_system") {
  const State<2> at{0.0, {0.4, -0.3}, {0.2, 0.5}};
  const bench::LoopedPositions place;
  const auto gravity = gravity_along<1>(-9.81);
  const auto flywheel = [](const auto& v) { return 0.7 * v[0] * v[0]; };
  const auto plain = kinematic_system<2>(place, gravity), old = written_out_kinematic_system<2>(place, gravity);
  STATIC_REQUIRE(std::is_same_v<decltype(old), decltype(plain)>);
  CHECK(acceleration(old, at) == acceleration(plain, at));
  CHECK(acceleration(written_out_kinematic_system<2>(place, gravity, flywheel), at) == acceleration(kinematic_system<2>(place, gravity, flywheel), at));
  CHECK(acceleration(written_out_kinematic_system<2>(place), at) == acceleration(kinematic_system<2>(place), at));
}
