// SPDX-License-Identifier: MIT
//
// qdot bench: starts the benchmarks' programs, qdot-bench-NAME, which stand beside this one, one after the other. Each takes the compiler minutes, and
// simulations do not need them.
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "bench/names.hpp"
#include "program/arguments.hpp"
#include "program/commands.hpp"

namespace qdot::program {

namespace {

/// Where the program of a benchmark is.
///
/// @throws UsageError  where there is none
std::string program_of(const std::string& name) {
  std::error_code unknown;
  const std::string program = (std::filesystem::read_symlink("/proc/self/exe", unknown).parent_path() / ("qdot-bench-" + name)).string();
  if (access(program.c_str(), X_OK) != 0)
    throw UsageError("bench: must find the program qdot-bench-" + name + " beside qdot, but " + program +
                     " cannot be started; build the target qdot_bench_" + name +
                     ", or type ./run bench " + name);
  return program;
}

/// The exit status of a program, which runs to its end.
int ended(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  std::fflush(stdout);
  pid_t child = 0;
  int status = 0;
  if (posix_spawn(&child, arguments[0], nullptr, nullptr, arguments.data(), environ) != 0 || waitpid(child, &status, 0) != child || !WIFEXITED(status))
    throw Error("bench: " + words[0] + " must start and run to its end, but did not");
  return WEXITSTATUS(status);
}

}  // namespace

int bench(const BenchOptions& options) {
  std::vector<std::string> names{bench::names.begin(), bench::names.end()};
  if (options.name) {
    if (std::ranges::find(names, *options.name) == names.end()) throw unknown_name("NAME", "a benchmark", *options.name, names);
    if (options.page && *options.name != "hard")
      throw UsageError("--page: must be given with a benchmark that has one (hard), given \"" + *options.page + "\"");
    names = {*options.name};
  }
  std::vector<std::string> programs;
  for (const std::string& name : names) programs.push_back(program_of(name));

  const bool object = options.json && !options.name;
  int status = 0;
  for (std::size_t i = 0; i < programs.size(); ++i) {
    std::vector<std::string> words{programs[i], object ? "member" : options.json ? "json" : "text"};
    if (options.page) words.push_back(*options.page);
    if (object) std::printf(i == 0 ? "{\n" : ",\n");
    status = std::max(status, ended(words));
  }
  if (object) std::printf("\n}\n");
  return status;
}

}  // namespace qdot::program
