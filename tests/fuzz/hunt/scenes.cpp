// SPDX-License-Identifier: MIT
#include "../scene_cases.hpp"
#include "hunt.hpp"

std::vector<fuzz::Game> fuzz::scene_games() {
  return {
      {"captured constants", captured_constants<2>},
      {"springs and drag", springs_and_drag<2>},
      {"constraints", constrained<3>},
      {"a drive, n at run time", driven},
      {"a controller", controlled},
  };
}
