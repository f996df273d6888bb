// SPDX-License-Identifier: MIT
//
// qdot bench [NAME]: runs the benchmarks and prints every row beside its baseline.
#include "bench/bench.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "program/arguments.hpp"
#include "program/commands.hpp"
#include "qdot/report/file.hpp"

namespace qdot::program {

namespace {

using Json = nlohmann::ordered_json;

void print(const bench::Benchmark& benchmark, const bench::Findings& findings) {
  std::printf("%s: %s\n", benchmark.name.c_str(), benchmark.summary.c_str());
  if (!findings.cannot_run.empty()) {
    std::printf("  cannot run here: %s\n\n", findings.cannot_run.c_str());
    return;
  }
  std::printf("%s", findings.text.c_str());
  std::size_t width = 0;
  for (const bench::Row& row : findings.rows) width = std::max(width, row.name.size());
  for (const bench::Row& row : findings.rows) {
    std::printf("  %-*s %10.4g %s", static_cast<int>(width), row.name.c_str(), row.value, row.unit.c_str());
    if (row.baseline > 0) {
      std::printf("   %6.2f × %s (%.4g %s)", row.ratio(), row.baseline_name.c_str(), row.baseline, row.unit.c_str());
    }
    std::printf("\n");
  }
  if (!findings.note.empty()) std::printf("  %s\n", findings.note.c_str());
  std::printf("\n");
}

// Rows of evaluations, the way `qdot bench eom --json` and `qdot bench scenes --json` print them.
Json evaluations_json(const bench::Findings& found, bool of_scenes) {
  Json rows = Json::array();
  for (const bench::Row& row : found.rows) {
    Json entry = {{of_scenes ? "scene" : "system", row.system}, {"n", row.n}};
    entry.update(of_scenes ? Json{{"constraints", row.constraints}, {"effect", row.effect}} : Json{{"door", row.door}});
    entry.update({{"baseline", row.baseline_name}, {"baseline_ns", row.baseline}, {"qdot_ns", row.value}, {"ratio", row.ratio()}});
    rows.push_back(entry);
  }
  return rows;
}

// Findings by the name of their benchmark; of `bench eom` alone, the array of its rows {system, n, door, …_ns, ratio}, of
// `bench scenes` alone that of {scene, n, constraints, effect, …_ns, ratio}.
std::string bench_json(const std::vector<std::pair<std::string, bench::Findings>>& findings) {
  if (findings.size() == 1 && (findings[0].first == "eom" || findings[0].first == "scenes"))
    return evaluations_json(findings[0].second, findings[0].first == "scenes").dump(2);
  if (findings.size() == 1 && !findings[0].second.json.empty()) return findings[0].second.json;
  Json object = Json::object();
  for (const auto& [name, found] : findings) {
    Json rows = Json::array();
    for (const bench::Row& row : found.rows) {
      Json entry = {{"name", row.name}, {"value", row.value}, {"unit", row.unit}};
      if (row.baseline > 0) {
        entry["baseline"] = row.baseline;
        entry["baseline_name"] = row.baseline_name;
        entry["ratio"] = row.ratio();
      }
      rows.push_back(entry);
    }
    if (!found.json.empty()) rows = Json::parse(found.json);
    object[name] = {{"rows", rows}, {"note", found.note}};
    if (!found.cannot_run.empty()) object[name]["cannot_run"] = found.cannot_run;
  }
  return object.dump(2);
}

}  // namespace

int bench(const BenchOptions& options) {
  std::vector<bench::Benchmark> chosen = bench::all_benchmarks();
  if (options.name) {
    std::vector<std::string> names;
    for (const auto& b : chosen) names.push_back(b.name);
    std::erase_if(chosen, [&](const bench::Benchmark& b) { return b.name != *options.name; });
    if (chosen.empty()) throw unknown_name("NAME", "a benchmark", *options.name, names);
  }
  std::vector<std::pair<std::string, bench::Findings>> all;
  bool ran = true;
  for (const bench::Benchmark& benchmark : chosen) {
    all.emplace_back(benchmark.name, benchmark.run());
    ran = ran && all.back().second.cannot_run.empty();
    if (!options.json) print(benchmark, all.back().second);
  }
  if (options.page) {
    std::string pages;
    for (const auto& [name, findings] : all) pages += findings.page;
    if (pages.empty()) throw UsageError("--page: must be given with a benchmark that has one (hard), given \"" + *options.page + "\"");
    report::write_files({{*options.page, pages}});
  }
  if (options.json) std::printf("%s\n", bench_json(all).c_str());
  return ran ? 0 : 1;
}

}  // namespace qdot::program
