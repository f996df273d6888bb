// SPDX-License-Identifier: MIT
#include "scenes/charged_particle.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_charged_particle() { return runnable(scenes::charged_particle()); }

}  // namespace qdot::program
