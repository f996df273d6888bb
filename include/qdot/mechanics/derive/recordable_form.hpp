#pragma once
// SPDX-License-Identifier: MIT
//
// A form without its type, for what records its functors.
//
// Recording T, V, forces and constraints is seldom, and what follows (differentiation of the graph, lines, machine code) depends on no type. So a form says
// once how its functors are run, and the rest is compiled once.

#include <Eigen/Core>
#include <vector>

#include "qdot/mechanics/by.hpp"

namespace qdot::detail {

struct RecordedMotion;  // mechanics/derive/recorded_energies.hpp

/// Sizes of pivots that are none: of M, and of the rows of constraints. Where M may be singular, constraints are to lend it inertia.
struct LimitsOfPivots {
  double singular, dependent;
  bool may_be_singular = false;
};

/// The functors of a form that outlives this.
struct RecordableForm {
  const void* form;
  /// Runs all functors in the phases of a recording; notes of each row of a constraint whether it restricts positions, if `holonomic` is not null.
  void (*run)(const void* form, RecordedMotion& motion, std::vector<char>* holonomic);
  Eigen::Index dof, states = 0;
  bool has_forces = false;
  By by = By::fastest;
  LimitsOfPivots limits{};

  void operator()(RecordedMotion& motion) const { run(form, motion, nullptr); }
};

}  // namespace qdot::detail
