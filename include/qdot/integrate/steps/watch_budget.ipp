#pragma once
// SPDX-License-Identifier: MIT
//
// The clock of watch_budget.hpp. A program that links qdot::compiled has it from there, and does not read <chrono>.

#include <chrono>

#include "qdot/integrate/steps/watch_budget.hpp"

namespace qdot::detail {

template <class>
double seconds_of_steady_clock() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace qdot::detail
