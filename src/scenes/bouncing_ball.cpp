// SPDX-License-Identifier: MIT
#include "scenes/bouncing_ball.hpp"

#include <tuple>

#include "program/effect_variants.hpp"
#include "qdot/effects/contact.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_bouncing_ball() {
  return runnable_with(
      [](const scenes::BouncingBall& s) {
        return std::tuple(contact("floor", [](const auto& q) { return q[0]; }, restitution(s.e)));
      },
      scenes::bouncing_ball());
}

}  // namespace qdot::program
