// SPDX-License-Identifier: MIT
#include "scenes/elastic_pendulum.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_elastic_pendulum() { return runnable(scenes::elastic_pendulum()); }

}  // namespace qdot::program
