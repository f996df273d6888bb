#pragma once
// SPDX-License-Identifier: MIT
//
// A system as methods see it, without its type.
//
// An explicit method asks for rates (steps/rates.hpp). Others ask for Jacobians or for a recording of the functors as well. With AnyForm their steppers
// depend on the number of components alone, and are compiled once for all systems.

#include <memory>

#include "qdot/integrate/options.hpp"
#include "qdot/integrate/steps/rates.hpp"
#include "qdot/integrate/watch/driven_form.hpp"

namespace qdot::detail {

struct MotionSource;  // integrate/steps/taylor_equations.hpp

/// What steppers are made of. Each is of a copy of the system.
struct AnyForm {
  virtual ~AnyForm() = default;
  virtual std::unique_ptr<Rates> rates() const = 0;
  virtual std::unique_ptr<MethodForm> method_form() const = 0;
  virtual std::shared_ptr<const MotionSource> motion_source() const = 0;  // records T and V
};

}  // namespace qdot::detail
