// SPDX-License-Identifier: MIT
#include "scenes/cycloid.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_cycloid() { return runnable(scenes::cycloid()); }

}  // namespace qdot::program
