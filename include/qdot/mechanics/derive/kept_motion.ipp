#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of kept_motion.hpp: what a form keeps is a TracedMotion, or its equations. A program that links qdot::compiled has them from there.

#include <memory>

#include "qdot/mechanics/derive/kept_motion.hpp"
#include "qdot/mechanics/derive/recordable_form.hpp"
#include "qdot/mechanics/derive/traced.hpp"
#include "qdot/mechanics/derive/traced_equations.hpp"
#include "qdot/mechanics/derive/traced_motion.hpp"

namespace qdot::detail {

template <class>
[[gnu::cold]] std::unique_ptr<TracedRates> traced_rates(const RecordableForm& form) {
  return std::make_unique<TracedMotion<>>(traced_equations(form));
}

template <class>
[[gnu::cold]] std::shared_ptr<TracedEquations<double>> recorded_equations(const RecordableForm& form) {
  return std::make_shared<TracedEquations<double>>(traced_equations(form));
}

}  // namespace qdot::detail
