#pragma once
// SPDX-License-Identifier: MIT
//
// The run of run_of_energies.hpp by methods that ask for rates alone: that of the system's form. A program that links qdot::compiled has it from there.

#include <utility>

#include "qdot/integrate/driver/run_of_energies.hpp"
#include "qdot/integrate/driver/run_of_form.hpp"
#include "qdot/integrate/driver/run_request.hpp"
#include "qdot/integrate/run.hpp"
#include "qdot/mechanics/derive/any_energies.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot::detail {

template <int n, bool timed>
Run<n> RunOfEnergies<n, timed>::by(const MethodOfRates& method, AnyEnergies<n, timed> energies, const SystemParts& parts, const StartNumbers& start,
                                   const RunRequest& request) {
  return run_by(method, std::move(energies), parts, start, request);
}

}  // namespace qdot::detail
