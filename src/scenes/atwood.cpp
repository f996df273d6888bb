// SPDX-License-Identifier: MIT
#include "scenes/atwood.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_atwood() { return runnable(scenes::atwood()); }

}  // namespace qdot::program
