// SPDX-License-Identifier: MIT
#include "scenes/net.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_net() { return runnable(scenes::net()); }

}  // namespace qdot::program
