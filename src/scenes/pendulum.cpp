// SPDX-License-Identifier: MIT
#include "scenes/pendulum.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_pendulum() { return runnable(scenes::pendulum()); }

}  // namespace qdot::program
