#pragma once
// SPDX-License-Identifier: MIT
//
// Lines of equations that were derived as on paper.
//
// The algebra by which the compiler derives M and r (mechanics/derive/by_terms.hpp) works on a recording, too, with the object's own
// numbers in place of letters: T is multiplied out, like terms are added, cos² + sin² is 1. There are as few lines as in formulas that one
// derives by hand. A T that is too long for that, the double sum over pairs of twelve links, is differentiated as it is written; of such a
// T there are lines of M and r only.

#include <cstddef>
#include <utility>
#include <vector>

#include "qdot/mechanics/derive/by_terms.hpp"
#include "qdot/mechanics/derive/lines.hpp"

namespace qdot::detail {

// Adds all nodes of one graph to another, which has none but variables; their numbers there.
inline std::vector<int> copied(const formula::Graph& from, DerivedEquations::Graph& to) {
  std::vector<int> copy;
  const auto at = [&](int x) { return x < 0 ? -1 : copy[static_cast<std::size_t>(x)]; };
  for (const formula::Node& w : from.nodes()) {
    copy.push_back(to.copy_of({w.kind, w.function, w.kind == formula::Kind::variable ? w.a : at(w.a), at(w.b), w.ca, w.cb, w.c}));
    to.set_domain(copy.back(), w.domain);
  }
  return copy;
}


/// The lines of T and V that were recorded; none where these compare values, or are too long.
[[gnu::cold]] inline DerivedLines lines_by_terms(const RecordedMotion& recorded) {
  if (!recorded.recording.assumptions.empty()) return {};
  const formula::Graph& graph = recorded.recording.graph;
  const std::size_t n = recorded.q.size();
  const int size = static_cast<int>(n);
  const auto derived = [&](std::size_t shortest_run, const auto& derivation) -> DerivedLines {
    DerivationByTerms d(size);
    const std::vector<int> copy = copied(graph, d.graph);
    const DerivedJacobian equations = derivation(d, copy[static_cast<std::size_t>(recorded.returned[0])], copy[static_cast<std::size_t>(recorded.returned[1])]);
    DerivedLines lines;
    if (!d.is_possible) return lines;
    DerivedLineWriter writer(d.graph, n, shortest_run);
    writer.write_equations(equations, lines);
    if (lines.exist() && !equations.slopes.empty()) writer.write_slopes(equations, lines);
    return lines;
  };
  if (size <= by_terms_limit) {
    constexpr std::size_t no_runs = DerivedLines::most(by_terms_limit);  // few lines are alike here, and an evaluation ends sooner than a loop has begun
    DerivedLines lines = derived(no_runs, [](DerivationByTerms& d, int T, int V) { return d.jacobian_by_terms(T, V); });
    if (lines.have_slopes()) return lines;
  }
  DerivedLines lines = derived(4, [size](DerivationByTerms& d, int T, int V) {
    GraphEquations e = equations_by_graph(d.graph, size, T, V);
    return DerivedJacobian{std::move(e.mass), std::move(e.right), {}};
  });
  return lines_pay(lines, recorded) ? lines : DerivedLines{};
}

}  // namespace qdot::detail
