#pragma once
// SPDX-License-Identifier: MIT
//
// The benchmarks' names: src/bench/NAME.cpp and NAME_*.cpp are the program qdot-bench-NAME. src/CMakeLists.txt and ./run read them here.

#include <array>
#include <string_view>

namespace qdot::bench {

inline constexpr std::array<std::string_view, 10> names{"eom", "scenes", "ensemble", "many", "large", "steppers", "energy", "sensitivities", "hard", "compile"};

}  // namespace qdot::bench
