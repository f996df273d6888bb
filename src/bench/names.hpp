#pragma once
// SPDX-License-Identifier: MIT
//
// The benchmarks' names, for the program that does not have them linked in.

#include <array>
#include <string_view>

namespace qdot::bench {

inline constexpr std::array<std::string_view, 10> names{"eom", "scenes", "ensemble", "many", "large", "steppers", "energy", "sensitivities", "hard", "compile"};

}  // namespace qdot::bench
