// SPDX-License-Identifier: MIT
#include "scenes/lattice.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_lattice() { return runnable(scenes::lattice()); }

}  // namespace qdot::program
