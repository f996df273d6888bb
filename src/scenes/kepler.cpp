// SPDX-License-Identifier: MIT
#include "scenes/kepler.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_kepler() { return runnable(scenes::kepler()); }

}  // namespace qdot::program
