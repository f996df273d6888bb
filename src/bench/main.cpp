// SPDX-License-Identifier: MIT
//
// qdot-bench-NAME [FORM [PAGE]]: runs its benchmark, prints every row beside its baseline, and writes its page, if it has one, to the file PAGE. The form
// is text, json, or member: a line of the JSON object of several benchmarks. start.cpp starts it.
#include <algorithm>
#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/bench.hpp"
#include "qdot/error.hpp"
#include "qdot/report/file.hpp"

namespace qdot::bench {

namespace {

using Json = nlohmann::ordered_json;

void print(const Benchmark& benchmark, const Findings& findings) {
  std::printf("%s: %s\n", benchmark.name.c_str(), benchmark.summary.c_str());
  if (!findings.cannot_run.empty()) {
    std::printf("  cannot run here: %s\n\n", findings.cannot_run.c_str());
    return;
  }
  std::printf("%s", findings.text.c_str());
  std::size_t width = 0;
  for (const Row& row : findings.rows) width = std::max(width, row.name.size());
  for (const Row& row : findings.rows) {
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
Json evaluations_json(const Findings& found, bool of_scenes) {
  Json rows = Json::array();
  for (const Row& row : found.rows) {
    Json entry = {{of_scenes ? "scene" : "system", row.system}, {"n", row.n}};
    entry.update(of_scenes ? Json{{"constraints", row.constraints}, {"effect", row.effect}} : Json{{"door", row.door}});
    entry.update({{"baseline", row.baseline_name}, {"baseline_ns", row.baseline}, {"qdot_ns", row.value}, {"ratio", row.ratio()}});
    rows.push_back(entry);
  }
  return rows;
}

// NAME: {rows, note}, as a member of an object.
std::string member(const std::string& name, const Findings& found) {
  Json rows = Json::array();
  for (const Row& row : found.rows) {
    Json entry = {{"name", row.name}, {"value", row.value}, {"unit", row.unit}};
    if (row.baseline > 0) {
      entry["baseline"] = row.baseline;
      entry["baseline_name"] = row.baseline_name;
      entry["ratio"] = row.ratio();
    }
    rows.push_back(entry);
  }
  if (!found.json.empty()) rows = Json::parse(found.json);
  Json object = {{name, {{"rows", rows}, {"note", found.note}}}};
  if (!found.cannot_run.empty()) object[name]["cannot_run"] = found.cannot_run;
  const std::string text = object.dump(2);
  return text.substr(2, text.size() - 4);  // without {⏎ and ⏎}
}

// Of `bench eom` alone, the array of its rows {system, n, door, …_ns, ratio}, of `bench scenes` alone that of {scene, n, constraints, effect, …_ns, ratio}.
std::string json_of_one(const std::string& name, const Findings& found) {
  if (name == "eom" || name == "scenes") return evaluations_json(found, name == "scenes").dump(2);
  return found.json.empty() ? "{\n" + member(name, found) + "\n}" : found.json;
}

}  // namespace

}  // namespace qdot::bench

int main(int argc, char** argv) {
  using namespace qdot;
  const bench::Benchmark benchmark = bench::benchmark();
  try {
    const std::string form = argc > 1 ? argv[1] : "text";
    const bench::Findings found = benchmark.run();
    if (argc > 2 && !found.page.empty()) report::write_files({{argv[2], found.page}});
    if (form == "text") bench::print(benchmark, found);
    else if (form == "json") std::puts(bench::json_of_one(benchmark.name, found).c_str());
    else std::fputs(bench::member(benchmark.name, found).c_str(), stdout);
    if (std::fflush(stdout) != 0) throw Error("standard output must take all that is printed, but did not; make room where it goes, or send it elsewhere");
    return found.cannot_run.empty() ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "qdot bench: %s\n", error.what());
    return 1;
  }
}
