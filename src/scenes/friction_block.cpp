// SPDX-License-Identifier: MIT
#include "scenes/friction_block.hpp"

#include <tuple>

#include "program/effect_variants.hpp"
#include "qdot/effects/dry_friction.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_friction_block() {
  return runnable_with([](const scenes::FrictionBlock& s) { return std::tuple(dry_friction("block", 0, s.F)); },
                       scenes::friction_block());
}

}  // namespace qdot::program
