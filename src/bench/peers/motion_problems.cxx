// SPDX-License-Identifier: MIT
//
// motion_problems [PROBLEM]: the problems for peers that are not written in C++, one JSON object on each line.
#include <cstdio>

#include "bench/motion_problems.hpp"

namespace {

void print(const char* name, const std::vector<double>& values) {
  std::printf(",\"%s\":[", name);
  for (std::size_t i = 0; i < values.size(); ++i) std::printf("%s%.17g", i ? "," : "", values[i]);
  std::printf("]");
}

}  // namespace

int main(int argc, char** argv) {
  for (const auto& problem : qdot::bench::motion_problems(argc > 1 ? argv[1] : "")) {
    std::printf("{\"name\":\"%s\",\"n\":%d,\"t_end\":%.17g,\"relative\":%s", problem.name.c_str(), problem.n, problem.t_end,
                problem.relative ? "true" : "false");
    print("start", problem.start);
    print("end", problem.end);
    print("errors", problem.errors);
    std::printf("}\n");
  }
}
