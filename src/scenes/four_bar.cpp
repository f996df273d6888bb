// SPDX-License-Identifier: MIT
#include "scenes/four_bar.hpp"

#include "program/effect_variants.hpp"
#include "qdot/effects/constraints.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_four_bar() {
  using scenes::FourBar, scenes::optional_effect, scenes::Range;
  return runnable_with(
      [](const FourBar& s) {
        return std::tuple(holonomic("loop", [s](const auto& q) {
          using std::cos, std::sin;
          using S = typename std::decay_t<decltype(q)>::Scalar;
          return Vector<S, 2>(s.a * cos(q[0]) + s.b * cos(q[1]) - s.c * cos(q[2]) - s.d,
                              s.a * sin(q[0]) + s.b * sin(q[1]) - s.c * sin(q[2]));
        }));
      },
      scenes::four_bar(),
      optional_effect<FourBar>("torque", 1.0, "N m", Range::any, "constant torque on the crank", [](const FourBar&, double torque) {
        return generalized_force([torque](const auto&, const auto&, const auto&) { return Vector<double, 3>(torque, 0.0, 0.0); });
      }));
}

}  // namespace qdot::program
