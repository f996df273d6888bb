// SPDX-License-Identifier: MIT
//
// qdot bench hard: the published hard cases (src/hard/), what each method reaches of the digits that the references are good
// for, as a table, as JSON, and as the page docs/lab/hard-cases.md.
#include <cstdarg>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "bench/bench.hpp"
#include "hard/hard_case.hpp"

namespace qdot::bench {
namespace {

using Results = std::vector<std::pair<hard::Case, std::vector<hard::Row>>>;

[[gnu::format(printf, 1, 2)]] std::string text(const char* format, ...) {
  char buffer[1024];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof buffer, format, arguments);
  va_end(arguments);
  return buffer;
}

std::string or_dash(const std::optional<double>& number) { return number ? text("%.1e", *number) : std::string("–"); }

bool is_claim(const hard::Row& row) { return row.limit.empty(); }
bool is_short(const hard::Row& row) { return row.short_by() > 1.0; }

std::string table(const Results& results) {
  std::string out;
  for (const auto& [hard_case, rows] : results) {
    out += "  " + hard_case.title + "\n";
    for (const hard::Row& row : rows)
      out += text("    %5.1f of %5.1f digits %s %9ld evaluations  %-24s %s\n", row.digits_reached, row.digits_good,
                  !is_claim(row) ? "(limit)" : is_short(row) ? "(short)" : "       ", row.evaluations, row.method.c_str(), row.problem.c_str());
  }
  return out;
}

std::string json(const Results& results) {
  using Json = nlohmann::ordered_json;
  const auto number = [](const std::optional<double>& x) { return x ? Json(*x) : Json(nullptr); };
  Json array = Json::array();
  for (const auto& [hard_case, rows] : results)
    for (const hard::Row& row : rows)
      array.push_back({{"case", row.problem},
                       {"method", row.method},
                       {"digits_reached", row.digits_reached},
                       {"digits_good", row.digits_good},
                       {"evaluations", row.evaluations},
                       {"constraint_residual_max", number(row.constraint_residual_max)},
                       {"energy_drift_max", number(row.energy_drift_max)},
                       {"outcome", row.outcome},
                       {"seconds", row.seconds},
                       {"best_published", row.best_published},
                       {"group", hard_case.name},
                       {"claim", is_claim(row)},
                       {"limit", row.limit}});
  return array.dump(2);
}

std::string page(const Results& results) {
  std::size_t all = 0, reached = 0;
  bool limits = false;
  for (const auto& [hard_case, rows] : results)
    for (const hard::Row& row : rows)
      if (is_claim(row))
        ++all, reached += is_short(row) ? 0 : 1;
      else
        limits = true;
  std::string out =
      "# Hard cases\n\n"
      "Published problems on which solvers lose digits, each written as any user writes it (`src/hard/`), against references that "
      "are better than double precision. Written by `./run bench hard --page docs/lab/hard-cases.md`; the times are those of one "
      "machine, and so is the last digit of what goes to rounding: a compiler or a tolerance that is another by a hundredth rounds "
      "otherwise, and Pleiades by dop853, for one, then reaches 11.9 to 13.6 digits, 12.6 on the average of twenty runs.\n\n"
      "- **reached**: −log₁₀ of the largest error at the end, each entry beside its scale (the largest reference value among the "
      "positions, or the velocities, unless a case says otherwise).\n"
      "- **good**: the digits that the comparison is good for. They end where those of the reference end, or where double "
      "precision does: rounding the start alone, ε = 2.2e-16, changes the end by ε times the motion's error gain.\n"
      "- **published**: digits that others reached or printed.\n"
      "- **residual**: largest |φ| after a step (of velocity constraints: |a|). **energy**: largest error of the energy, or of its "
      "balance with the work done, in the problem's units.\n\n";
  if (reached == all)
    out += text("All %zu rows reach the good digits to within one.", all);
  else
    out += text("%zu of %zu rows reach the good digits to within one; the others are marked ▼.", reached, all);
  if (limits) out += " Methods that people would take for a problem and that cannot are at the end of the page, with the reason.";
  out +=
      "\nThe tables of energy errors (Kepler, McLachlan and Atela) and of CVODE's pendulum compare the same method with what others "
      "printed of it, so they have one method each.\n";
  for (const auto& [hard_case, rows] : results) {
    out += "\n## " + hard_case.title + "\n\n" + hard_case.about + " (`src/hard/" + hard_case.name + ".cpp`)\n\n";
    out += "| problem | method | reached | good | evaluations | seconds | residual | energy | published |\n|---|---|---|---|---|---|---|---|---|\n";
    for (const hard::Row& row : rows) {
      if (!is_claim(row)) continue;
      const std::string outcome = row.outcome == "completed" ? "" : " (" + row.outcome + ")";
      out += "| " + row.problem + " | " + row.method + outcome + " | " + text("%.1f%s", row.digits_reached, is_short(row) ? " ▼" : "") +
             text(" | %.1f | %ld | %.2g | ", row.digits_good, row.evaluations, row.seconds) + or_dash(row.constraint_residual_max) + " | " +
             or_dash(row.energy_drift_max) + " | " + row.best_published + " |\n";
    }
  }
  if (!limits) return out;
  out +=
      "\n## Methods that stop earlier\n\nShown on purpose; in `--json` they have `\"claim\": false` and the reason as `limit`.\n\n"
      "| problem | method | reached | good | evaluations | seconds | why it stops |\n|---|---|---|---|---|---|---|\n";
  for (const auto& [hard_case, rows] : results)
    for (const hard::Row& row : rows)
      if (!is_claim(row))
        out += "| " + row.problem + " | " + row.method + text(" | %.1f | %.1f", row.digits_reached, row.digits_good) +
               text(" | %ld | %.2g | ", row.evaluations, row.seconds) + row.limit + " |\n";
  return out;
}

Findings hard_cases() {
  Results results;
  for (const hard::Case& hard_case : hard::all_cases()) {
    const auto rows = hard_case.rows();
    results.emplace_back(hard_case, rows);
  }
  Findings findings;
  findings.text = table(results);
  findings.json = json(results);
  findings.page = page(results);
  return findings;
}

}  // namespace

Benchmark benchmark() {
  return {"hard", "published hard cases: digits reached, of those that the references are good for", hard_cases};
}

}  // namespace qdot::bench
