// SPDX-License-Identifier: MIT
#include "scenes/coupled_oscillators.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_coupled_oscillators() { return runnable(scenes::coupled_oscillators()); }

}  // namespace qdot::program
