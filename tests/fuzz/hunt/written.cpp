// SPDX-License-Identifier: MIT
//
// Types that hold formulas of their own. QDOT_FUZZ_TYPES makes others of them.
#include "../door_cases.hpp"
#include "hunt.hpp"

#ifndef QDOT_FUZZ_TYPES
#define QDOT_FUZZ_TYPES 1
#endif

std::vector<fuzz::Game> fuzz::written_games() {
  using enum Arguments;
  constexpr std::uint64_t types = 100 * static_cast<std::uint64_t>(QDOT_FUZZ_TYPES);
  return {
      {"written T(q, q̇), V(q) of one coordinate", written_energies<types + 1, 1, state>},
      {"written T(q̇), V(q) of two", written_energies<types + 2, 2, velocity>},
      {"written T(q, q̇), V(q) of two", written_energies<types + 3, 2, state>},
      {"written T(q, q̇, t), V(q, t) of two", written_energies<types + 4, 2, state_and_time>},
      {"written T(q, q̇), V(q) of three", written_energies<types + 5, 3, state>},
      {"written places of two", written_places<types + 6, 2, false>},
      {"written places that move, of one", written_places<types + 7, 1, true>},
  };
}
