#pragma once
// SPDX-License-Identifier: MIT
//
// Runs of one scene beside each other: what `qdot run SCENE --compare 'l=2,method=gauss8'` shows.
//
// The first run is the one that the other options ask for; each --compare is one more, with settings of its own in place of those. Curves of
// the same quantity lie over each other, pictures as well, and a plot says how far the motions have come apart.

#include <memory>
#include <string>
#include <vector>

#include "program/commands.hpp"
#include "program/runnable_scene.hpp"
#include "program/simulation.hpp"
#include "qdot/report/html.hpp"

namespace qdot::program {

/// One of the runs.
struct ComparedRun {
  std::string label;  // how it differs from the first
  std::unique_ptr<RunnableScene> scene;
  Request request;
  Result result;
};

/// The options with the settings "NAME=VALUE,…" in their place: parameters and initial values, method, step, rtol, atol, accuracy, `with EFFECT[=VALUE]`,
/// `without EFFECT`.
///
/// @throws UsageError
RunOptions with_settings(RunOptions options, const std::string& settings);

/// Where a coordinate of two runs is farthest apart, at the times that both have samples of.
struct Difference {
  std::string coordinate;
  double size = 0;
  double t = 0;
};

/// One for each coordinate of the first run.
std::vector<Difference> largest_differences(const ComparedRun& first, const ComparedRun& other);

/// The page of the first run with those of the others laid over it.
report::Page comparison_page(const std::vector<ComparedRun>& runs);

}  // namespace qdot::program
