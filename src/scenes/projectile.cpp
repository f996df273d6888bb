// SPDX-License-Identifier: MIT
#include "scenes/projectile.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_projectile() { return runnable(scenes::projectile()); }

}  // namespace qdot::program
