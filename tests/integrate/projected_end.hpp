#pragma once
// SPDX-License-Identifier: MIT
//
// Where a stepper of a scene ends, without what simulate() adds, and with its constraints kept at every step.

#include "../catch2_bridge.hpp"
#include "qdot/integrate/projecting_stepper.hpp"
#include "qdot/integrate/taylor.hpp"

namespace qdot {

inline const Options tight{.rtol = 1e-13, .atol = 1e-14};
inline constexpr double rounding = 1e-12;  // of some hundred steps, beside a motion of size 1 to 10

// A stepper of a scene's own, without what simulate() adds.
template <class Sc, int n, class Method = Taylor>
Eigen::VectorXd end_of(const Sc& scene, const State<n>& start, double t_end, const Method& method = {}, const Options& options = tight) {
  const auto form = first_order_form(scene);
  auto stepper = detail::projecting_stepper(method, form, options);
  stepper.reset(start.t, form.packed(start));
  while (stepper.t() != t_end) {
    const bool advanced = stepper.step(t_end);
    INFO(stepper.failure().message);
    REQUIRE(advanced);
  }
  CHECK(stepper.statistics().projections == stepper.statistics().steps);
  CHECK(stepper.statistics().constraint_residual < 1e-14);
  CHECK(stepper.statistics().constraint_velocity < 1e-13);
  return stepper.y();
}

}  // namespace qdot
