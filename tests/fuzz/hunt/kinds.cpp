// SPDX-License-Identifier: MIT
#include "../kind_cases.hpp"
#include "hunt.hpp"

std::vector<fuzz::Game> fuzz::kind_games() {
  return {
      {"other units", in_other_units},
      {"switches by place and time", switched},
      {"plates on five legs", supported},
  };
}
