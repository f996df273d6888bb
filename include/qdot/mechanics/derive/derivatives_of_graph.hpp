#pragma once
// SPDX-License-Identifier: MIT
//
// Lagrange's equations by differentiating T and V as they are written.
//
// Multiplied out (mechanics/derive/by_terms.hpp), the kinetic energy of a chain of 32 links has thousands of terms. That of a body turned by a
// quaternion has powers of its length in all of them. But the user's own T has few operations, because what terms have in common is computed once:
// v_k = v_{k−1} + …. Derivatives of graphs keep that:
//
//     p = ∂T/∂q̇   (one walk back),     M_ij = ∂p_i/∂q̇_j   (one walk back for each row),     r = −∂V/∂q − c   (coriolis_terms.hpp).

#include <cstddef>
#include <span>
#include <vector>

#include "qdot/ad/formula/coefficient.hpp"
#include "qdot/mechanics/derive/coriolis_terms.hpp"
#include "qdot/mechanics/derive/derived_equations.hpp"
#include "qdot/mechanics/derive/rates_of_nodes.hpp"

namespace qdot::detail {

/// p, M and r of T and V; −1 in M is zero.
struct GraphEquations {
  std::vector<int> p, mass, right;  // of M the lower triangle, row by row
};
template <class Graph>
[[gnu::cold]] GraphEquations equations_by_graph(Graph& graph, int n, int T, int V, std::span<const formula::Recording::Turning> turnings = {}) {
  const std::vector<int> q = variables_of(graph, 0, n), qdot = variables_of(graph, n, n);
  GraphEquations e{.p = graph.gradient(T, qdot, graph.dependence(T, qdot)), .mass = {}, .right = {}};
  const int work = graph.scaled(V, -1.0);
  e.right = graph.gradient(work, q, graph.dependence(work, q));
  RatesOfNodes<Graph> rates(graph, n);
  const std::vector<int> terms = CoriolisTerms<Graph>(rates, n, turnings).of(T);
  for (std::size_t i = 0; i < q.size(); ++i) e.right[i] = graph.difference(e.right[i], terms[i]);
  for (std::size_t i = 0; i < q.size(); ++i)
    for (const int m : graph.gradient(e.p[i], std::span<const int>(qdot).first(i + 1), graph.dependence(e.p[i], qdot)))
      e.mass.push_back(graph.is_constant(m, 0.0) ? -1 : without_squares(graph, m));
  return e;
}

}  // namespace qdot::detail
