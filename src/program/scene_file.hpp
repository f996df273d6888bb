#pragma once
// SPDX-License-Identifier: MIT
//
// A scene in a file of C++ that a user wrote (scenes/own_scene.hpp): compiled by the compiler that made this program, into a library that
// is loaded into it. So all commands see it as they see the catalogue.
//
// Compiling takes ten seconds, and is done once: the library is kept in a cache. Its key is the compiler, its options, the file's name, and the
// contents of the file and of all headers that it includes. Files are made under other names and renamed, so that programs that run at the same time
// find a whole one or none. The cache is $XDG_CACHE_HOME/qdot, or ~/.cache/qdot, and may be deleted at any time.

#include <functional>
#include <memory>
#include <string>

#include "program/arguments.hpp"
#include "program/runnable_scene.hpp"

namespace qdot::program {

/// What is wrong with a file with a scene: one line, and what the compiler says below it.
class SceneFileError : public UsageError {
 public:
  SceneFileError(const std::string& line, std::string details) : UsageError(line), details_(std::move(details)) {}
  const std::string& details() const { return details_; }

 private:
  std::string details_;
};

/// Whether a name ends in .cpp, .cc or .cxx.
bool is_scene_file(const std::string& name);

/// The name of the scene in a file: that of the file without its ending.
std::string scene_name_of(const std::string& path);

/// What makes the scene in a file, which is compiled here if it has to be; what is made throws UsageError when the scene does not agree with itself.
///
/// @throws UsageError  the file cannot be read, does not compile (SceneFileError), or has no scene
std::function<std::unique_ptr<RunnableScene>()> scene_maker_of_file(const std::string& path);

}  // namespace qdot::program
