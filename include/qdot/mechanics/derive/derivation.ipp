#pragma once
// SPDX-License-Identifier: MIT
//
// From a recording of T and V to the lines of its equations: the work of Derivation and KeptDerivation (mechanics/derive/derivation.hpp).
//
// Graphs are differentiated (mechanics/derive/derivatives_of_graph.hpp), and what M and r need is written as lines, with the elimination of M where it has
// few rows (mechanics/derive/solution_lines.hpp), with the numbers that must be in the domain of a function, and with the guards of a branch.
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
#include "qdot/mechanics/derive/derivatives_of_graph.hpp"
#include "qdot/mechanics/derive/solution_lines.hpp"

namespace qdot::detail {

/// Writes the lines of M and r, and those of the slopes once there are any.
template <class Coefficient>
class DerivedLineWriter {
 public:
  DerivedLineWriter(const formula::BasicGraph<Coefficient>& graph, std::size_t n, std::size_t shortest_run, std::size_t parameters = 0)
      : graph_(graph), n_(n), most_(DerivedLines::most(n)), writer_(graph, 3 * n + 1 + parameters, shortest_run) {}

  /// Lines of M, r, of the guards of a branch, and of numbers that are not zero where these hold; none where there would be too many.
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
    lines.mass = writer_.numbers(derived.mass);
    lines.right = writer_.numbers(derived.right);
    add_read(lines, lines.equations);
  }
  /// Those that go on to q̈.
  [[gnu::cold]] void write_solution(DerivedLines& lines) {
    LinesOfNumbers more(lines.equations.count());
    Elimination elimination(more, lines.mass, n_);
    if (!elimination.exists()) return;
    std::vector<int> accelerations = elimination.solution(lines.right);
    if (more.count() > most_) return;
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
  /// Likewise of the slopes.
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
  static void add_checked(const DerivedLines& lines, formula::LineEvaluator& evaluator) {
    for (const DerivedLines::Checked& c : lines.checked) evaluator.add_read(std::array{c.number});
    for (const DerivedLines::Sided& s : lines.sides) evaluator.add_read(std::array{s.number});
  }
  static void add_read(const DerivedLines& lines, formula::LineEvaluator& evaluator) {
    evaluator.add_read(lines.mass);
    evaluator.add_read(lines.right);
    add_checked(lines, evaluator);
  }

  const formula::BasicGraph<Coefficient>& graph_;
  std::size_t n_, most_;
  formula::LineWriter<Coefficient> writer_;
};

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

template <class Number>
[[gnu::cold]] void Derivation<Number>::begin(int size, const AtState* at) {
  recorded = motion_variables(size);
  if (at == nullptr) return;
  branch = std::make_unique<formula::Branches>();
  branch->variables.resize(static_cast<std::size_t>(2 * size + 1));
  copy_state(*at, size, branch->variables.data());
  recorded.recording.branches = branch.get();
}

template <class Number>
[[gnu::cold]] void Derivation<Number>::derive_recorded() {
  if (branch && branch->read_values) return;
  derive(std::move(recorded), branch.get());
  if (lines.exist() && branch && !branch->met.empty()) write_sides();
}

template <class Number>
[[gnu::cold]] void Derivation<Number>::derive(RecordedMotion motion, const formula::Branches* branches, std::size_t parameters) {
  recorded = std::move(motion);
  GraphEquations e = equations_by_graph(recorded.recording.graph, static_cast<int>(recorded.q.size()), recorded.returned[0], recorded.returned[1],
                                        recorded.recording.turnings);
  for (std::size_t i = 0; i < recorded.q.size() && recorded.returned.size() > 2; ++i)  // forces
    e.right[i] = recorded.recording.graph.sum(e.right[i], recorded.returned[2 + i]);
  derived = {std::move(e.mass), std::move(e.right), {}};
  writer = std::make_shared<DerivedLineWriter<Number>>(recorded.recording.graph, recorded.q.size(), std::size_t(4), parameters);
  std::vector<int> nonzero;
  for (const auto& assumption : recorded.recording.assumptions) nonzero.push_back(assumption.node);
  writer->write_equations(derived, branches ? branches->met : std::vector<formula::Guard>(), nonzero, lines);
}

template <class Number>
[[gnu::cold]] void Derivation<Number>::derive_slopes() {
  differentiate(recorded.recording.graph, static_cast<int>(recorded.q.size()), derived);
  writer->write_slopes(derived, lines);
}

template <class Number>
[[gnu::cold]] void Derivation<Number>::derive_solution() {
  writer->write_solution(lines);
}

// Without room for these lines there are none at all.
template <class Number>
[[gnu::cold]] void Derivation<Number>::write_sides() {
  const std::size_t n = recorded.q.size();
  std::vector<int> nodes;
  for (const formula::Guard& guard : branch->met) nodes.push_back(guard.node);
  formula::LineTable table;
  formula::LineWriter<Number> side_writer(recorded.recording.graph, 2 * n + 1);
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
    derivation_.begin(size_, at);
    functors.run(functors.energies, derivation_.recorded);
    derivation_.derive_recorded();
    answers_ = derivation_.recorded.recording.answers;
    if (at == nullptr || lines()) print_ = functors.print(functors.energies, size_, &answers_);
  } catch (...) {  // what functors throw they throw again, where they are asked for values
  }
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
    if (!derivation_.branch->met[i].has(x[derivation_.guards[i]])) return false;
  return true;
}

template <class Number>
bool BasicKeptDerivation<Number>::is_beside_guards(const AtState& at) const {
  return size_ <= 16 ? holds_with<DerivedLines::most(16)>(at) : holds_with<DerivedLines::most(17)>(at);
}

}  // namespace qdot::detail
