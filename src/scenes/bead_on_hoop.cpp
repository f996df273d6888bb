// SPDX-License-Identifier: MIT
#include "scenes/bead_on_hoop.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_bead_on_hoop() { return runnable(scenes::bead_on_hoop()); }

}  // namespace qdot::program
