#pragma once
// SPDX-License-Identifier: MIT
//
// From sparse equations to lines: the work of TracedLines and TracedMotion (mechanics/derive/traced_motion.hpp).
//
// Programs that link qdot::compiled do not read this file: the library has it.

#include <array>
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <utility>
#include <vector>

#include "qdot/ad/formula/line_writer.hpp"
#include "qdot/mechanics/derive/solution_lines.hpp"
#include "qdot/mechanics/derive/traced_motion.hpp"

namespace qdot::detail {

template <class Number>
[[gnu::cold]] TracedLines<Number>::TracedLines(TracedEquations<Number> equations)
    : shared_(std::make_shared<Shared>(std::move(equations))), x_(shared_->inputs) {
  shared_->writer = std::make_shared<formula::LineWriter<Number>>(shared_->equations.graph(), shared_->inputs);
}

template <class Number>
[[gnu::cold]] std::vector<int> TracedLines<Number>::numbers(const std::vector<int>& nodes) const {
  return shared_->writer->numbers(nodes);
}

template <class Number>
[[gnu::cold]] std::vector<std::pair<int, int>> TracedLines<Number>::numbers_of_pivots(std::vector<std::pair<int, int>> nodes) const {
  for (auto& [pivot, whole] : nodes) {
    pivot = shared_->writer->number(pivot);
    whole = shared_->writer->number(whole);
  }
  return nodes;
}

template <class Number>
[[gnu::cold]] std::shared_ptr<formula::LineEvaluator> TracedLines<Number>::evaluator(formula::LineTable table) {
  table.lines.push_back(formula::Line{});
  auto lines = std::make_shared<formula::LineEvaluator>();
  lines->set(std::move(table), shared_->writer->count(), shared_->equations.begins);
  shared_->written.push_back(lines);
  return lines;
}

template <class Number>
[[gnu::cold]] std::shared_ptr<const formula::LineEvaluator> TracedLines<Number>::written(const std::vector<int>& outputs) {
  formula::LineTable table;
  shared_->writer->write(outputs, table);
  x_.resize(shared_->writer->count());
  std::erase_if(table.lines, [&](const formula::Line& line) {  // a constant is there from now on
    const bool is_constant = line.operation == formula::Line::Operation::constant;
    if (is_constant) x_[line.to] = line.c;
    return is_constant;
  });
  auto lines = evaluator(std::move(table));
  for (const auto& earlier : shared_->written) {
    earlier->add_read(numbers(outputs));
    if (earlier != lines) earlier->add_read(*lines);
  }
  return lines;
}

template <class Number>
[[gnu::cold]] typename TracedLines<Number>::Solved TracedLines<Number>::solved(const std::vector<int>& mass, const std::vector<int>& b,
                                                                               const std::vector<int>& columns, const std::vector<int>& others, double least,
                                                                               std::size_t most) {
  const std::size_t n = b.size();
  formula::BasicGraph<Number>& graph = equations().graph();
  formula::LineWriter<Number>& writer = *shared_->writer;
  NodesOfGraph<formula::BasicGraph<Number>> nodes{graph};
  Elimination elimination(nodes, mass, n);
  if (!elimination.exists()) return {};
  std::vector<int> before = elimination.solution(b), all;
  const std::vector<int> x = before;
  for (std::size_t first = 0; first < columns.size(); first += n) {
    const auto begin = columns.begin() + static_cast<std::ptrdiff_t>(first);
    append(all, elimination.solution({begin, begin + static_cast<std::ptrdiff_t>(n)}));
  }
  append(before, others);
  std::vector<std::pair<int, int>> pivots = std::move(elimination.pivots);
  if (!keep_variable(pivots, least)) return {};
  for (const auto& [pivot, whole] : pivots) append(before, {pivot, whole});
  formula::LineTable table;
  writer.write(before, table);
  for (std::size_t i = 0; i < n; ++i) writer.place(graph.variable(static_cast<int>(2 * n + 1 + equations().states() + i)), writer.number(x[i]));
  writer.write(all, table);
  return evaluated(std::move(table), {nullptr, numbers(x), numbers(all), numbers_of_pivots(std::move(pivots)), {}}, others, most);
}

// Takes out the pivots that are constants; false where one of them is too small.
template <class Number>
[[gnu::cold]] bool TracedLines<Number>::keep_variable(std::vector<std::pair<int, int>>& pivots, double least) {
  const formula::BasicGraph<Number>& graph = equations().graph();
  bool good = true;
  std::erase_if(pivots, [&](const std::pair<int, int>& p) {
    const auto &pivot = graph[p.first], &whole = graph[p.second];
    if (pivot.kind != formula::Kind::constant) return false;
    if (whole.kind == formula::Kind::constant) good = good && pivot.c > least * whole.c;
    else good = good && pivot.c > 0.0;
    return whole.kind == formula::Kind::constant;
  });
  return good;
}

// M ← M + ϱ JᵀJ, which changes λ by ϱγ and no q̈ with J q̈ = γ; ϱ makes both about as large.
template <class Graph>
[[gnu::cold]] void lend_inertia(Graph& graph, EquationsOfRates& e) {
  if (e.gamma.empty()) return;
  const std::size_t n = e.n();
  int inertia = graph.constant(0.0), size = inertia;
  for (std::size_t i = 0; i < n; ++i)
    if (const int m = e.mass_at(i, i); m >= 0) inertia = graph.sum(inertia, m);
  for (const int w : e.J)
    if (w >= 0) size = graph.sum(size, graph.product(w, w));
  const int rho = graph.quotient(inertia, size);
  for (std::size_t k = 0; k < e.gamma.size(); ++k)
    for (std::size_t i = 0; i < n; ++i) {
      if (e.J[k * n + i] < 0) continue;
      const int lent = graph.product(rho, e.J[k * n + i]);
      for (std::size_t j = 0; j <= i; ++j) {
        if (e.J[k * n + j] < 0) continue;
        int& m = e.mass_at(i, j);
        const int more = graph.product(lent, e.J[k * n + j]);
        m = m < 0 ? more : graph.sum(m, more);
      }
    }
}

// Few rows are eliminated in the graph, where constants are folded. Many are eliminated in their own order, for level by level registers would not do.
template <class Number>
[[gnu::cold]] typename TracedLines<Number>::Solved TracedLines<Number>::solved_rates(const LimitsOfPivots& limits,
                                                                                     std::size_t most,
                                                                                     bool with_multipliers) {
  constexpr std::size_t most_in_graph = 4;
  TracedEquations<Number>& e = equations();
  formula::BasicGraph<Number>& graph = e.graph();
  EquationsOfRates of{lower_triangle(e.mass), e.right, rows_of_constraints(e.J, e.n()), e.gamma};
  AngularUnknowns<formula::BasicGraph<Number>> unknowns(graph, e.free_turns, e.apart);
  unknowns.enter(of);
  for (const FreeTurn& turn : e.free_turns) e.requirements.push_back({turn.turning->regular, formula::Domain::positive, regular_turning});
  DecidedUnknowns<formula::BasicGraph<Number>> decided(graph);
  if (limits.may_be_singular) {
    decided.take_out(of);
    lend_inertia(graph, of);
  }
  for (const int divisor : decided.divisors) e.requirements.push_back({divisor, formula::Domain::nonzero});
  // Where unknowns are others than q̈, or M is lent inertia, λ is found behind q̈.
  const EquationsOfRates given = with_multipliers ? EquationsOfRates{lower_triangle(e.mass), e.right, rows_of_constraints(e.J, e.n()), e.gamma}
                                                  : EquationsOfRates{};
  const bool are_found_behind = with_multipliers && (limits.may_be_singular || !e.free_turns.empty());
  std::vector<int> others = required();
  append(others, e.zdot);
  if (e.n() <= most_in_graph) {
    NodesOfGraph<formula::BasicGraph<Number>> nodes{graph};
    ConstrainedAcceleration found = constrained_acceleration(nodes, of.mass, of.right, of.J, of.gamma, with_multipliers && !are_found_behind);
    const auto itself = [](int node) { return node; };
    if (!found.x.empty()) {
      decided.put_back(found.x, itself);
      unknowns.leave(nodes, found.x, itself);
      if (are_found_behind) found.lambda = multipliers_at(nodes, given.mass, given.right, given.J, found.x);
    }
    const std::vector<int> multipliers = found.lambda;
    return solved_in_graph(std::move(found), multipliers, others, limits, most);
  }
  append(others, unknowns.read());
  append(others, decided.nodes());
  if (are_found_behind)
    for (const auto* nodes : {&given.mass, &given.right, &given.J}) append(others, *nodes);
  formula::LineWriter<Number>& writer = *shared_->writer;
  formula::LineTable table;
  for (const auto* nodes : std::initializer_list<const std::vector<int>*>{&of.mass, &of.right, &of.J, &of.gamma, &others}) writer.write(*nodes, table);
  LinesOfNumbers more(writer.count());
  ConstrainedAcceleration found = constrained_acceleration(more, numbers(of.mass), numbers(of.right), numbers(of.J), numbers(of.gamma),
                                                           with_multipliers && !are_found_behind);
  if (found.x.empty()) return {};
  const auto to_number = [&](int node) { return writer.number(node); };
  decided.put_back(found.x, to_number);
  unknowns.leave(more, found.x, to_number);
  if (are_found_behind) found.lambda = multipliers_at(more, numbers(given.mass), numbers(given.right), numbers(given.J), found.x);
  table.lines.insert(table.lines.end(), more.lines.begin(), more.lines.end());
  writer.go_on_from(more.count());
  return evaluated(std::move(table), {nullptr, std::move(found.x), std::move(found.lambda), std::move(found.pivots), std::move(found.row_pivots)}, others,
                   most);
}

// Both right sides are solved in the graph. Their eliminations are the same nodes, which the graph has once.
template <class Number>
[[gnu::cold]] typename TracedLines<Number>::Solved TracedLines<Number>::solved_projection(const LimitsOfPivots& limits, std::size_t most) {
  TracedEquations<Number>& e = equations();
  formula::BasicGraph<Number>& graph = e.graph();
  NodesOfGraph<formula::BasicGraph<Number>> nodes{graph};
  const std::vector<int> mass = lower_triangle(e.mass), J = rows_of_constraints(e.J, e.n()), at_rest(e.n(), -1);
  const auto way_back = [&](const std::vector<int>& residuals) {
    std::vector<int> wanted;
    for (const int node : residuals) wanted.push_back(node < 0 || graph.is_constant(node, 0.0) ? -1 : graph.scaled(node, -1.0));
    ConstrainedAcceleration found = constrained_acceleration(nodes, mass, at_rest, J, std::move(wanted));
    for (int& x : found.x)
      if (x < 0) x = graph.constant(0.0);
    return found;
  };
  ConstrainedAcceleration positions = way_back(e.phi);
  std::vector<int> others = required();
  for (const std::vector<int>& read : {e.phi, e.velocity, e.J.nodes()}) append(others, read);
  return solved_in_graph(std::move(positions), way_back(e.velocity).x, others, limits, most);
}

template <class Number>
[[gnu::cold]] typename TracedLines<Number>::Solved TracedLines<Number>::solved_in_graph(ConstrainedAcceleration found, const std::vector<int>& columns,
                                                                                        const std::vector<int>& others, const LimitsOfPivots& limits,
                                                                                        std::size_t most) {
  if (found.x.empty() || !keep_variable(found.pivots, limits.singular) || !keep_variable(found.row_pivots, limits.dependent)) return {};
  std::vector<int> all = found.x;
  append(all, columns);
  append(all, others);
  for (const auto* pivots : {&found.pivots, &found.row_pivots})
    for (const auto& [pivot, whole] : *pivots) append(all, {pivot, whole});
  formula::LineTable table;
  shared_->writer->write(all, table);
  return evaluated(std::move(table),
                   {nullptr, numbers(found.x), numbers(columns), numbers_of_pivots(std::move(found.pivots)),
                    numbers_of_pivots(std::move(found.row_pivots))}, others, most);
}

// With lines.
template <class Number>
[[gnu::cold]] typename TracedLines<Number>::Solved TracedLines<Number>::evaluated(formula::LineTable table, Solved found, const std::vector<int>& others,
                                                                                  std::size_t most) {
  if (shared_->writer->count() > most) return {};
  found.lines = evaluator(std::move(table));
  for (const Requirement& r : equations().requirements) found.required.emplace_back(shared_->writer->number(r.node), r);
  for (const formula::Guard& g : equations().guards) {
    found.sides.push_back(g);
    found.sides.back().node = shared_->writer->number(g.node);
  }
  for (const std::vector<int>& read : {numbers(others), found.x, found.columns}) found.lines->add_read(read);
  for (const auto* pivots : {&found.pivots, &found.row_pivots})
    for (const auto& [pivot, whole] : *pivots) found.lines->add_read(std::array{pivot, whole});
  return found;
}

template <class Number>
[[gnu::cold]] TracedMotion<Number>::TracedMotion(TracedEquations<Number> equations) : lines_(std::move(equations)) {
  TracedEquations<Number>& e = lines_.equations();
  std::vector<int> outputs;
  if (e.mass_is_diagonal) {
    for (std::size_t i = 0; i < e.n(); ++i) {
      if (e.mass.row(i).empty()) return;  // no inertia: the general evaluation reports it
      outputs.push_back(e.graph().quotient(e.right[i], e.mass.row(i)[0].what));
    }
  } else {
    outputs = e.right;
    std::vector<int> rows, columns;
    for (std::size_t i = 0; i < e.n(); ++i) {
      if (e.mass.row(i).empty() || static_cast<std::size_t>(e.mass.row(i).back().column) != i) return;
      for (const auto& entry : e.mass.row(i)) {
        rows.push_back(static_cast<int>(i));
        columns.push_back(entry.column);
      }
    }
    factors_.emplace(e.n(), rows, columns);
  }
  const std::vector<int> nodes = e.mass.nodes();
  std::vector<int> all = outputs;
  if (!e.mass_is_constant) append(all, nodes);
  append(all, e.zdot);
  append(all, lines_.required());
  table_ = lines_.written(all);
  right_ = lines_.numbers(outputs);
  zdot_ = lines_.numbers(e.zdot);
  values_.resize(nodes.size());
  if (e.mass_is_constant) {
    for (std::size_t k = 0; k < nodes.size(); ++k) values_[k] = e.graph()[nodes[k]].c;
    for (std::size_t i = 0; i < e.n(); ++i)
      if (!(values_[e.mass.starts[i + 1] - 1] > 0.0)) return;
    if (factors_ && !factored()) return;
  } else {
    mass_ = lines_.numbers(nodes);
  }
  is_known_ = true;
}

}  // namespace qdot::detail
