// SPDX-License-Identifier: MIT
#include "scenes/spherical_pendulum.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_spherical_pendulum() { return runnable(scenes::spherical_pendulum()); }

}  // namespace qdot::program
