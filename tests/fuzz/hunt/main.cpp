// SPDX-License-Identifier: MIT
//
// hunt [CASES [SEED [FIRST]]]: cases of all kinds in turn, findings as they come. Exit status 1: there were some.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "hunt.hpp"

int main(int count, char** arguments) {
  const auto number = [&](int i, std::uint64_t otherwise) { return count > i ? std::strtoull(arguments[i], nullptr, 10) : otherwise; };
  const std::uint64_t cases = number(1, 1000), seed = number(2, 1), first = number(3, 0);
  std::vector<fuzz::Game> games;
  for (const auto& some : {fuzz::interpreted_games(), fuzz::written_games(), fuzz::scene_games(), fuzz::free_games(), fuzz::kind_games()})
    games.insert(games.end(), some.begin(), some.end());
  fuzz::Report report;
  struct Tally {
    long cases = 0, found = 0;
    double seconds = 0.0;
  };
  std::map<std::string, Tally> tally;
  for (std::uint64_t i = first; i < first + cases; ++i) {
    const std::size_t before = report.findings.size();
    const auto began = std::chrono::steady_clock::now();
    fuzz::hunt(report, games, seed, i);
    Tally& of_kind = tally[games[i % games.size()].name];
    of_kind.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    ++of_kind.cases;
    if (report.findings.size() > before) ++of_kind.found;
    for (std::size_t k = before; k < report.findings.size(); ++k) std::printf("%s\n", report.findings[k].c_str());
    std::fflush(stdout);
  }
  for (const auto& [name, t] : tally) std::printf("%5ld cases, %ld with findings, %.1f s: %s\n", t.cases, t.found, t.seconds, name.c_str());
  std::printf("%llu cases of seed %llu: %ld answers compared, %ld rightly refused, %ld that double cannot decide; %zu findings\n",
              static_cast<unsigned long long>(cases), static_cast<unsigned long long>(seed), report.compared, report.refused,
              report.undecided, report.findings.size());
  return report.findings.empty() ? 0 : 1;
}
