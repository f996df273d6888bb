#pragma once
// SPDX-License-Identifier: MIT
//
// Benchmarks of the program: `qdot bench [NAME] [--json]`.
//
// A benchmark returns rows. Each row is one measurement beside a baseline that was measured in the same run, on the same machine.
// So the ratio survives a change of machine although the times do not.

#include <functional>
#include <string>
#include <vector>

namespace qdot::bench {

/// One measured quantity beside its baseline.
struct Row {
  std::string name;           // what was measured, e.g. "chain n=4, general, for"
  double value = 0;           // in `unit`
  double baseline = 0;        // in `unit`; 0 where there is none
  std::string baseline_name;  // e.g. "hand-derived"; empty where there is none
  std::string unit;           // "ns", "s"

  // Of rows that evaluate equations of motion: the system, its coordinates, the way in which it was given to the library.
  std::string system{};
  int n = 0;
  std::string door{};
  // Of rows with effects: rows of constraints that are active, and what the effects are.
  int constraints = 0;
  std::string effect{};

  double ratio() const { return baseline > 0 ? value / baseline : 0.0; }
};

/// What a benchmark found: its rows, or the reason why it could not run here.
struct Findings {
  std::vector<Row> rows;
  std::string note;          // conditions of the measurement, one sentence
  std::string cannot_run{};  // non-empty: why there are no rows, e.g. "no compiler named g++"

  // Of a benchmark whose rows have a form of their own: as text, as a JSON array, and as a page of the documentation.
  std::string text{}, json{}, page{};
};

struct Benchmark {
  std::string name;     // as typed after `qdot bench`
  std::string summary;  // one line for the list
  std::function<Findings()> run;
};

/// The benchmark of this program: each has one, which its src/bench/NAME.cpp defines.
Benchmark benchmark();

}  // namespace qdot::bench
