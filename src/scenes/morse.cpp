// SPDX-License-Identifier: MIT
#include "scenes/morse.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_morse() { return runnable(scenes::morse()); }

}  // namespace qdot::program
