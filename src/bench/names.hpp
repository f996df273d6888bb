#pragma once
// SPDX-License-Identifier: MIT
//
// The benchmarks' names, for the program that does not have them linked in.

#include <array>
#include <string_view>

namespace qdot::bench {

inline constexpr std::array<std::string_view, 9> names{"eom", "scenes", "ensemble", "many", "steppers", "energy", "sensitivities", "hard", "compile"};

}  // namespace qdot::bench
