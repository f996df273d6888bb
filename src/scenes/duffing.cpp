// SPDX-License-Identifier: MIT
#include "scenes/duffing.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_duffing() { return runnable(scenes::duffing()); }

}  // namespace qdot::program
