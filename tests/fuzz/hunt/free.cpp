// SPDX-License-Identifier: MIT
#include "../free_cases.hpp"
#include "hunt.hpp"

std::vector<fuzz::Game> fuzz::free_games() {
  return {
      {"any clock", anytime<2>},
      {"a push in time", pushed},
      {"a ball on a floor", bouncing},
      {"events to count", counted},
  };
}
