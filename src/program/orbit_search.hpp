#pragma once
// SPDX-License-Identifier: MIT
//
// Periodic orbits of a scene, and families of them: the library's search (analysis/periodic_orbit.hpp, orbit_family.hpp) on the Model that commands see.

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "program/along.hpp"
#include "program/chosen_scene.hpp"
#include "qdot/analysis/orbit.hpp"

namespace qdot::program {

/// Which orbit is meant, and where the search for it begins.
struct OrbitRequest : ChosenScene {
  enum class Held { nothing, energy, period, coordinate, drive };
  Held held = Held::nothing;
  std::optional<double> energy = {};  // that is held, where it is not that of the start
  Eigen::Index coordinate = 0;
  double period = 0.0;  // or a guess
  Eigen::VectorXd advance = {};

  enum class In { energy, period, parameter };
  In in = In::energy;  // of a family
  std::optional<ModelsAlong> models = {};
  double from = 0.0, to = 0.0;
};

/// A time after which the motion is close to its start again.
struct Return {
  double period = 0.0;
  Eigen::VectorXd advance;  // of the coordinates then, in whole turns of angles
};

/// What the motion from the start tells of orbits near it.
struct Returns {
  bool driven = false, conserves_energy = false;
  std::vector<Return> each;  // one at least; each is nearer than those before it
};

struct OrbitOfFamily {
  std::string kind;
  double value = 0.0;
  Orbit orbit;
};
struct FamilyFound {
  std::string outcome, message;
  std::vector<OrbitOfFamily> orbits;
  bool reached = false;
};

/// How the motion comes back; over a given period, or as soon as it does.
///
/// @throws Error  where there is no motion to look at
Returns returns_to_start(const ChosenScene& chosen, const Model& model, std::optional<double> period);

/// The orbit that an early return leads to, unless a later return leads to one that is much nearer to the start. The request takes over its
/// period and its advance. A period that is not held is the shortest: no part of it closes the motion.
Orbit orbit_near(OrbitRequest& request, const std::vector<Return>& returns);

/// Where the search began, [q; q̇] on the constraints.
Eigen::VectorXd beginning_of(const OrbitRequest& request);

/// How far each entry of an orbit's start is from there, whole turns of angles aside, in parts of its extent on the orbit. What the orbit leaves
/// open counts as zero.
Eigen::VectorXd moved_by(const OrbitRequest& request, const Orbit& orbit);

/// From an orbit that was found.
FamilyFound family_from(const OrbitRequest& request, const Orbit& orbit);

/// [q; q̇; z] at `count` equal distances of time, from the start to a period later.
std::vector<Eigen::VectorXd> points_of(const OrbitRequest& request, const Orbit& orbit, int count);

/// Where the motion is after a time.
///
/// @throws Error  where it does not last
State<Dynamic> state_after(const ChosenScene& chosen, const Model& model, double time);

}  // namespace qdot::program
