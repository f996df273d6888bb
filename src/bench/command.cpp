// SPDX-License-Identifier: MIT
//
// qdot-bench [NAME] [--json] [--page FILE]: the command `qdot bench` alone, which ./run builds in place of the whole program.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include "program/arguments.hpp"
#include "program/commands.hpp"

namespace qdot::program {

namespace {

BenchOptions parsed(int argc, char** argv) {
  BenchOptions options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--help" || word == "-h") {
      std::puts("qdot bench [NAME] [--json] [--page FILE]: the project's own benchmarks, all of them without a name\n"
                "  --json       one JSON object on stdout\n"
                "  --page FILE  write the benchmark's page of the documentation (hard)");
      std::exit(0);
    }
    if (word == "--json") options.json = true;
    else if (word.starts_with("--page=")) options.page = word.substr(7);
    else if (word == "--page" && i + 1 < argc) options.page = argv[++i];
    else if (word == "--page") throw UsageError("--page: must be followed by one value, given none");
    else if (word.starts_with("-")) throw unknown_name(word, "an option of qdot bench", word, {"--help", "--json", "--page"});
    else if (options.name) throw UsageError("arguments: must be options after the first, given \"" + word + "\"");
    else options.name = word;
  }
  return options;
}

}  // namespace

}  // namespace qdot::program

int main(int argc, char** argv) {
  using namespace qdot::program;
  try {
    return bench(parsed(argc, argv));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "qdot bench: %s\n", error.what());
    return dynamic_cast<const UsageError*>(&error) != nullptr ? 2 : 1;
  }
}
