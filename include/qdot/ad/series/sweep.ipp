#pragma once
// SPDX-License-Identifier: MIT
//
// How a sweep (ad/series/sweep.hpp) is made of a graph: where series live, which lanes interiors have, and the ends as two tables of lines.
//
//     early     what interiors of quotients, powers and functions are, then coefficients k where late variables have none
//     late      coefficients k of what depends on late variables, and copies of the rates for the next order
//
// Where there is a recurrence, the early table begins with the variables and ends with the solution for the late ones. This is M₀ v_k = τ/k · F_{k−1} −
// p_k, by the factors of M₀; entries of L that are zero for all states are left out.
//
// In the early table a late variable is zero, and what is zero is left out. So a node that depends on late variables has two numbers, one of each table;
// other nodes have one.

#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

#include "qdot/ad/formula/in_order.hpp"
#include "qdot/ad/native/straight_lines.hpp"
#include "qdot/ad/series/late_solution.hpp"
#include "qdot/ad/series/line_list.hpp"
#include "qdot/ad/series/sweep.hpp"
#include "qdot/ad/series/sweep_outputs.hpp"
#include "qdot/ad/series/swept_nodes.hpp"

namespace qdot::taylor {

[[gnu::cold]] inline void Sweep::compile(Graph& graph, const SweepOutputs& outputs) {
  const SweptNodes nodes(graph, outputs);
  const std::vector<int>& order = nodes.order;
  slot_of_.assign(nodes.need.size(), -1);
  for (std::size_t i = 0; i < order.size(); ++i) {
    slot_of_[index(order[i])] = static_cast<int>(i);
    if (nodes.need[index(order[i])] == SweptNodes::Need::series) series_count_ = static_cast<int>(i) + 1;
  }
  values_.assign(order.size(), 0.0);
  auto next_factor = static_cast<int>(first_factor);
  std::vector<End> made;
  for (const int w : order) add_node(nodes, w, next_factor, made);
  take_recurrence(graph, outputs.recurrence);
  place_lanes();
  for (End& each : made) each.lane = final_lane(each.lane);
  formula::put_in_order(made, [](const End& x, const End& y) { return x.depth < y.depth; }); // so that arguments come first
  std::vector<char> late_slots(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) late_slots[i] = nodes.is_late[index(order[i])];
  std::vector<char> read_slots(order.size());
  for (const auto* list : {&outputs.early, &outputs.series, &outputs.late})
    for (const int node : *list) read_slots[index(slot(node))] = 1;
  write_ends(made, late_slots, read_slots, static_cast<Number>(next_factor));
  // Values that no series needs may be arguments of nothing but values: along the graph, whatever the slots. Within a depth
  // those of one kind follow each other, which processors foresee.
  const auto place = [&](const Formula& s) { return std::tuple(nodes.depth[index(order[index(s.slot)])], s.kind, s.function, s.count); };
  formula::put_in_order(formulas_, [&](const Formula& x, const Formula& y) { return place(x) < place(y); });
  for (const Formula& s : formulas_)
    if (s.slot < series_count_ && s.kind != Kind::affine) series_.push_back(s);
  pair_sines_with_cosines();
}

// Adds the formula of a node with its terms, and its end where it has a series.
[[gnu::cold]] inline void Sweep::add_node(const SweptNodes& nodes, int w, int& next_factor, std::vector<End>& made) {
  const Node& node = nodes.graph()[w];
  Formula s{.kind = node.kind, .function = node.function, .slot = slot(w), .c = node.c};
  if (node.kind == Kind::variable) variables_.push_back(s.slot);
  if (node.kind == Kind::constant) {
    values_[index(s.slot)] = node.c;
    constants_.push_back(s.slot);
  }
  if (node.kind == Kind::variable || node.kind == Kind::constant) return;
  s.first = static_cast<int>(terms_.size());
  if (node.kind == Kind::affine) {
    add_affine_terms(nodes, w, s);
  } else {
    add_arguments(nodes, w, s);
    s.factor = std::exchange(next_factor, next_factor + 2);
  }
  s.count = static_cast<int>(terms_.size()) - s.first;
  formulas_.push_back(s);
  if (nodes.need[index(w)] != SweptNodes::Need::series) return;
  const bool late = nodes.is_late[index(w)];
  made.push_back({s.slot, add_interior(s), s.first, s.count, s.factor, nodes.depth[index(w)], !late || nodes.is_early[index(w)],
                  late && nodes.lasts[index(w)]});
}

// Of an affine node and those merged into it, in the order in which their coefficients are known.
[[gnu::cold]] inline void Sweep::add_affine_terms(const SweptNodes& nodes, int w, Formula& s) {
  const Graph& graph = nodes.graph();
  const auto write_out = [&](const auto& self, int x, double factor) -> void {
    if (x != w && !nodes.merged[index(x)]) {
      terms_.push_back(slot(x));
      factors_.push_back(factor);
      return;
    }
    if (x != w) s.c += factor * graph[x].c;
    self(self, graph[x].a, factor * graph[x].ca);
    if (graph[x].b >= 0) self(self, graph[x].b, factor * graph[x].cb);
  };
  write_out(write_out, w, 1.0);
  for (std::size_t i = index(s.first) + 1; i < terms_.size(); ++i)
    for (std::size_t j = i; j > index(s.first) && nodes.arrival(terms_[j]) < nodes.arrival(terms_[j - 1]); --j) {
      std::swap(terms_[j], terms_[j - 1]);
      std::swap(factors_[j], factors_[j - 1]);
    }
}

// Of any other node; factors of its terms are set by start().
[[gnu::cold]] inline void Sweep::add_arguments(const SweptNodes& nodes, int w, Formula& s) {
  const Node& node = nodes.graph()[w];
  const auto add_term = [&](int slot) {
    terms_.push_back(slot);
    factors_.push_back(0.0);
  };
  s.a = slot(node.a);
  if (node.b >= 0) s.b = slot(node.b);
  if (node.kind == Kind::product && nodes.arrival(s.b) < nodes.arrival(s.a)) std::swap(s.a, s.b);
  add_term(s.a);
  if (node.b >= 0 && node.b != node.a) add_term(s.b);
  if (nodes.slope_a[index(w)] >= 0) s.slope_a = slot(nodes.slope_a[index(w)]);
  if (nodes.slope_b[index(w)] >= 0) s.slope_b = slot(nodes.slope_b[index(w)]);
}

// Nodes become slots, or −1 where an entry of M or W is always zero. Multipliers get slots behind those of the nodes.
inline void Sweep::take_recurrence(const Graph& graph, const Recurrence& recurrence) {
  recurrence_ = recurrence;
  for (auto* nodes : {&recurrence_.variables, &recurrence_.rates, &recurrence_.late, &recurrence_.forces, &recurrence_.momenta, &recurrence_.rows})
    for (int& node : *nodes) node = slot(node);
  if (recurrence_.time >= 0) recurrence_.time = slot(recurrence_.time);
  rates_ = recurrence_.rates;
  rates_.insert(rates_.end(), recurrence_.forces.begin(), recurrence_.forces.end());
  first_multiplier_ = values_.size();
  values_.resize(first_multiplier_ + recurrence_.rows.size(), 0.0);
  for (std::size_t i = 0; i < recurrence_.jacobian.size(); ++i) {
    const int node = recurrence_.jacobian[i];
    if (graph[node].kind == Kind::constant) continue;
    reactions_.push_back({static_cast<int>(plain_.size()), i % recurrence_.late.size()});
    plain_.push_back({slot(node), static_cast<int>(first_multiplier_ + i / recurrence_.late.size())});
  }
  for (auto* nodes : {&recurrence_.mass, &recurrence_.jacobian})
    for (int& node : *nodes) node = graph.is_constant(node, 0.0) ? -1 : slot(node);
}

inline void Sweep::pair_sines_with_cosines() {
  std::vector<Formula*> sines, cosines;
  for (Formula& s : formulas_) {
    if (s.kind == Kind::function && s.function == Function::sin) sines.push_back(&s);
    if (s.kind == Kind::function && s.function == Function::cos) cosines.push_back(&s);
  }
  for (Formula* sine : sines)
    for (Formula* cosine : cosines)
      if (sine->a == cosine->a) {
        sine->partner = cosine->slot;
        cosine->partner = sine->slot;
      }
}

// Makes the lanes of a node's interior. Returns the number of its lane: among plain ones as it is, among weighted ones and
// squares marked, and −1 where there is nothing to sum.
inline int Sweep::add_interior(const Formula& s) {
  const auto plain = [&](int left, int right) {
    plain_.push_back({left, right});
    return static_cast<int>(plain_.size()) - 1;
  };
  const auto weighted = [&](int left, int right) {
    weighted_.push_back({left, right});
    return static_cast<int>(weighted_.size()) - 1 + weighted_mark;
  };
  switch (s.kind) {
    case Kind::product:
      if (s.a != s.b) return plain(s.a, s.b);
      squares_.push_back(s.a);
      return static_cast<int>(squares_.size()) - 1 + square_mark;
    case Kind::quotient: {
      const int lane = plain(s.b, s.slot);
      quotients_.push_back({s.factor, lane, -1});
      return lane;
    }
    case Kind::power: {
      const int lane = plain(s.a, s.slot);
      powers_.push_back({s.factor, lane, weighted(s.a, s.slot), s.c});
      return lane;
    }
    case Kind::function: {
      const int lane = weighted(s.a, s.slope_a);
      if (s.b >= 0) second_arguments_.push_back({s.factor, lane, weighted(s.b, s.slope_b)});
      return lane;
    }
    default: return -1;
  }
}

// Weighted lanes stand behind the plain ones, squares in rows of their own behind both.
inline int Sweep::final_lane(int lane) const {
  if (lane < 0) return -1;
  if (lane >= square_mark) return lane - square_mark + static_cast<int>(rounded_to_row(plain_.size() + weighted_.size()));
  if (lane >= weighted_mark) return lane - weighted_mark + static_cast<int>(plain_.size());
  return lane;
}

// Lanes, now that all are known.
inline void Sweep::place_lanes() {
  for (auto* list : {&quotients_, &powers_, &second_arguments_})
    for (Interior& each : *list) {
      each.lane = final_lane(each.lane);
      each.other = final_lane(each.other);
    }
}

// @param is_late, is_read  of slots: depends on late variables, is asked for by the caller
[[gnu::cold]] inline void Sweep::write_ends(const std::vector<End>& ends, const std::vector<char>& is_late, const std::vector<char>& is_read, Number next) {
  next = after_inputs(is_late, next);
  std::vector<char> is_constant(values_.size(), 0);  // whose coefficients are zero
  for (const int slot : constants_) is_constant[index(slot)] = 1;

  LineList early(next, 3 * ends.size());
  for (std::size_t i = 0; i < recurrence_.variables.size(); ++i) {
    const std::size_t slot = index(recurrence_.variables[i]);
    number_[0][slot] = number_[1][slot] = early.product(rate_number, first_rate_ + static_cast<Number>(i));
  }
  if (recurrence_.time >= 0) time_ = number_[1][index(recurrence_.time)];
  const std::vector<Number> interior = finished_interiors(early);
  for (const End& end : ends) {
    if (!end.early) continue;
    number_[0][index(end.slot)] = end_sum(early, end, terms_in(number_[0], end, is_constant), interior);
    if (!is_late[index(end.slot)]) number_[1][index(end.slot)] = number_[0][index(end.slot)];
  }
  if (!recurrence_.momenta.empty()) solve_for_late(early, interior);
  LineList late(next, 3 * ends.size());
  for (const End& end : ends)
    if (end.late) number_[1][index(end.slot)] = end_sum(late, end, terms_in(number_[1], end, is_constant), interior);
  for (std::size_t i = 0; i < rates_.size(); ++i) late.copy(number_[1][index(rates_[i])], first_rate_ + static_cast<Number>(i));

  x_.assign(next, 0.0);
  set_rows();
  set_tables({early.finished(), late.finished()}, is_read);
}

// Numbers what the early table reads and does not write, from `next` on; returns the number after them.
[[gnu::cold]] inline Sweep::Number Sweep::after_inputs(const std::vector<char>& is_late, Number next) {
  mass_factors_ = next;
  next += static_cast<Number>(recurrence_.mass.size());
  row_factors_ = next;
  next += static_cast<Number>(2 * recurrence_.jacobian.size() + triangle(recurrence_.rows.size()));
  first_rate_ = next;  // which the late table writes
  next += static_cast<Number>(rates_.size());
  interiors_ = next;
  next += static_cast<Number>(rounded_to_row(plain_.size() + weighted_.size()) + rounded_to_row(squares_.size()));
  for (auto& number : number_) number.assign(values_.size(), zero);
  for (const auto* list : {&variables_, &constants_})
    for (const int slot : *list) {
      number_[1][index(slot)] = next++;
      if (!is_late[index(slot)]) number_[0][index(slot)] = number_[1][index(slot)];
    }
  return next;
}

// Numbers of the interiors, of each lane.
[[gnu::cold]] inline std::vector<Sweep::Number> Sweep::finished_interiors(LineList& early) const {
  std::vector<Number> interior(rounded_to_row(plain_.size() + weighted_.size()) + rounded_to_row(squares_.size()));
  for (std::size_t lane = 0; lane < interior.size(); ++lane) interior[lane] = static_cast<Number>(interiors_ + lane);
  for (std::size_t i = 0; i < weighted_.size(); ++i) {
    Number& sum = interior[plain_.size() + i];
    sum = early.product(sum, inverse_order_number);
  }
  for (const Interior& s : quotients_) interior[index(s.lane)] = early.less_product(static_cast<Number>(s.factor), interior[index(s.lane)], zero);
  for (const Interior& s : powers_) {
    const Number both = early.combination(s.c + 1.0, interior[index(s.other)], -1.0, interior[index(s.lane)]);
    interior[index(s.lane)] = early.product(static_cast<Number>(s.factor + 1), both);
  }
  for (const Interior& s : second_arguments_) interior[index(s.lane)] = early.sum(interior[index(s.lane)], interior[index(s.other)]);
  return interior;
}

// The terms of an end that are not zero, where coefficients have these numbers.
[[gnu::cold]] inline std::vector<Sweep::EndTerm> Sweep::terms_in(const std::vector<Number>& number, const End& end,
                                                                 const std::vector<char>& is_constant) const {
  const auto is_zero = [&](int slot) { return number[index(slot)] == zero || is_constant[index(slot)] != 0; };
  std::vector<EndTerm> terms;
  for (int i = 0; i < end.terms; ++i)
    if (const int slot = terms_[index(end.first + i)]; !is_zero(slot)) terms.push_back({i, number[index(slot)]});
  return terms;
}

// Writes the lines of an end; returns the number of the coefficient that they make.
[[gnu::cold]] inline Sweep::Number Sweep::end_sum(LineList& lines, const End& end, const std::vector<EndTerm>& terms,
                                                  const std::vector<Number>& interior) const {
  if (end.lane >= 0) {
    Number sum = interior[index(end.lane)];
    for (const auto& [i, coefficient] : terms) sum = lines.product_sum(static_cast<Number>(end.factor + i), coefficient, sum);
    return sum;
  }
  if (terms.empty()) return zero;
  const auto factor = [&](std::size_t i) { return factors_[index(end.first + terms[i].first)]; };
  if (terms.size() == 1) return lines.scaled(factor(0), terms[0].second);
  Number sum = lines.combination(factor(0), terms[0].second, factor(1), terms[1].second);
  for (std::size_t i = 2; i < terms.size(); ++i) sum = lines.combination(1.0, sum, factor(i), terms[i].second);
  return sum;
}

// The lines of a recurrence that give the late variables' coefficients, and the multipliers.
[[gnu::cold]] inline void Sweep::solve_for_late(LineList& early, const std::vector<Number>& interior) {
  std::vector<Number> right, rows;
  for (std::size_t i = 0; i < recurrence_.momenta.size(); ++i)
    right.push_back(early.product(rate_number, first_rate_ + static_cast<Number>(recurrence_.rates.size() + i)));
  for (const Reaction& of : reactions_) right[of.column] = early.product_sum(rate_number, interior[index(of.lane)], right[of.column]);
  for (std::size_t i = 0; i < right.size(); ++i)
    if (const Number p = number_[0][index(recurrence_.momenta[i])]; p != zero) right[i] = early.difference(right[i], p);
  for (const int slot : recurrence_.rows) rows.push_back(early.scaled(-1.0, number_[0][index(slot)]));
  const LateSolution found = late_solution(early, recurrence_, mass_factors_, row_factors_, std::move(right), std::move(rows));
  for (std::size_t i = 0; i < found.late.size(); ++i) number_[1][index(recurrence_.late[i])] = found.late[i];
  for (std::size_t r = 0; r < found.multipliers.size(); ++r)
    number_[1][first_multiplier_ + r] = early.quotient(found.multipliers[r], rate_number);
}

// Where the factors of the interiors stand.
[[gnu::cold]] inline void Sweep::set_rows() {
  std::vector<Number> left, right, squared;
  for (const auto* list : {&plain_, &weighted_})
    for (const Lane& lane : *list) {
      left.push_back(number_[1][index(lane.left)]);
      right.push_back(number_[1][index(lane.right)]);
    }
  for (const int slot : squares_) squared.push_back(number_[1][index(slot)]);
  rows_.first_weighted = plain_.size();
  rows_.left.set(std::move(left), highest_);
  rows_.right.set(std::move(right), highest_);
  rows_.squares.set(std::move(squared), highest_);
}

// Each table knows what of it is read: by the rows, by the caller and by the other table.
[[gnu::cold]] inline void Sweep::set_tables(std::array<formula::LineTable, 2> tables, const std::vector<char>& is_read) {
  std::vector<int> read;
  for (const auto* list : {&rows_.left.places, &rows_.right.places, &rows_.squares.places}) read.insert(read.end(), list->begin(), list->end());
  for (std::size_t slot = 0; slot < values_.size(); ++slot)
    if (slot >= first_multiplier_ || is_read[slot] != 0)
      for (const auto& number : number_) read.push_back(static_cast<int>(number[slot]));
  std::array<std::vector<int>, 2> by_other;
  for (std::size_t i = 0; i < 2; ++i)
    for (const Line& line : tables[i].lines) for_each_operand(line, [&](Number number) { by_other[1 - i].push_back(static_cast<int>(number)); });
  for (std::size_t i = 0; i < 2; ++i) {
    ends_[i].set(std::move(tables[i]), x_.size());
    ends_[i].add_read(by_other[i]);
    ends_[i].add_read(read);
  }
}

}  // namespace qdot::taylor
