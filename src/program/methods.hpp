#pragma once
// SPDX-License-Identifier: MIT
//
// The methods by their names on the command line, and what each needs of a model.
//
// Some need no more than ẏ = f(t, y): these the program has once for all scenes. Others need T and V themselves (their power
// series, their momenta, the two apart): a bare scene makes their steppers (model_steppers.hpp), hidden behind AnyStepper. For a
// scene with effects the program has Taylor and Gauss once as well, on what the model tells of its graph or its momenta.

#include <string>
#include <vector>

#include "program/runnable_scene.hpp"

namespace qdot::program {

/// What a method asks of a system.
enum class MethodKind {
  automatic,      // chooses among the others
  explicit_,      // ẏ = f, and correct() for constraints
  multistep,      // ẏ = f
  stiff,          // ẏ = f and its Jacobian; projects inside its steps
  series,         // T, V and effects as formulas
  gauss,          // T and V; forces and constraints too
  splitting,      // T of the velocities alone, and V
  rattle          // the same with holonomic constraints
};

struct MethodInfo {
  std::string name;
  MethodKind kind;
  int order = 0;  // of a method with a fixed step
  std::string summary;

  bool fixed_step() const { return kind == MethodKind::gauss || kind == MethodKind::splitting || kind == MethodKind::rattle; }
};

/// All methods, the default first.
const std::vector<MethodInfo>& methods();

/// @throws UsageError  there is none of that name; says which are near
const MethodInfo& method_named(const std::string& name);

}  // namespace qdot::program
