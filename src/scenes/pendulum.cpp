// SPDX-License-Identifier: MIT
#include "scenes/pendulum.hpp"

#include "program/effect_variants.hpp"
#include "qdot/effects/dissipation.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_pendulum() {
  using scenes::optional_effect, scenes::Pendulum, scenes::Range;
  return runnable(
      scenes::pendulum(),
      optional_effect<Pendulum>("damping", 0.5, "N m s", Range::non_negative, "torque per angular velocity in the pivot",
                                [](const Pendulum&, double c) { return viscous_damping(Vector<double, 1>(c)); }),
      optional_effect<Pendulum>("drive", 5.0, "N m", Range::any, "amplitude of a torque that turns with 2/3 of sqrt(g/l)",
                                [](const Pendulum& p, double amplitude) {
                                  return generalized_force([amplitude, rate = 2.0 / 3.0 * std::sqrt(p.g / p.l)](const auto&, const auto&, const auto& t) {
                                    using std::cos;
                                    return amplitude * cos(rate * t);
                                  });
                                }));
}

}  // namespace qdot::program
