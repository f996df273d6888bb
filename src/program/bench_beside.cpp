// SPDX-License-Identifier: MIT
//
// qdot bench, in the program that has no benchmarks linked in: hands over to qdot-bench, which stands beside it. Most of the
// time it takes to compile the program would be the benchmarks', and who simulates has no use for them.
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "bench/names.hpp"
#include "program/arguments.hpp"
#include "program/commands.hpp"

namespace qdot::program {

int bench(const BenchOptions& options) {
  if (options.name && std::ranges::find(bench::names, *options.name) == bench::names.end())
    throw unknown_name("NAME", "a benchmark", *options.name, {bench::names.begin(), bench::names.end()});

  std::error_code unknown;
  const std::filesystem::path here = std::filesystem::read_symlink("/proc/self/exe", unknown);
  std::vector<std::string> words{(here.parent_path() / "qdot-bench").string(), "bench"};
  if (options.name) words.push_back(*options.name);
  if (options.json) words.push_back("--json");
  if (options.page) words.insert(words.end(), {"--page", *options.page});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execv(arguments.front(), arguments.data());
  throw UsageError("bench: must find the program qdot-bench beside qdot, but " + words.front() +
                   " cannot be started; build the target qdot_bench, or type ./run bench");
}

}  // namespace qdot::program
