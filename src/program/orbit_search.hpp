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

/// What the motion from the start tells of an orbit near it.
struct FirstReturn {
  bool driven = false, conserves_energy = false;
  double period = 0.0;      // when it is nearest to its start again
  Eigen::VectorXd advance;  // of the coordinates then, in whole turns of angles
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
FirstReturn first_return(const ChosenScene& chosen, const Model& model, std::optional<double> period);

Orbit orbit_near(const OrbitRequest& request);

/// From an orbit that was found.
FamilyFound family_from(const OrbitRequest& request, const Orbit& orbit);

/// [q; q̇; z] at `count` equal distances of time, from the start to a period later.
std::vector<Eigen::VectorXd> points_of(const OrbitRequest& request, const Orbit& orbit, int count);

/// Where the motion is after a time.
///
/// @throws Error  where it does not last
State<Dynamic> state_after(const ChosenScene& chosen, const Model& model, double time);

}  // namespace qdot::program
