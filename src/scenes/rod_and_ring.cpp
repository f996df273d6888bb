// SPDX-License-Identifier: MIT
#include "scenes/rod_and_ring.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_rod_and_ring() { return runnable(scenes::rod_and_ring()); }

}  // namespace qdot::program
