#pragma once
// SPDX-License-Identifier: MIT
//
// Scenes by name: those that are linked in, and those in a file of C++ (scene_file.hpp).

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "program/runnable_scene.hpp"

namespace qdot::program {

struct NamedScene {
  std::string name;
  std::unique_ptr<RunnableScene> (*make)();
};

/// The scenes that are linked in, in the order of the list: the catalogue (src/CMakeLists.txt), or a user's own (own/main.cpp).
const std::vector<NamedScene>& named_scenes();

/// Their names.
std::vector<std::string> scene_names();

/// A fresh scene with default parameters. A name that ends as files of C++ do is that of a file, which is compiled if it has to be.
///
/// @throws UsageError  for an unknown name, with the nearest one; for a file that cannot be read or does not compile
std::unique_ptr<RunnableScene> make_scene(const std::string& name);

/// What makes fresh scenes of this name again and again; a file is looked at once.
///
/// @throws UsageError  as make_scene()
std::function<std::unique_ptr<RunnableScene>()> scene_maker(const std::string& name);

}  // namespace qdot::program
