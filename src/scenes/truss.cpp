// SPDX-License-Identifier: MIT
#include "scenes/truss.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_truss() { return runnable(scenes::truss()); }

}  // namespace qdot::program
