#pragma once
// SPDX-License-Identifier: MIT
//
// A scene as the command line wants it: its name, parameters and initial values, and which effects are on.

#include <memory>
#include <optional>
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
  std::optional<std::string> by = {};  // how T and V are evaluated
};

/// Entry `place` of [q; q̇] at the start, as --set gives it.
struct InitialValue {
  Eigen::Index place = 0;
  double value = 0.0;
};

struct ChosenScene {
  std::unique_ptr<RunnableScene> scene;
  State<Dynamic> start;
  std::shared_ptr<const Model> model;
  std::vector<InitialValue> initial_values = {};
};

/// @throws UsageError
ChosenScene chosen_scene(const SceneOptions& options);

/// The chosen scene, where it is made already; the name is not used.
ChosenScene chosen_scene(const SceneOptions& options, std::unique_ptr<RunnableScene> scene);

/// Applies the parameters of --set, and returns its initial values: a parameter has the precedence over a coordinate of the same name.
///
/// @throws UsageError
std::vector<InitialValue> configured(RunnableScene& scene, const std::vector<std::string>& settings);

/// The scene's start with these values in their places.
State<Dynamic> start_with(const RunnableScene& scene, const std::vector<InitialValue>& values);

/// What an entry of [q; q̇] is called: as the scene calls it, "thetadot", and by its number, "qdot0".
struct ComponentNames {
  std::string name, plain, unit;
};

/// The names of all entries, in their order.
std::vector<ComponentNames> names_of_start(const RunnableScene& scene);

/// Applies --with and --without, in this order.
///
/// @throws UsageError
void choose_effects(RunnableScene& scene, const SceneOptions& options);

/// Applies --by.
///
/// @throws UsageError
void choose_way(RunnableScene& scene, const SceneOptions& options);

/// The equations of a scene that has been configured.
///
/// @throws UsageError  where an effect does not take a parameter
std::shared_ptr<const Model> model_of(const RunnableScene& scene);

}  // namespace qdot::program
