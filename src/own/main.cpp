// SPDX-License-Identifier: MIT
//
// The program of one scene, which qdot_add_scene(NAME FILE) makes: the command line of qdot, and the scene of FILE in place of the catalogue.
#include <vector>

#include "program/catalogue.hpp"
#include "program/command_line.hpp"

std::unique_ptr<qdot::program::RunnableScene> qdot_scene();  // in FILE

namespace qdot::program {

const std::vector<NamedScene>& named_scenes() {
  static const std::vector<NamedScene> own{{QDOT_SCENE_NAME, qdot_scene}};
  return own;
}

}  // namespace qdot::program

int main(int argc, char** argv) { return qdot::program::command_line(argc, argv); }
