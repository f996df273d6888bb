#pragma once
// SPDX-License-Identifier: MIT
//
// A form without its type, for what records its functors.
//
// Recording T, V, forces and constraints is seldom, and what follows (differentiation of the graph, lines, machine code) depends on no type. So a form says
// once how its functors are run, and the rest is compiled once.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "qdot/mechanics/by.hpp"

namespace qdot::detail {

struct RecordedMotion;  // mechanics/derive/recorded_energies.hpp
/// What was answered where functors compared numbers.
using Answers = std::vector<double>;

/// A hash of T, of V, of what effects do, and of what is compared; zero where functors are no formulas, or answer more or fewer questions.
using Fingerprint = std::uint64_t;

/// Sizes of pivots that are none: of M, and of the rows of constraints. Where M may be singular, constraints are to lend it inertia.
struct LimitsOfPivots {
  double singular, dependent;
  bool may_be_singular = false;
};

/// Runs all functors of a form in the phases of a recording; notes of each row of a constraint whether it restricts positions, if `holonomic` is not null.
using RunsFunctors = void (*)(const void* form, RecordedMotion& motion, std::vector<char>* holonomic);

// The key of a system without effects, whatever hides its functors' types; never called.
inline void plain_system(const void*, RecordedMotion&, std::vector<char>*) {}

/// The functors of a form that outlives this.
struct RecordableForm {
  const void* form;
  RunsFunctors run;
  RunsFunctors key = nullptr;  // tells apart the forms that share derivations
  /// The fingerprint of the functors in some phases.
  Fingerprint (*print)(const void* form, const double* phases, const Answers* answers) = nullptr;
  Eigen::Index dof = 0, states = 0;
  bool has_forces = false;
  By by = By::fastest;
  LimitsOfPivots limits{};

  void operator()(RecordedMotion& motion) const { run(form, motion, nullptr); }
};

}  // namespace qdot::detail
