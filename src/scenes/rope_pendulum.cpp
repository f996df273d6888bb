// SPDX-License-Identifier: MIT
#include "scenes/rope_pendulum.hpp"

#include <tuple>

#include "program/effect_variants.hpp"
#include "qdot/effects/contact.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_rope_pendulum() {
  return runnable_with(
      [](const scenes::RopePendulum& s) {
        return std::tuple(rope("rope", [](const auto& q) { return q; }, Vector<double, 2>(0.0, 0.0), s.l, restitution(s.e)));
      },
      scenes::rope_pendulum());
}

}  // namespace qdot::program
