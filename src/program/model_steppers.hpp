#pragma once
// SPDX-License-Identifier: MIT
//
// Steppers of the methods that need T and V themselves, and of Dop853 unrolled for the scene.

#include <optional>
#include <string>

#include "qdot/integrate/any_stepper.hpp"
#include "qdot/integrate/gauss.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/symplectic.hpp"
#include "qdot/integrate/taylor.hpp"
#include "qdot/mechanics/first_order_form.hpp"

namespace qdot::program {

/// The stepper of a method by its name; nothing where the method is not among these or does not fit the type of T.
///
/// @param step  of the methods with a fixed step
/// @throws NotAnalytic, InvalidValue  as the method's own
template <class Sys>
std::optional<AnyStepper> own_stepper_of(const FirstOrderForm<Sys>& form, const std::string& method, double step, const Options& options) {
  if (method == "taylor") return any_stepper(Taylor{}, form, options);
  if constexpr (Sys::dof_at_compile_time != Dynamic) {  // otherwise there is nothing to unroll
    if (method == "dop853") return any_stepper(Dop853{}, form, options);
  }
  if (method.size() == 6 && method.starts_with("gauss"))
    return any_stepper(Gauss{.step = step, .stages = (method[5] - '0') / 2}, form, options);
  if constexpr (qdot::detail::may_separate<Sys>) {
    using enum SplittingScheme;
    for (const SplittingScheme scheme : {verlet, yoshida_4, mclachlan_atela_4, blanes_moan_4, kahan_li_6, blanes_moan_6, kahan_li_8})
      if (method == qdot::detail::splitting(scheme).name) return any_stepper(Splitting{.step = step, .scheme = scheme}, form, options);
  }
  return std::nullopt;
}

}  // namespace qdot::program
