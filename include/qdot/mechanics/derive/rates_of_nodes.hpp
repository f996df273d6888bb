#pragma once
// SPDX-License-Identifier: MIT
//
// How formulas change along a motion that has no accelerations.
//
// Formulas of q, q̇ and t are nodes of a graph (ad/formula/graph.hpp). With q̈ = 0 the chain rule gives each of them a rate that is a formula, too: that of
// q_i is q̇_i, that of q̇_i is 0. Equations of motion have q̈ in one place only, M q̈, so all else that is differentiated by time in them is
// such a rate.

#include <cstddef>
#include <span>
#include <vector>

#include "qdot/ad/formula/coefficient.hpp"
#include "qdot/mechanics/derive/derived_equations.hpp"

namespace qdot::detail {

/// d/dt of nodes at q̈ = 0: variables are q, q̇, t; all others stay as they are.
template <class Graph>
class RatesOfNodes {
 public:
  constexpr RatesOfNodes(Graph& graph, int n) : graph_(graph), n_(n) {}

  constexpr Graph& graph() const { return graph_; }
  /// Makes room to remember the rates of nodes up to this one.
  constexpr void remember_to(int last) {
    if (rates_.size() <= static_cast<std::size_t>(last)) rates_.resize(static_cast<std::size_t>(last) + 1, -1);
  }
  /// Makes those of nodes and of all that they consist of, in the order of the graph: then none is far from those that it needs.
  [[gnu::cold]] constexpr void remember(std::span<const int> nodes) {
    const std::vector<char> needed = graph_.needed_for(nodes);
    remember_to(static_cast<int>(needed.size()) - 1);
    for (std::size_t w = 0; w < needed.size(); ++w)
      if (needed[w] != 0) of(static_cast<int>(w));
  }
  /// 1 + the rate of a node that is remembered; 0 of others.
  constexpr int known(int x) const { return static_cast<std::size_t>(x) < rates_.size() ? rates_[static_cast<std::size_t>(x)] + 1 : 0; }

  constexpr int of(int x) {
    if (known(x) > 0) return known(x) - 1;
    const typename Graph::Node w = graph_[x];
    int rate = graph_.constant(0.0);
    const auto add = [&](int slope, int of) {
      const int part = times(slope, of);
      rate = graph_.sum(rate, part);
    };
    switch (w.kind) {
      case formula::Kind::constant: break;
      case formula::Kind::variable:
        if (w.a < n_) rate = graph_.variable(n_ + w.a);
        if (w.a == 2 * n_) rate = graph_.constant(1.0);
        break;
      case formula::Kind::affine:
        rate = graph_.scaled(of(w.a), w.ca);
        if (w.b >= 0) rate = graph_.sum(rate, graph_.scaled(of(w.b), w.cb));
        break;
      case formula::Kind::product:
        add(of(w.a), w.b);
        add(of(w.b), w.a);
        break;
      case formula::Kind::quotient: {
        const int below = graph_.product(x, of(w.b));
        rate = graph_.quotient(graph_.difference(of(w.a), below), w.b);
        break;
      }
      case formula::Kind::power: {
        const int slope = graph_.scaled(graph_.power(w.a, formula::decisive(w.c) - 1.0), w.c);
        add(of(w.a), slope);
        break;
      }
      case formula::Kind::function:
        add(of(w.a), graph_.slope(x));
        if (w.b >= 0) add(of(w.b), graph_.second_slope(x));
        break;
    }
    if (static_cast<std::size_t>(x) < rates_.size()) rates_[static_cast<std::size_t>(x)] = rate;
    return rate;
  }

 private:
  // x y; of (a y) y that is a y², which velocities along x and along y share.
  constexpr int times(int x, int y) {
    typename Graph::Node w = graph_[x];
    auto factor = w.ca;
    if (w.kind == formula::Kind::affine && w.b < 0 && formula::decisive(w.c) == 0.0) w = graph_[w.a];
    else factor = 1.0;
    if (w.kind != formula::Kind::product || (w.a != y && w.b != y)) return graph_.product(x, y);
    const int square = graph_.product(y, y);
    return graph_.scaled(graph_.product(w.a == y ? w.b : w.a, square), factor);
  }

  Graph& graph_;
  int n_;
  std::vector<int> rates_;
};

}  // namespace qdot::detail
