// SPDX-License-Identifier: MIT
#include "scenes/mathieu.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_mathieu() { return runnable(scenes::mathieu()); }

}  // namespace qdot::program
