// SPDX-License-Identifier: MIT
#include "scenes/slider_crank.hpp"

#include "program/effect_variants.hpp"
#include "qdot/effects/constraints.hpp"

namespace qdot::program {

std::unique_ptr<RunnableScene> make_slider_crank() {
  using scenes::SliderCrank;
  return runnable_with(
      [](const SliderCrank& s) {
        return std::tuple(holonomic("linkage", [s](const auto& q) {
          using std::cos, std::sin;
          using S = typename std::decay_t<decltype(q)>::Scalar;
          return Vector<S, 2>(s.r * cos(q[0]) + s.l * cos(q[1]) - q[2], s.r * sin(q[0]) - s.l * sin(q[1]));
        }));
      },
      scenes::slider_crank());
}

}  // namespace qdot::program
