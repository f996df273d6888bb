// SPDX-License-Identifier: MIT
#include "scenes/double_pendulum.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_double_pendulum() { return runnable(scenes::double_pendulum()); }

}  // namespace qdot::program
