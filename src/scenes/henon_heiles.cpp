// SPDX-License-Identifier: MIT
#include "scenes/henon_heiles.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_henon_heiles() { return runnable(scenes::henon_heiles()); }

}  // namespace qdot::program
