#pragma once
// SPDX-License-Identifier: MIT
//
// A system as methods see it, without its type.
//
// An explicit method asks for rates (steps/rates.hpp). Others ask for Jacobians or for a recording of the functors as well. With AnyForm their steppers
// depend on the number of components alone, and are compiled once for all systems.

#include <concepts>
#include <memory>

#include "qdot/integrate/options.hpp"
#include "qdot/integrate/stepper.hpp"
#include "qdot/integrate/steps/rates.hpp"
#include "qdot/integrate/watch/driven_form.hpp"

namespace qdot::detail {

struct AnyForm;
struct MotionSource;  // integrate/steps/taylor_equations.hpp

/// A method says with `using MakerOfSteppers = TheMethod;` that its stepper_of_form() makes what its stepper() makes. A method that is derived from it may
/// have another stepper(), so it does not inherit that.
template <class Method, int size>
concept MethodOfAnyForm = std::same_as<typename Method::MakerOfSteppers, Method> &&
                          requires(const Method& method, const std::shared_ptr<const AnyForm>& form, const Options& options) {
                            { method.template stepper_of_form<size>(form, options) } -> Stepper;
                          };

/// What steppers are made of. Each call copies the system.
struct AnyForm {
  virtual ~AnyForm() = default;
  virtual std::unique_ptr<Rates> rates() const = 0;
  virtual std::unique_ptr<MethodForm> method_form() const = 0;
  virtual std::shared_ptr<const MotionSource> motion_source() const = 0;  // which records T and V
};

}  // namespace qdot::detail
