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

[[gnu::cold]] inline void Sweep::compile(Graph& graph, const SweepOutputs& outputs) {
  enum class Need : char { nothing, value, series };
  std::vector<int> slope_a, slope_b, open;
  std::vector<Need> need;
  const auto want = [&](int node, Need how) {
    if (node < 0) return;
    need.resize(graph.nodes().size(), Need::nothing);
    slope_a.resize(graph.nodes().size(), -1);
    slope_b.resize(graph.nodes().size(), -1);
    if (need[index(node)] >= how) return;
    need[index(node)] = how;
    open.push_back(node);
  };
  for (const auto* list : {&outputs.early, &outputs.series, &outputs.late})
    for (const int node : *list) want(node, Need::series);
  for (const int node : outputs.values) want(node, Need::value);
  while (!open.empty()) {
    const int w = open.back();
    open.pop_back();
    const Node node = graph[w];
    const Need how = need[index(w)];
    if (node.kind == Kind::constant || node.kind == Kind::variable) continue;
    want(node.a, how);
    want(node.b, how);
    if (node.kind != Kind::function || how != Need::series) continue;
    const int za = graph.slope(w);
    const int zb = node.b < 0 ? -1 : graph.second_slope(w);
    want(za, Need::series);
    want(zb, Need::series);
    slope_a[index(w)] = za;
    slope_b[index(w)] = zb;
  }
  const int count = static_cast<int>(need.size());
  const auto each_argument = [&](int w, auto&& visit) {
    const Node& node = graph[w];
    if (node.kind == Kind::constant || node.kind == Kind::variable) return;
    visit(node.a);
    if (node.b >= 0) visit(node.b);
  };

  std::vector<char> is_late(index(count), 0), is_early(index(count), 0), merged(index(count), 0);
  std::vector<int> depth(index(count), 0), uses(index(count), 0);
  for (const int node : outputs.late) is_late[index(node)] = 1;
  for (const int node : outputs.early) is_early[index(node)] = 1;
  for (const auto* list : {&outputs.early, &outputs.series, &outputs.values, &outputs.late})
    for (const int node : *list) ++uses[index(node)];
  for (int w = 0; w < count; ++w) {
    if (need[index(w)] == Need::nothing) continue;
    each_argument(w, [&](int x) {
      is_late[index(w)] = is_late[index(w)] || is_late[index(x)];
      depth[index(w)] = std::max(depth[index(w)], depth[index(x)] + 1);
      ++uses[index(x)];
    });
    for (const int z : {slope_a[index(w)], slope_b[index(w)]})
      if (z >= 0) ++uses[index(z)];
  }
  for (int w = count - 1; w >= 0; --w)
    if (is_early[index(w)]) each_argument(w, [&](int x) { is_early[index(x)] = 1; });
  // Whose coefficient k is wanted after all late ones are known: the outputs', those that interiors of later orders are made
  // of, and what these are made of themselves. The momenta are not among them.
  std::vector<char> lasts(index(count), 0);
  for (const auto* list : {&outputs.series, &outputs.late})
    for (const int node : *list) lasts[index(node)] = 1;
  for (int w = 0; w < count; ++w) {
    if (need[index(w)] != Need::series || graph[w].kind == Kind::affine) continue;
    each_argument(w, [&](int x) { lasts[index(x)] = 1; });
    for (const int z : {slope_a[index(w)], slope_b[index(w)]})
      if (z >= 0) lasts[index(z)] = 1;
    if (graph[w].kind == Kind::quotient || graph[w].kind == Kind::power) lasts[index(w)] = 1;
  }
  for (int w = count - 1; w >= 0; --w)
    if (lasts[index(w)]) each_argument(w, [&](int x) { lasts[index(x)] = 1; });
  for (int w = 0; w < count; ++w)
    if (need[index(w)] != Need::nothing && graph[w].kind == Kind::affine)
      each_argument(w, [&](int x) {
        if (graph[x].kind == Kind::affine && uses[index(x)] == 1 && need[index(x)] == need[index(w)]) merged[index(x)] = 1;
      });

  std::vector<int> order;
  for (int w = 0; w < count; ++w)
    if (need[index(w)] != Need::nothing && !merged[index(w)]) order.push_back(w);
  formula::put_in_order(order, [&](int x, int y) {
    return std::pair(need[index(x)] == Need::value, depth[index(x)]) < std::pair(need[index(y)] == Need::value, depth[index(y)]);
  });
  slot_of_.assign(index(count), -1);
  for (std::size_t i = 0; i < order.size(); ++i) {
    slot_of_[index(order[i])] = static_cast<int>(i);
    if (need[index(order[i])] == Need::series) series_count_ = static_cast<int>(i) + 1;
  }

  values_.assign(order.size(), 0.0);
  auto next_factor = static_cast<int>(first_factor);

  // When coefficient k of a slot is known, against those of others. Terms are added in this order, so that a sum waits for its
  // last one only.
  const auto arrival = [&](int s) { return std::pair(is_late[index(order[index(s)])], s); };

  std::vector<End> made;
  for (const int w : order) {
    const Node& node = graph[w];
    Formula s{.kind = node.kind, .function = node.function, .slot = slot(w), .c = node.c};
    if (node.kind == Kind::variable) variables_.push_back(s.slot);
    if (node.kind == Kind::constant) {
      values_[index(s.slot)] = node.c;
      constants_.push_back(s.slot);
    }
    if (node.kind == Kind::variable || node.kind == Kind::constant) continue;
    s.first = static_cast<int>(terms_.size());
    const auto add_term = [&](int x, double factor) {
      terms_.push_back(slot(x));
      factors_.push_back(factor);
    };
    if (node.kind == Kind::affine) {
      const auto write_out = [&](const auto& self, int x, double factor) -> void {
        if (x != w && !merged[index(x)]) return add_term(x, factor);
        if (x != w) s.c += factor * graph[x].c;
        self(self, graph[x].a, factor * graph[x].ca);
        if (graph[x].b >= 0) self(self, graph[x].b, factor * graph[x].cb);
      };
      write_out(write_out, w, 1.0);
      for (std::size_t i = index(s.first) + 1; i < terms_.size(); ++i)
        for (std::size_t j = i; j > index(s.first) && arrival(terms_[j]) < arrival(terms_[j - 1]); --j) {
          std::swap(terms_[j], terms_[j - 1]);
          std::swap(factors_[j], factors_[j - 1]);
        }
    } else {
      int a = node.a, b = node.b;
      if (node.kind == Kind::product && arrival(slot(b)) < arrival(slot(a))) std::swap(a, b);
      s.a = slot(a);
      add_term(a, 0.0);
      if (b >= 0) s.b = slot(b);
      if (b >= 0 && b != a) add_term(b, 0.0);
      if (slope_a[index(w)] >= 0) s.slope_a = slot(slope_a[index(w)]);
      if (slope_b[index(w)] >= 0) s.slope_b = slot(slope_b[index(w)]);
      s.factor = std::exchange(next_factor, next_factor + 2);
    }
    s.count = static_cast<int>(terms_.size()) - s.first;
    formulas_.push_back(s);
    if (need[index(w)] != Need::series) continue;
    const bool late = is_late[index(w)];
    made.push_back({s.slot, add_interior(s), s.first, s.count, s.factor, depth[index(w)], !late || is_early[index(w)], late && lasts[index(w)]});
  }
  take_recurrence(graph, outputs.recurrence);
  place_lanes();
  for (End& each : made) each.lane = final_lane(each.lane);
  formula::put_in_order(made, [](const End& x, const End& y) { return x.depth < y.depth; }); // so that arguments come first
  std::vector<char> late_slots(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) late_slots[i] = is_late[index(order[i])];
  std::vector<char> read_slots(order.size());
  for (const auto* list : {&outputs.early, &outputs.series, &outputs.late})
    for (const int node : *list) read_slots[index(slot(node))] = 1;
  write_ends(made, late_slots, read_slots, static_cast<Number>(next_factor));
  // Values that no series needs may be arguments of nothing but values: along the graph, whatever the slots. Within a depth
  // those of one kind follow each other, which processors foresee.
  const auto place = [&](const Formula& s) { return std::tuple(depth[index(order[index(s.slot)])], s.kind, s.function, s.count); };
  formula::put_in_order(formulas_, [&](const Formula& x, const Formula& y) { return place(x) < place(y); });
  for (const Formula& s : formulas_)
    if (s.slot < series_count_ && s.kind != Kind::affine) series_.push_back(s);
  pair_sines_with_cosines();
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
