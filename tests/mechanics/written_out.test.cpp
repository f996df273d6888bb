// SPDX-License-Identifier: MIT
#include "qdot/mechanics/written_out.hpp"

#include <type_traits>

#include "bench/chain_energies.hpp"
#include "catch2_bridge.hpp"
#include "qdot/mechanics/equations_of_motion.hpp"

using namespace qdot;

#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
TEST_CASE("the deprecated word written_out leaves energies as they are") {
  const State<2> at{0.0, {0.4, -0.3}, {0.2, 0.5}};
  const bench::LoopedChain chain{.g = 3.7};
  STATIC_REQUIRE(std::is_same_v<decltype(written_out<2>(chain)), bench::LoopedChain>);
  CHECK(acceleration(mechanical_system<2>(written_out<2>(chain)), at) == acceleration(mechanical_system<2>(chain), at));
  const auto T = [](const auto& v) { return 0.5 * v.squaredNorm(); };
  const auto V = [k = 2.0](const auto& q) { return 0.5 * k * q.squaredNorm(); };
  CHECK(acceleration(mechanical_system<2>(written_out<2>(T, V)), at) == acceleration(mechanical_system<2>(T, V), at));
}
