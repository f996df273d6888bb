// SPDX-License-Identifier: MIT
#include "../door_cases.hpp"
#include "hunt.hpp"

std::vector<fuzz::Game> fuzz::interpreted_games() {
  using enum Arguments;
  return {
      {"T(q̇), V(q) of one coordinate", interpreted_energies<1, velocity>},
      {"T(q, q̇), V(q) of two", interpreted_energies<2, state>},
      {"T(q, q̇, t), V(q, t) of two", interpreted_energies<2, state_and_time>},
      {"T(q, q̇), V(q) of three", interpreted_energies<3, state>},
      {"T(q, q̇, t), V(q, t) of four", interpreted_energies<4, state_and_time>},
      {"T(q̇), V(q), n at run time", interpreted_energies<qdot::Dynamic, velocity>},
      {"T(q, q̇), V(q), n at run time", interpreted_energies<qdot::Dynamic, state>},
      {"T(q, q̇, t), V(q, t), n at run time", interpreted_energies<qdot::Dynamic, state_and_time>},
  };
}
