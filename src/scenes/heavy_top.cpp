// SPDX-License-Identifier: MIT
#include "scenes/heavy_top.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_heavy_top() { return runnable(scenes::heavy_top()); }

}  // namespace qdot::program
