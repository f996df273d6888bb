#pragma once
// SPDX-License-Identifier: MIT
//
// What a derivation of Lagrange's equations ends with: M and r of M q̈ = r as nodes of a graph.
//
// Two ways lead there. By terms, the kinetic energy is multiplied out and simplified, as on paper (mechanics/derive/by_terms.hpp). By the
// graph, T is differentiated as it is written, which suits sums of squares of velocities, and many coordinates
// (mechanics/derive/derivatives_of_graph.hpp).

#include <algorithm>
#include <cstddef>
#include <vector>

#include "qdot/ad/formula/coefficient.hpp"
#include "qdot/ad/formula/graph.hpp"

namespace qdot::detail {

/// M and r, and derivatives of r − M a at fixed a, for ∂q̈/∂(q, q̇) = M⁻¹ ∂(r − M a)/∂(q, q̇) with a = q̈. −1 is zero.
struct DerivedJacobian {
  std::vector<int> mass;    // lower triangle, row by row
  std::vector<int> right;
  std::vector<int> slopes;  // of each row along q, then along q̇
};

/// q or q̇ as nodes.
template <class Graph>
constexpr std::vector<int> variables_of(Graph& graph, int first, int count) {
  std::vector<int> all;
  for (int i = 0; i < count; ++i) all.push_back(graph.variable(first + i));
  return all;
}

/// Adds the slopes to M and r; accelerations are the variables after q, q̇ and t, new ones: all lines of M and r come before them.
template <class Graph>
constexpr void differentiate(Graph& graph, int n, DerivedJacobian& jacobian) {
  const std::vector<int> state = variables_of(graph, 0, 2 * n), accelerations = variables_of(graph, 2 * n + 1, n);
  for (int i = 0; i < n; ++i) {
    int residual = jacobian.right[static_cast<std::size_t>(i)];
    for (int j = 0; j < n; ++j) {
      const int mass = jacobian.mass[static_cast<std::size_t>(i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i)];
      if (mass >= 0) residual = graph.difference(residual, graph.product(mass, accelerations[static_cast<std::size_t>(j)]));
    }
    for (const int slope : graph.gradient(residual, state, graph.dependence(residual, state)))
      jacobian.slopes.push_back(graph.is_constant(slope, 0.0) ? -1 : slope);
  }
}

/// A node that is c (cos² u + sin² u) + d is c + d.
template <class Graph>
constexpr int without_squares(Graph& graph, int x) {
  const typename Graph::Node w = graph[x];
  if (w.kind != formula::Kind::affine || w.b < 0 || !formula::are_alike(w.ca, w.cb)) return x;
  const typename Graph::Node a = graph[w.a], b = graph[w.b];
  if (a.kind != formula::Kind::product || b.kind != formula::Kind::product || a.a != a.b || b.a != b.b) return x;
  const typename Graph::Node f = graph[a.a], g = graph[b.a];
  using formula::Function;
  if (f.a != g.a || f.kind != formula::Kind::function || g.kind != formula::Kind::function) return x;
  if ((f.function == Function::sin && g.function == Function::cos) || (f.function == Function::cos && g.function == Function::sin))
    return graph.constant(w.ca + w.c);
  return x;
}

// The domains that must be checked beside q̈, of each node. A root or a power that q̈ needs is NaN outside of its own domain, and a division by zero
// is not finite. None where no function has one.
template <class Graph>
constexpr std::vector<formula::Domain> domains_to_check(const Graph& graph, const std::vector<int>& outputs) {
  using formula::Domain, formula::Kind;
  if (std::ranges::all_of(graph.nodes(), [](const auto& node) { return node.domain == Domain::everything; })) return {};
  const std::vector<char> needed = graph.needed_for(outputs);
  std::vector<char> may_be_negative(needed.size(), 1), may_be_zero(needed.size(), 1);
  for (std::size_t w = 0; w < needed.size(); ++w) {
    const auto& node = graph.nodes()[w];
    if (needed[w] == 0 || (node.kind != Kind::power && node.kind != Kind::quotient)) continue;
    const auto base = static_cast<std::size_t>(node.kind == Kind::power ? node.a : node.b);
    const double exponent = node.kind == Kind::power ? formula::decisive(node.c) : -1.0;
    if (exponent < 0.0) may_be_zero[base] = 0;
    if (!(exponent >= -1e9 && exponent <= 1e9 && exponent == static_cast<double>(static_cast<int>(exponent)))) may_be_negative[base] = 0;
  }
  std::vector<Domain> domains;
  for (std::size_t w = 0; w < needed.size(); ++w) {
    Domain domain = graph.nodes()[w].domain;
    if (domain == Domain::positive && may_be_negative[w] == 0) domain = Domain::nonzero;
    if (domain == Domain::nonnegative && may_be_negative[w] == 0) domain = Domain::everything;
    if (domain == Domain::nonzero && may_be_zero[w] == 0) domain = Domain::everything;
    domains.push_back(domain);
  }
  return domains;
}
constexpr std::vector<int> with_checked(std::vector<int> outputs, const std::vector<formula::Domain>& domains) {
  for (std::size_t w = 0; w < domains.size(); ++w)
    if (domains[w] != formula::Domain::everything) outputs.push_back(static_cast<int>(w));
  return outputs;
}

}  // namespace qdot::detail
