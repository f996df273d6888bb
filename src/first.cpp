// SPDX-License-Identifier: MIT
//
// qdot-first OUT: what ./run shows first, a rod with a sliding ring and a double pendulum, with their pictures in the folder OUT.
//
// The command `qdot run` with these two scenes alone is built in a third of the time of the whole program.
#include <cstdio>
#include <exception>
#include <string>

#include "program/arguments.hpp"
#include "program/catalogue.hpp"
#include "program/commands.hpp"
#include "program/scene_runner.hpp"
#include "scenes/double_pendulum.hpp"
#include "scenes/rod_and_ring.hpp"

namespace qdot::program {

const std::vector<NamedScene>& named_scenes() {
  static const std::vector<NamedScene> scenes = {{"rod_and_ring", [] { return runnable(scenes::rod_and_ring()); }},
                                                 {"double_pendulum", [] { return runnable(scenes::double_pendulum()); }}};
  return scenes;
}

}  // namespace qdot::program

int main(int argc, char** argv) {
  if (argc != 2) return std::fputs("qdot-first OUT: simulates two scenes and writes their pictures to the folder OUT\n", stderr), 2;
  int status = 0;
  try {
    for (const std::string& scene : qdot::program::scene_names()) {
      qdot::program::RunOptions options;
      options.scene = scene;
      options.out = std::string(argv[1]) + "/" + scene;
      if (qdot::program::run(options) != 0) status = 1;
      std::puts("");
    }
  } catch (const qdot::program::UsageError& error) {
    std::fprintf(stderr, "qdot-first: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "qdot-first: %s\n", error.what());
    return 1;
  }
  return std::fflush(stdout) != 0 || std::ferror(stdout) != 0 ? 1 : status;
}
