#pragma once
// SPDX-License-Identifier: MIT
//
// From a graph to a sweep (ad/series/sweep.hpp): which nodes are needed, and in which order.
//
//     needed     everything that the outputs are made of, and the slopes of functions, whose series are
//                needed one order later than the function's own
//     late       what depends on a late variable and is wanted afterwards; early: what the early outputs are made of
//     merged     an affine node that only one other affine node uses is written out there, so that a long
//                sum is one node with many terms
//     order      by depth, so that arguments stand before what is made of them

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "qdot/ad/formula/graph.hpp"
#include "qdot/ad/formula/in_order.hpp"
#include "qdot/ad/series/sweep_outputs.hpp"

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

}  // namespace qdot::taylor
