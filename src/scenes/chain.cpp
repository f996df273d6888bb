// SPDX-License-Identifier: MIT
#include "scenes/chain.hpp"

#include "program/scene_runner.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_chain() { return runnable(scenes::chain()); }

}  // namespace qdot::program
