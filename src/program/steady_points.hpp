#pragma once
// SPDX-License-Identifier: MIT
//
// Where a scene of the catalogue rests or moves steadily, and its modes there.

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "program/along.hpp"
#include "program/commands.hpp"
#include "program/runnable_scene.hpp"
#include "qdot/analysis/damped_modes.hpp"

namespace qdot::program {

struct SteadyPoint {
  Linearization linear;
  DampedModes modes;
  std::vector<Reaction> reactions;
};

/// A scene with its parameters and effects as the options say, and where the search starts.
struct SteadyRequest : ChosenScene {
  bool steady = false;
  std::vector<std::string> paths = {};  // to write to
};

/// @throws UsageError
SteadyRequest steady_request(const ModesOptions& options);

/// The steady state near q with the velocities of the request, or at rest.
///
/// @throws Error  where there is none
SteadyPoint steady_point(const SteadyRequest& request, const Eigen::VectorXd& q);

/// Which coordinates nothing depends on, at the start.
std::vector<bool> cyclic_coordinates(const SteadyRequest& request);

/// A point of a branch of equilibria, as analysis/equilibrium_branch.hpp has it.
struct PointOfBranch {
  std::string kind;  // "fold"
  double p = 0.0;
  Eigen::VectorXd q, z;
  Eigen::VectorXcd exponents;
  int growing = 0;
  Stability stability = Stability::unstable;

  bool is_special() const { return kind == "fold" || kind == "branch" || kind == "hopf"; }
};
struct PointsOfBranch {
  std::vector<PointOfBranch> points;
  std::string message;
  std::optional<std::pair<std::size_t, std::size_t>> from;  // the branch and its point that this one begins at
};

/// The branch of steady states that begins near the start of the request, and those that cross.
///
/// @throws Error  where there is none to begin with
std::vector<PointsOfBranch> branches_along(const SteadyRequest& request, const ModelsAlong& models, double from, double to);

/// Writes a table of modes and a page with their exponents in the complex plane.
void write_steady_points(const SteadyRequest& request, const std::vector<SteadyPoint>& points);

/// The modes as a table for a terminal.
void print_modes(const SteadyRequest& request, const SteadyPoint& point);

}  // namespace qdot::program
