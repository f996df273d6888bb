#pragma once
// SPDX-License-Identifier: MIT
//
// From a graph to a sweep: which nodes are needed, in which order, and where their series live.
//
//     needed     everything that the outputs are made of, and the slopes of functions, whose series are
//                needed one order later than the function's own
//     late       what depends on a late variable and is wanted afterwards; early: what the early outputs are made of
//     merged     an affine node that only one other affine node uses is written out there, so that a long
//                sum is one node with many terms
//     order      by depth, so that arguments stand before what is made of them
//
// Included by ad/series/sweep.hpp.

#include <algorithm>
#include <cstddef>
#include <tuple>
#include <utility>
#include <vector>

#include "qdot/ad/formula/in_order.hpp"
#include "qdot/ad/series/sweep.hpp"

namespace qdot::taylor {

/// What a sweep has to know about the nodes of a graph: lists by node, and the order in which they are computed.
class SweptNodes {
 public:
  enum class Need : char { nothing, value, series };

  [[gnu::cold]] SweptNodes(Graph& graph, const SweepOutputs& outputs) : graph_(graph) {
    find_needed(outputs);
    find_late_and_early(outputs);
    find_lasting(outputs);
    find_merged();
    put_in_order();
  }

  const Graph& graph() const { return graph_; }
  /// When coefficient k of a slot is known, against those of others. Terms are added in this order, so that a sum waits for its last one only.
  std::pair<char, int> arrival(int slot) const { return {is_late[index(order[index(slot)])], slot}; }

  std::vector<Need> need;
  std::vector<int> slope_a, slope_b;  // nodes of a function's slopes, or −1
  std::vector<char> is_late, is_early, merged;
  std::vector<char> lasts;  // whose coefficient k is wanted after all late ones are known
  std::vector<int> depth, uses;
  std::vector<int> order;  // nodes by slot

 private:
  static constexpr std::size_t index(int i) { return static_cast<std::size_t>(i); }

  template <class Visit>
  void each_argument(int w, Visit&& visit) const {
    const Node& node = graph_[w];
    if (node.kind == Kind::constant || node.kind == Kind::variable) return;
    visit(node.a);
    if (node.b >= 0) visit(node.b);
  }

  [[gnu::cold]] void want(int node, Need how, std::vector<int>& open) {
    if (node < 0) return;
    need.resize(graph_.nodes().size(), Need::nothing);
    slope_a.resize(graph_.nodes().size(), -1);
    slope_b.resize(graph_.nodes().size(), -1);
    if (need[index(node)] >= how) return;
    need[index(node)] = how;
    open.push_back(node);
  }

  // Slopes of functions are new nodes of the graph.
  [[gnu::cold]] void find_needed(const SweepOutputs& outputs) {
    std::vector<int> open;
    for (const auto* list : {&outputs.early, &outputs.series, &outputs.late})
      for (const int node : *list) want(node, Need::series, open);
    for (const int node : outputs.values) want(node, Need::value, open);
    while (!open.empty()) {
      const int w = open.back();
      open.pop_back();
      const Node node = graph_[w];
      const Need how = need[index(w)];
      if (node.kind == Kind::constant || node.kind == Kind::variable) continue;
      want(node.a, how, open);
      want(node.b, how, open);
      if (node.kind != Kind::function || how != Need::series) continue;
      const int za = graph_.slope(w);
      const int zb = node.b < 0 ? -1 : graph_.second_slope(w);
      want(za, Need::series, open);
      want(zb, Need::series, open);
      slope_a[index(w)] = za;
      slope_b[index(w)] = zb;
    }
    count_ = static_cast<int>(need.size());
  }

  // Finds depths and uses, too.
  [[gnu::cold]] void find_late_and_early(const SweepOutputs& outputs) {
    for (auto* list : {&is_late, &is_early}) list->assign(need.size(), 0);
    for (auto* list : {&depth, &uses}) list->assign(need.size(), 0);
    for (const int node : outputs.late) is_late[index(node)] = 1;
    for (const int node : outputs.early) is_early[index(node)] = 1;
    for (const auto* list : {&outputs.early, &outputs.series, &outputs.values, &outputs.late})
      for (const int node : *list) ++uses[index(node)];
    for (int w = 0; w < count_; ++w) {
      if (need[index(w)] == Need::nothing) continue;
      each_argument(w, [&](int x) {
        is_late[index(w)] = is_late[index(w)] || is_late[index(x)];
        depth[index(w)] = std::max(depth[index(w)], depth[index(x)] + 1);
        ++uses[index(x)];
      });
      for (const int z : {slope_a[index(w)], slope_b[index(w)]})
        if (z >= 0) ++uses[index(z)];
    }
    mark_arguments(is_early);
  }

  // Marks what the marked nodes are made of.
  [[gnu::cold]] void mark_arguments(std::vector<char>& marks) const {
    for (int w = count_ - 1; w >= 0; --w)
      if (marks[index(w)]) each_argument(w, [&](int x) { marks[index(x)] = 1; });
  }

  // These are the outputs, what interiors of later orders are made of, and what these are made of themselves. The momenta are not among them.
  [[gnu::cold]] void find_lasting(const SweepOutputs& outputs) {
    lasts.assign(need.size(), 0);
    for (const auto* list : {&outputs.series, &outputs.late})
      for (const int node : *list) lasts[index(node)] = 1;
    for (int w = 0; w < count_; ++w) {
      if (need[index(w)] != Need::series || graph_[w].kind == Kind::affine) continue;
      each_argument(w, [&](int x) { lasts[index(x)] = 1; });
      for (const int z : {slope_a[index(w)], slope_b[index(w)]})
        if (z >= 0) lasts[index(z)] = 1;
      if (graph_[w].kind == Kind::quotient || graph_[w].kind == Kind::power) lasts[index(w)] = 1;
    }
    mark_arguments(lasts);
  }

  [[gnu::cold]] void find_merged() {
    merged.assign(need.size(), 0);
    for (int w = 0; w < count_; ++w)
      if (need[index(w)] != Need::nothing && graph_[w].kind == Kind::affine)
        each_argument(w, [&](int x) {
          if (graph_[x].kind == Kind::affine && uses[index(x)] == 1 && need[index(x)] == need[index(w)]) merged[index(x)] = 1;
        });
  }

  [[gnu::cold]] void put_in_order() {
    for (int w = 0; w < count_; ++w)
      if (need[index(w)] != Need::nothing && !merged[index(w)]) order.push_back(w);
    formula::put_in_order(order, [&](int x, int y) {
      return std::pair(need[index(x)] == Need::value, depth[index(x)]) < std::pair(need[index(y)] == Need::value, depth[index(y)]);
    });
  }

  Graph& graph_;
  int count_ = 0;
};

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

}  // namespace qdot::taylor

#include "qdot/ad/series/sweep_ends.hpp"
