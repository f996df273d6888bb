#pragma once
// SPDX-License-Identifier: MIT
//
// What an importer sees of a scene: a list of variables, each known by its place in the list, its value reference.
//
//     time              the independent variable
//     m, l, g           parameters, to be set before the simulation begins, and so is how strong an optional effect is
//     damping.on        whether such an effect is there at all, where that leaves y as long as it is
//     motor             inputs: the effects input(…) of the scene
//     theta, thetadot   y = [q; q̇; z] but for inputs and phases: the continuous states, outputs as well
//     der(theta) …      their rates, from the equations of motion
//     floor.guard       event indicators of contacts and dry friction, which stay ≥ 0 as long as …
//     floor.phase       … this phase lasts: 1 closed and 0 apart; for friction 0 sticks and ±1 slides
//     kinetic_energy, potential_energy
//
// The list is made of the scene by the library and by the program that writes modelDescription.xml, from the same code: they cannot disagree.
//
// What changes the number of coordinates, states or guards cannot be left to the importer, because the description is fixed. These are counts (the
// links of a chain), and effects with states or constraints. qdot_add_fmu(… SET n=5 WITH motor) chooses them.

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "fmi/choice.hpp"
#include "program/runnable_scene.hpp"

namespace qdot::fmi {

enum class Role { time, parameter, count, effect_value, effect_on, input, state, rate, guard, phase, kinetic_energy, potential_energy };

/// In FMI's words.
enum class Type { float64, int32, boolean };

struct Variable {
  Role role = Role::time;
  std::string name;
  std::string unit = {};
  std::string description = {};
  double start = 0.0;
  scenes::Range range = scenes::Range::any;
  Eigen::Index place = 0;           // in y for inputs, states, rates and phases; the number of a guard
  std::string of = {};              // the scene's own name of a parameter or effect
  bool follows_others = false;      // a start that depends on parameters or has to meet constraints: "approx" in FMI's words
  std::size_t state_reference = 0;  // of a rate: the state it belongs to

  Type type() const { return role == Role::count ? Type::int32 : role == Role::effect_on ? Type::boolean : Type::float64; }
};

/// All that is fixed about the scene as an importer sees it.
struct Variables {
  std::vector<Variable> all;
  std::vector<std::size_t> states, rates, inputs, guards;  // references, in the order of the state vector
  Eigen::Index size = 0;                                   // of y
  bool constrained = false;
  double start_time = 0.0, end_time = 0.0;
  std::string name, title, summary, time_unit;
};

/// The scene with what qdot_add_fmu chose.
///
/// @throws InvalidValue  there is no such parameter or effect, or it does not take the value
std::unique_ptr<program::RunnableScene> chosen_scene(const Choice& choice);

/// @throws InvalidValue  two variables would bear one name
Variables variables_of(const Choice& choice);

}  // namespace qdot::fmi
