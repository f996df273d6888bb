#pragma once
// SPDX-License-Identifier: MIT
//
// A scene as the command line wants it: its name, parameters and initial values, and which effects are on.

#include <memory>
#include <string>
#include <vector>

#include "program/runnable_scene.hpp"

namespace qdot::program {

/// What all commands about one scene take.
struct SceneOptions {
  std::string scene;
  std::vector<std::string> set;
  std::vector<std::string> with;
  std::vector<std::string> without;
};

struct ChosenScene {
  std::unique_ptr<RunnableScene> scene;
  State<Dynamic> start;
  std::shared_ptr<const Model> model;
};

/// @throws UsageError
ChosenScene chosen_scene(const SceneOptions& options);

/// The same for a scene that is made already; the name is not looked at.
ChosenScene chosen_scene(const SceneOptions& options, std::unique_ptr<RunnableScene> scene);

/// Applies --set: parameters first, because they decide how many coordinates there are, then initial values.
///
/// @throws UsageError
State<Dynamic> configured(RunnableScene& scene, const std::vector<std::string>& settings);

/// Applies --with and --without, in this order.
///
/// @throws UsageError
void choose_effects(RunnableScene& scene, const SceneOptions& options);

/// The equations of a scene that has been configured.
///
/// @throws UsageError  where an effect does not take a parameter
std::shared_ptr<const Model> model_of(const RunnableScene& scene);

}  // namespace qdot::program
