#pragma once
// SPDX-License-Identifier: MIT
//
// Lagrange's equations by differentiating T and V as they are written.
//
// Multiplied out (mechanics/derive/by_terms.hpp), the kinetic energy of a chain of 32 links has thousands of terms, and that of a body turned by a
// quaternion has powers of its length in all of them. But the user's own T has few operations, because what terms have in common is computed
// once: v_k = v_{k−1} + …. Derivatives of graphs keep that:
//
//     p = ∂T/∂q̇   (one walk back),     M_ij = ∂p_i/∂q̇_j   (one walk back for each row),     r = ∂L/∂q − ṗ at q̈ = 0   (one walk forwards).

#include <cstddef>
#include <span>
#include <vector>

#include "qdot/mechanics/derive/derived_equations.hpp"

namespace qdot::detail {

/// d/dt of nodes at q̈ = 0: variables are q, q̇, t; all others stay as they are.
template <class Graph>
class RatesOfNodes {
 public:
  constexpr RatesOfNodes(Graph& graph, int n) : graph_(graph), n_(n) {}

  /// Makes room to remember the rates of nodes up to this one.
  constexpr void remember_to(int last) { rates_.resize(static_cast<std::size_t>(last) + 1, -1); }
  /// 1 + the rate of a node that is remembered; 0 of others.
  constexpr int known(int x) const { return static_cast<std::size_t>(x) < rates_.size() ? rates_[static_cast<std::size_t>(x)] + 1 : 0; }
  constexpr void append_known(int rate_and_one) { rates_.push_back(rate_and_one - 1); }

  constexpr int of(int x) {
    if (known(x) > 0) return known(x) - 1;
    const typename Graph::Node w = graph_[x];
    int rate = graph_.constant(0.0);
    const auto add = [&](int slope, int of) {
      const int part = graph_.product(slope, of);
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
  Graph& graph_;
  int n_;
  std::vector<int> rates_;
};

/// p, M and r of T and V; −1 in M is zero.
struct GraphEquations {
  std::vector<int> p, mass, right;  // of M the lower triangle, row by row
};
template <class Graph>
[[gnu::cold]] GraphEquations equations_by_graph(Graph& graph, int n, int T, int V) {
  const std::vector<int> q = variables_of(graph, 0, n), qdot = variables_of(graph, n, n);
  GraphEquations e{.p = graph.gradient(T, qdot, graph.dependence(T, qdot)), .mass = {}, .right = {}};
  const int L = graph.difference(T, V);
  const std::vector<int> force = graph.gradient(L, q, graph.dependence(L, q));
  RatesOfNodes<Graph> rates(graph, n);
  rates.remember_to(static_cast<int>(graph.nodes().size()));
  for (std::size_t i = 0; i < q.size(); ++i) e.right.push_back(graph.difference(force[i], rates.of(e.p[i])));
  for (std::size_t i = 0; i < q.size(); ++i)
    for (const int m : graph.gradient(e.p[i], std::span<const int>(qdot).first(i + 1), graph.dependence(e.p[i], qdot)))
      e.mass.push_back(graph.is_constant(m, 0.0) ? -1 : m);
  return e;
}

}  // namespace qdot::detail
