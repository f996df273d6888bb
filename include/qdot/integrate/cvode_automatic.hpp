#pragma once
// SPDX-License-Identifier: MIT
//
// The method to begin with when nothing is known about a motion: Taylor or Dop853 while it is smooth, CVODE's BDF with the
// exact Jacobian where it is stiff. How it chooses is in automatic.hpp; what it chose, and why, in the run's statistics.

#include "qdot/integrate/automatic.hpp"
#include "qdot/integrate/cvode.hpp"

namespace qdot {

/// Chooses among Taylor, Dop853 and CvodeBdf, and changes between them during a run.
using Automatic = AutomaticWith<CvodeBdf>;

}  // namespace qdot
