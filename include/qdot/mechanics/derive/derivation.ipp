#pragma once
// SPDX-License-Identifier: MIT
//
// From a recording of T and V to the lines of its equations: the work of Derivation and KeptDerivation (mechanics/derive/derivation.hpp).
//
// Graphs are differentiated (mechanics/derive/derivatives_of_graph.hpp), and what M and r need is written as lines. With them come the elimination of M
// where it has few rows (mechanics/derive/solution_lines.hpp), the numbers that must be in the domain of a function, and the guards of a branch.
//
// Programs that link qdot::compiled do not read this file: the library has it.

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "qdot/ad/formula/line_writer.hpp"
#include "qdot/mechanics/derive/derivation.hpp"
#include "qdot/mechanics/derive/derived_equations.hpp"
#include "qdot/mechanics/derive/solution_lines.hpp"
#include "qdot/mechanics/derive/traced_motion.hpp"

namespace qdot::detail {

// An evaluator whose numbers tell whether there are values.
[[gnu::cold]] inline void add_checked(const DerivedLines& lines, formula::LineEvaluator& evaluator) {
  for (const DerivedLines::Checked& c : lines.checked) evaluator.add_read(std::array{c.number});
  for (const DerivedLines::Sided& s : lines.sides) evaluator.add_read(std::array{s.number});
}

/// Writes the lines of M and r, and those of the slopes once there are any.
template <class Coefficient>
class DerivedLineWriter {
 public:
  DerivedLineWriter(const formula::BasicGraph<Coefficient>& graph, std::size_t n, std::size_t shortest_run, std::size_t parameters = 0)
      : graph_(graph), n_(n), most_(DerivedLines::most(n)), writer_(graph, 3 * n + 1 + parameters, shortest_run) {}

  /// Lines of M, of r where it is given, of the guards of a branch, and of numbers that are not zero where these hold. None where they would be too many.
  [[gnu::cold]] void write_equations(const DerivedJacobian& derived, const std::vector<formula::Guard>& guards, const std::vector<int>& nonzero,
                                     DerivedLines& lines) {
    std::vector<int> equations = derived.mass;
    equations.insert(equations.end(), derived.right.begin(), derived.right.end());
    for (const formula::Guard& guard : guards) equations.push_back(guard.node);
    equations.insert(equations.end(), nonzero.begin(), nonzero.end());
    const std::vector<formula::Domain> domains = domains_to_check(graph_, equations);
    formula::LineTable table;
    writer_.write(with_checked(equations, domains), table);
    table.lines.push_back(formula::Line{});
    lines.equations.set(std::move(table), writer_.count(), lines.begins);
    if (writer_.count() > most_) return;
    for (std::size_t w = 0; w < domains.size(); ++w)
      if (domains[w] != formula::Domain::everything) lines.checked.push_back({writer_.number(static_cast<int>(w)), domains[w]});
    for (const int node : nonzero) lines.checked.push_back({writer_.number(node), formula::Domain::nonzero});
    for (const formula::Guard& guard : guards) lines.sides.push_back({writer_.number(guard.node), guard});
    lines.dof = static_cast<int>(n_);
    lines.mass = writer_.numbers(derived.mass);
    lines.right = writer_.numbers(derived.right);
    add_read(lines, lines.equations);
  }
  /// Those of the slopes.
  [[gnu::cold]] void write_slopes(const DerivedJacobian& derived, DerivedLines& lines) {
    formula::LineTable table;
    writer_.write(derived.slopes, table);
    table.lines.push_back(formula::Line{});
    lines.further.set(std::move(table), writer_.count(), lines.begins);
    if (writer_.count() > most_) return;
    lines.slopes = writer_.numbers(derived.slopes);
    lines.further.add_read(lines.slopes);
    lines.before_slopes.set(lines.equations.table(), writer_.count(), lines.begins);
    add_read(lines, lines.before_slopes);
    lines.before_slopes.add_read(lines.slopes);
    lines.before_slopes.add_read(lines.further);
  }

 private:
  static void add_read(const DerivedLines& lines, formula::LineEvaluator& evaluator) {
    evaluator.add_read(lines.mass);
    evaluator.add_read(lines.right);
    add_checked(lines, evaluator);
  }

