// SPDX-License-Identifier: MIT
#include "scenes/rod_chain.hpp"

#include "program/effect_variants.hpp"
#include "qdot/effects/constraints.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_rod_chain() {
  return runnable_with([](const scenes::RodChain& s) { return std::tuple(holonomic("rods", scenes::RodLengths{s.l})); }, scenes::rod_chain());
}

}  // namespace qdot::program
