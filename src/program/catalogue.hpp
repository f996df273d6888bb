#pragma once
// SPDX-License-Identifier: MIT
//
// All scenes, by name.

#include <memory>
#include <string>
#include <vector>

#include "program/runnable_scene.hpp"

namespace qdot::program {

/// Names of all scenes, in the order of the list.
std::vector<std::string> scene_names();

/// A fresh scene with default parameters.
///
/// @throws UsageError  for an unknown name, with the nearest one
std::unique_ptr<RunnableScene> make_scene(const std::string& name);

}  // namespace qdot::program
