// SPDX-License-Identifier: MIT
#include "scenes/string.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_string() { return runnable(scenes::string()); }

}  // namespace qdot::program
