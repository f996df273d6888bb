// SPDX-License-Identifier: MIT
//
// Writes modelDescription.xml of one scene, for qdot_add_fmu: linked with the same scene and the same code as the library that it describes.
#include <cstdio>
#include <exception>
#include <fstream>
#include <string>

#include "fmi/choice.hpp"

int main(int argc, char** argv) {
  using namespace qdot::fmi;
  if (argc != 2) return std::fprintf(stderr, "give the file to write\n"), 2;
  try {
    const std::string xml = model_description();
    std::ofstream file(argv[1], std::ios::binary);
    file << xml;
    file.close();
    if (!file) return std::fprintf(stderr, "%s cannot be written\n", argv[1]), 1;
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "qdot_add_fmu(%s …): %s\n", choice().identifier.c_str(), error.what()), 1;
  }
}
