#pragma once
// SPDX-License-Identifier: MIT
//
// Many motions of one system, as `bench many` and the peers measure them: the starts, and what a problem is called.

#include <cstddef>
#include <type_traits>

#include "bench/chain_energies.hpp"
#include "qdot/integrate/counter_random.hpp"
#include "qdot/mechanics/system.hpp"
#include "scenes/double_pendulum.hpp"
#include "scenes/kepler.hpp"

namespace qdot::bench {

inline constexpr std::size_t motions = 512;
inline constexpr double duration = 5.0;

// Angles of some tenths of a radian to one radian, or orbits that do not come near the centre.
template <int n>
State<n> start_of_many(std::size_t i, double lowest, double highest, double fastest) {
  CounterRandom random(1, i);
  State<n> start;
  start.t = 0.0;
  for (int j = 0; j < n; ++j) start.q[j] = random.uniform(lowest, highest);
  for (int j = 0; j < n; ++j) start.qdot[j] = random.uniform(-fastest, fastest);
  return start;
}

// visit(name, system, start_of) for each.
template <class Visit>
void for_each_of_many(const Visit& visit) {
  const auto swinging = [&](const char* name, const auto& system) {
    visit(name, system, [](std::size_t i) { return start_of_many<std::remove_cvref_t<decltype(system)>::dof_at_compile_time>(i, -1.0, 1.0, 1.0); });
  };
  swinging("double_pendulum", mechanical_system<2>(scenes::DoublePendulum{}));
  visit("kepler", mechanical_system<2>(scenes::Kepler{}), [](std::size_t i) { return start_of_many<2>(i, 0.8, 1.2, 0.5); });
  swinging("chain 2", mechanical_system<2>(UnrolledChain<2>{}));
  swinging("chain 3", mechanical_system<3>(UnrolledChain<3>{}));
  swinging("chain 4", mechanical_system<4>(UnrolledChain<4>{}));
}

}  // namespace qdot::bench
