#pragma once
// SPDX-License-Identifier: MIT
//
// A case by four methods that have little in common.

#include <exception>
#include <string>

#include "doors.hpp"
#include "qdot/integrate/cvode.hpp"
#include "qdot/integrate/cvode_automatic.hpp"
#include "qdot/integrate/runge_kutta.hpp"
#include "qdot/integrate/taylor.hpp"

namespace fuzz {

/// Calls run(name, method) for each; an exception is a finding.
template <class Run>
void by_four_methods(Report& report, const Run& run) {
  const auto by = [&](const char* name, const auto& method) {
    try {
      run(name, method);
    } catch (const std::exception& error) {
      report.finding("a run throws '" + std::string(error.what()) + "' by " + name);
    }
  };
  by("Dop853", qdot::Dop853{});
  by("Taylor", qdot::Taylor{});
  by("CvodeBdf", qdot::CvodeBdf{});
  by("Automatic", qdot::Automatic{});
}

}  // namespace fuzz
