// SPDX-License-Identifier: MIT
#include "scenes/cartpole.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_cartpole() { return runnable(scenes::cartpole()); }

}  // namespace qdot::program
