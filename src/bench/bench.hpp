#pragma once
// SPDX-License-Identifier: MIT
//
// Benchmarks of the program: `qdot bench [NAME] [--json]`.
//
// A benchmark returns rows. Each row is one measurement beside a baseline that was measured in the same run, on
// the same machine, so that the ratio survives a change of machine although the times do not.

#include <functional>
#include <string>
#include <vector>

namespace qdot::bench {

/// One measured quantity beside its baseline.
struct Row {
  std::string name;           // what was measured, e.g. "chain n=4, graded duals"
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

/// Time to evaluate the equations of motion against hand-derived code (src/bench/eom.cpp).
Benchmark eom_benchmark();

/// Time to evaluate scenes with effects and constraints against the same derived by hand (src/bench/scenes.cpp).
Benchmark scenes_benchmark();

/// Time to evaluate many states at once against one after the other (src/bench/ensemble.cpp).
Benchmark ensemble_benchmark();

/// Time of many motions side by side against one after the other (src/bench/many.cpp).
Benchmark many_benchmark();

/// What a step of large scenes costs for each coordinate (src/bench/large.cpp).
Benchmark large_benchmark();

/// Time to reach an error with each method, beside Dop853 (src/bench/steppers.cpp).
Benchmark steppers_benchmark();

/// Energy error over ten thousand periods of a planet (src/bench/steppers_energy.cpp).
Benchmark energy_benchmark();

/// Time of a run with its derivatives against the run alone (src/bench/sensitivities.cpp).
Benchmark sensitivities_benchmark();

/// Digits reached on published hard cases (src/bench/hard.cpp).
Benchmark hard_benchmark();

/// Time to compile user programs of 20 to 40 lines (src/bench/compile.cpp).
Benchmark compile_benchmark();

/// All benchmarks of this build, in the order in which `qdot bench` runs them.
std::vector<Benchmark> all_benchmarks();

}  // namespace qdot::bench