  const formula::BasicGraph<Coefficient>& graph_;
  std::size_t n_, most_;
  formula::LineWriter<Coefficient> writer_;
};

/// Lines of M and r that go on to q̈ of n coordinates; none where M has a zero on its diagonal, or there would be too many.
[[gnu::cold]] inline void write_solution(DerivedLines& lines, std::size_t n) {
  LinesOfNumbers more(lines.equations.count());
  Elimination elimination(more, lines.mass, n);
  if (!elimination.exists()) return;
  std::vector<int> accelerations = elimination.solution(lines.right);
  if (more.count() > DerivedLines::most(n)) return;
  formula::LineTable table = lines.equations.table();
  table.lines.pop_back();
  table.lines.insert(table.lines.end(), more.lines.begin(), more.lines.end());
  table.lines.push_back(formula::Line{});
  DerivedLines::Solution& solution = lines.solution;
  solution.lines.set(std::move(table), more.count(), lines.begins);
  solution.accelerations = std::move(accelerations);
  solution.pivots = std::move(elimination.pivots);
  solution.lines.add_read(solution.accelerations);
  for (const auto& [pivot, whole] : solution.pivots) solution.lines.add_read(std::array{pivot, whole});
  add_checked(lines, solution.lines);
}

// x ← q, q̇, t of a state of so many coordinates.
inline void copy_state(const AtState& at, int size, double* x) {
  std::copy_n(at.q, size, x);
  std::copy_n(at.qdot, size, x + size);
  x[2 * size] = at.t;
}

template <class Number>
[[gnu::cold]] Derivation<Number>::Derivation(By by) {
  lines.begins = machine_code_begins(by);
}
template <class Number>
Derivation<Number>::~Derivation() = default;

// M and r as nodes.
template <class Number>
[[gnu::cold]] DerivedJacobian mass_and_rhs_of(const TracedEquations<Number>& equations) {
  return {lower_triangle(equations.mass), equations.right, {}};
}
template <class Number>
[[gnu::cold]] DerivedLineWriter<Number> written_equations(const TracedEquations<Number>& e, const DerivedJacobian& derived, DerivedLines& lines) {
  DerivedLineWriter<Number> writer(e.graph(), e.n(), 4, e.parameters.size());
  std::vector<int> nonzero;
  for (const auto& assumption : e.motion.recording.assumptions) nonzero.push_back(assumption.node);
  writer.write_equations(derived, e.guards, nonzero, lines);
  return writer;
}

template <class Number>
[[gnu::cold]] void Derivation<Number>::derive(TracedEquations<Number> recorded) {
  recorded.derive(recorded.motion.returned.size() > 2, {});
  write(std::make_shared<const TracedEquations<Number>>(std::move(recorded)));
}
template <class Number>
[[gnu::cold]] void Derivation<Number>::derive_motion(RecordedMotion recorded, int parameters) {
  derive(TracedEquations<Number>(std::move(recorded), parameters));
}
template <class Number>
[[gnu::cold]] void Derivation<Number>::write(std::shared_ptr<const TracedEquations<Number>> derived) {
  equations = std::move(derived);
  written_equations(*equations, mass_and_rhs_of(*equations), lines);
}

template <class Number>
[[gnu::cold]] void Derivation<Number>::write_mass(DerivedLines& mass) const {
  mass.begins = lines.begins;
  written_equations(*equations, {lower_triangle(equations->mass), {}, {}}, mass);
}

// The graph of the equations is others', too, so slopes are added to a copy.
template <class Number>
[[gnu::cold]] void Derivation<Number>::derive_slopes() {
  TracedEquations<Number> e = *equations;
  DerivedJacobian derived = mass_and_rhs_of(e);
  differentiate(e.graph(), static_cast<int>(e.n()), derived);
  DerivedLines again;
  written_equations(e, derived, again).write_slopes(derived, lines);
}

template <class Number>
[[gnu::cold]] void Derivation<Number>::derive_solution() {
  write_solution(lines, equations->n());
}

// Without room for these lines there are none at all.
template <class Number>
[[gnu::cold]] void Derivation<Number>::write_sides() {
  const std::size_t n = equations->n();
  std::vector<int> nodes;
  for (const formula::Guard& guard : equations->guards) nodes.push_back(guard.node);
  formula::LineTable table;
  formula::LineWriter<Number> side_writer(equations->graph(), 2 * n + 1);
  side_writer.write(nodes, table);
  table.lines.push_back(formula::Line{});
  sides.set(std::move(table), side_writer.count(), lines.begins);
  guards = side_writer.numbers(nodes);
  sides.add_read(guards);
  if (side_writer.count() > DerivedLines::most(n)) lines = {};
}

template <class Number>
[[gnu::cold]] BasicKeptDerivation<Number>::BasicKeptDerivation(By by) : derivation_(by) {}
template <class Number>
BasicKeptDerivation<Number>::~BasicKeptDerivation() = default;

template <class Number>
[[gnu::cold]] void BasicKeptDerivation<Number>::derive(const RecordableFunctors& functors, const AtState* at) {
  size_ = functors.size;
  try {
    TracedEquations<Number> recorded(motion_variables(size_));
    formula::Branches branch;
    if (at != nullptr) {
      branch.variables.resize(static_cast<std::size_t>(2 * size_ + 1));
      copy_state(*at, size_, branch.variables.data());
      recorded.motion.recording.branches = &branch;
    }
    functors.run(functors.energies, recorded.motion);
    recorded.motion.recording.branches = nullptr;
    answers_ = recorded.motion.recording.answers;
    recorded.guards = std::move(branch.met);
    if (!branch.read_values) derivation_.derive(std::move(recorded));
    if (lines() && !derivation_.equations->guards.empty()) derivation_.write_sides();
    if (at == nullptr || lines()) print_ = functors.print(functors.energies, size_, &answers_);
  } catch (...) {  // what functors throw they throw again, where they are asked for values
  }
}
template <class Number>
[[gnu::cold]] void BasicKeptDerivation<Number>::take(std::shared_ptr<const TracedEquations<Number>> equations, Fingerprint print) {
  size_ = static_cast<int>(equations->n());
  derivation_.equations = std::move(equations);
  is_written_.store(false, std::memory_order_relaxed);
  print_ = print;
}

template <class Number>
[[gnu::cold, gnu::noinline]] void BasicKeptDerivation<Number>::write() {
  const std::lock_guard lock(mutex_);
  if (!is_written_.load(std::memory_order_relaxed)) derivation_.write(derivation_.equations);
  is_written_.store(true, std::memory_order_release);
}
template <class Number>
[[gnu::cold, gnu::noinline]] void BasicKeptDerivation<Number>::write_mass() {
  const std::lock_guard lock(mutex_);
  if (!is_asked_for_mass_.load(std::memory_order_relaxed) && derivation_.equations) derivation_.write_mass(mass_);
  is_asked_for_mass_.store(true, std::memory_order_release);
}

template <class Number>
[[gnu::cold, gnu::noinline]] void BasicKeptDerivation<Number>::derive_slopes() {
  const std::lock_guard lock(mutex_);
  if (!is_asked_for_slopes_.load(std::memory_order_relaxed)) derivation_.derive_slopes();
  is_asked_for_slopes_.store(true, std::memory_order_release);
}

template <class Number>
[[gnu::cold, gnu::noinline]] void BasicKeptDerivation<Number>::derive_solution() {
  const std::lock_guard lock(mutex_);
  if (!is_asked_for_lanes_.load(std::memory_order_relaxed)) derivation_.derive_solution();
  is_asked_for_lanes_.store(true, std::memory_order_release);
}

template <class Number>
bool BasicKeptDerivation<Number>::is_of(const RecordableFunctors& functors) const {
  return print_ != 0 && functors.print(functors.energies, size_, &answers_) == print_;
}

template <class Number>
template <std::size_t room>
[[gnu::noinline]] bool BasicKeptDerivation<Number>::holds_with(const AtState& at) const {
  double x[room];
  copy_state(at, size_, x);
  derivation_.sides(x);
  for (std::size_t i = 0; i < derivation_.guards.size(); ++i)
    if (!derivation_.equations->guards[i].has(x[derivation_.guards[i]])) return false;
  return true;
}

template <class Number>
bool BasicKeptDerivation<Number>::is_beside_guards(const AtState& at) const {
  return size_ <= 16 ? holds_with<DerivedLines::most(16)>(at) : holds_with<DerivedLines::most(17)>(at);
}

}  // namespace qdot::detail
