// SPDX-License-Identifier: MIT
#include "scenes/rod_and_ring.hpp"

#include "program/effect_variants.hpp"
#include "qdot/effects/contact.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_rod_and_ring() {
  using scenes::optional_effect, scenes::Range, scenes::RodAndRing;
  return runnable(scenes::rod_and_ring(),
                  optional_effect<RodAndRing>("end_stop", 0.5, "", Range::non_negative,
                                              "restitution of a stop at the end of the rod, which the ring hits",
                                              [](const RodAndRing& s, double e) {
                                                return contact("end stop", [L = s.L](const auto& q) { return L - q[0]; }, restitution(e));
                                              }),
                  optional_effect<RodAndRing>("open_end", 1.0, "", Range::positive,
                                              "where the ring leaves the rod and the run ends, as a part of L",
                                              [](const RodAndRing& s, double part) {
                                                return boundary("ring leaves the rod", [L = part * s.L](const auto& q) { return L - q[0]; });
                                              }));
}

}  // namespace qdot::program
