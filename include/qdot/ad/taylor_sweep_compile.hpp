#pragma once
// SPDX-License-Identifier: MIT
//
// From a graph to a sweep: which nodes are needed, in which order, and where their series live.
//
//     needed     everything that the outputs are made of, and the slopes of functions, whose series are
//                needed one order later than the function's own
//     late       what depends on a late variable; early: what the early outputs are made of
//     merged     an affine node that only one other affine node uses is written out there, so that a long
//                sum is one node with many terms
//     order      by depth, so that arguments stand before what is made of them
//
// Included by taylor_sweep.hpp.

#include <algorithm>
#include <utility>
#include <vector>

#include "qdot/ad/taylor_sweep.hpp"

namespace qdot::taylor {

inline void Sweep::compile(Graph& graph, const SweepOutputs& outputs) {
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
  for (int w = 0; w < count; ++w)
    if (need[index(w)] != Need::nothing && graph[w].kind == Kind::affine)
      each_argument(w, [&](int x) {
        if (graph[x].kind == Kind::affine && uses[index(x)] == 1 && need[index(x)] == need[index(w)]) merged[index(x)] = 1;
      });

  std::vector<int> order;
  for (int w = 0; w < count; ++w)
    if (need[index(w)] != Need::nothing && !merged[index(w)]) order.push_back(w);
  std::stable_sort(order.begin(), order.end(), [&](int x, int y) {
    return std::pair(need[index(x)] == Need::value, depth[index(x)]) < std::pair(need[index(y)] == Need::value, depth[index(y)]);
  });
  slot_of_.assign(index(count), -1);
  for (std::size_t i = 0; i < order.size(); ++i) {
    slot_of_[index(order[i])] = static_cast<int>(i);
    if (need[index(order[i])] == Need::series) series_count_ = static_cast<int>(i) + 1;
  }

  data_.clear();
  values_.assign(order.size(), 0.0);
  inverse_ = interior_ = latest_ = values_;

  for (const int w : order) {
    const Node& node = graph[w];
    Formula s{.kind = node.kind, .function = node.function, .slot = slot(w), .c = node.c};
    if (node.kind == Kind::variable) variables_.push_back(s.slot);
    if (node.kind == Kind::constant) values_[index(s.slot)] = node.c;
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
    } else {
      s.a = slot(node.a);
      add_term(node.a, 0.0);
      if (node.b >= 0) s.b = slot(node.b);
      if (node.b >= 0 && node.b != node.a) add_term(node.b, 0.0);
      if (slope_a[index(w)] >= 0) s.slope_a = slot(slope_a[index(w)]);
      if (slope_b[index(w)] >= 0) s.slope_b = slot(slope_b[index(w)]);
    }
    s.count = static_cast<int>(terms_.size()) - s.first;
    formulas_.push_back(s);
    if (need[index(w)] != Need::series) continue;
    add_interior(s);
    const End end{s.slot, s.first, s.count};
    if (!is_late[index(w)] || is_early[index(w)]) early_.push_back(end);
    if (is_late[index(w)]) late_.push_back(end);
  }
  // Values that no series needs may be arguments of nothing but values: along the graph, whatever the slots.
  std::stable_sort(formulas_.begin(), formulas_.end(), [&](const Formula& x, const Formula& y) {
    return depth[index(order[index(x.slot)])] < depth[index(order[index(y.slot)])];
  });
}

// Makes the places of the series that an interior needs, unless another one needed them already.
inline void Sweep::add_interior(const Formula& s) {
  const auto place = [&](std::vector<Place>& places, int slot) {
    for (const Place& known : places)
      if (known.slot == slot) return known.place;
    places.push_back({slot, data_.size()});
    data_.resize(data_.size() + index(highest_ + 1), 0.0);
    return places.back().place;
  };
  const auto forward = [&](int slot) { return place(forward_, slot) + 1; };
  const auto weighted = [&](int slot) { return place(weighted_, slot) + 1; };
  const auto backward = [&](int slot) { return place(backward_, slot); };
  switch (s.kind) {
    case Kind::product: (s.a == s.b ? squares_ : products_).push_back({s.slot, forward(s.a), backward(s.b)}); break;
    case Kind::quotient: quotients_.push_back({s.slot, forward(s.b), backward(s.slot)}); break;
    case Kind::power: powers_.push_back({s.slot, forward(s.a), backward(s.slot), weighted(s.a), s.c}); break;
    case Kind::function:
      functions_.push_back({s.slot, 0, backward(s.slope_a), weighted(s.a)});
      if (s.b >= 0) second_arguments_.push_back({s.slot, 0, backward(s.slope_b), weighted(s.b)});
      break;
    default: break;
  }
}

}  // namespace qdot::taylor
