#pragma once
// SPDX-License-Identifier: MIT
//
// Lagrange's equations of a graph, derived by the compiler.
//
// They are derivatives of the graph (mechanics/derive/derivatives_of_graph.hpp), and one of many coordinates is long.
// A compiler stops after a number of operations in one constant (g++ after 3.3·10⁷, clang after 10⁶ steps). So the work is cut into
// stages, each of which is a constant of its own and begins where the one before has ended.

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "qdot/ad/formula/coefficient.hpp"
#include "qdot/ad/formula/graph.hpp"
#include "qdot/mechanics/derive/derivatives_of_graph.hpp"

namespace qdot::detail {

/// A node whose coefficients are lines of a book that is not there.
struct StoredNode {
  formula::Kind kind = formula::Kind::constant;
  formula::Function function = formula::Function::none;
  int a = -1, b = -1;
  double ca = 0.0, cb = 0.0, c = 0.0;
  int line_of_ca = -1, line_of_cb = -1, line_of_c = -1;
  formula::Domain domain = formula::Domain::everything;
};

/// How far a derivation is, and the nodes that it has found.
template <int n>
struct GraphProgress {
  int next = 0;  // what is to be done: the energies, p, −∂V/∂q, rates of nodes, c, then each entry of r, then each row of M
  int next_rate = 0;
  bool is_possible = true;
  int T = -1, V = -1;
  int p[n] = {}, force[n] = {}, term[n] = {}, right[n] = {}, mass[n * (n + 1) / 2] = {};

  static constexpr int first_right = 5, first_row = 5 + n, last = 5 + 2 * n;
};

/// What a stage leaves behind: this, and all nodes.
template <int n, int nodes_, int lines_>
struct GraphStage : GraphProgress<n> {
  static constexpr int most_nodes = nodes_, most_lines = lines_;
  int nodes = 0, lines = 0;
  StoredNode node[nodes_ + 1] = {};
  int rate[nodes_ + 1] = {};  // 1 + the node of d/dt at q̈ = 0; 0 where it is not known yet
  formula::CoefficientStep line[lines_ + 1] = {};
  double shadow[lines_ + 1] = {};
};

/// Goes on from a stage.
template <int n>
class DerivationByGraph {
 public:
  using Coefficient = formula::Coefficient;
  using Node = formula::BasicNode<Coefficient>;

  formula::CoefficientBook book;
  DerivedEquations::Graph graph;

  template <int nodes, int lines>
  constexpr explicit DerivationByGraph(const GraphStage<n, nodes, lines>& from) {
    for (int k = 0; k < from.lines; ++k) book.copy(from.line[k], from.shadow[k]);
    for (int w = 0; w < from.nodes; ++w) {
      const StoredNode& x = from.node[w];
      graph.copy_of({x.kind, x.function, x.a, x.b, opened(x.ca, x.line_of_ca), opened(x.cb, x.line_of_cb), opened(x.c, x.line_of_c), x.domain});
      if (from.next >= 3) rates_.append_known(from.rate[w]);
    }
    if (from.nodes == 0)
      for (int i = 0; i < 2 * n + 1; ++i) graph.variable(i);
  }

  /// Does what is next as long as that is not too much for one constant.
  template <class Stage, class NodeOfT, class NodeOfV>
  constexpr void advance(Stage& s, int most_effort, const NodeOfT& node_of_T, const NodeOfV& node_of_V) {
    const std::vector<int> q = variables_of(graph, 0, n), qdot = variables_of(graph, n, n);
    const int begin = graph.effort();
    const auto has_time = [&] { return graph.effort() - begin < most_effort; };
    for (; s.is_possible && s.next < Stage::last && has_time(); ++s.next) {
      if (s.next == 0) {
        bool is_known = true;
        const int T = node_of_T(graph, book, is_known), V = node_of_V(graph, book, is_known);
        s.T = T;
        s.V = V;
        s.is_possible = is_known;
      } else if (s.next == 1) {
        const std::vector<int> p = graph.gradient(s.T, qdot, graph.dependence(s.T, qdot));
        std::copy(p.begin(), p.end(), s.p);
      } else if (s.next == 2) {
        const int work = graph.scaled(s.V, -1.0);
        const std::vector<int> force = graph.gradient(work, q, graph.dependence(work, q));
        std::copy(force.begin(), force.end(), s.force);
      } else if (s.next == 3) {
        CoriolisTerms<DerivedEquations::Graph> c(rates_, n);
        c.begin(s.T);
        if (!make_rates(s, c.rated(), has_time)) break;
      } else if (s.next == 4) {
        const std::vector<int> terms = CoriolisTerms<DerivedEquations::Graph>(rates_, n).of(s.T);
        std::copy(terms.begin(), terms.end(), s.term);
      } else if (s.next < Stage::first_row) {
        const int i = s.next - Stage::first_right;
        s.right[i] = graph.difference(s.force[i], s.term[i]);
      } else {
        const int i = s.next - Stage::first_row;
        const std::vector<int> row = graph.gradient(s.p[i], std::span<const int>(qdot).first(static_cast<std::size_t>(i) + 1), graph.dependence(s.p[i], qdot));
        for (int j = 0; j <= i; ++j) s.mass[i * (i + 1) / 2 + j] = without_squares(graph, row[static_cast<std::size_t>(j)]);
      }
    }
    s.nodes = static_cast<int>(graph.nodes().size());
    s.lines = static_cast<int>(book.steps().size());
    if (s.nodes > Stage::most_nodes || s.lines > Stage::most_lines) s.is_possible = false;
    if (!s.is_possible) return;
    for (int w = 0; w < s.nodes; ++w) {
      const Node& x = graph[w];
      s.node[w] = {x.kind, x.function, x.a, x.b, x.ca.shadow, x.cb.shadow, x.c.shadow, x.ca.line, x.cb.line, x.c.line, x.domain};
      s.rate[w] = rates_.known(w);
    }
    for (int k = 0; k < s.lines; ++k) {
      s.line[k] = book.steps()[static_cast<std::size_t>(k)];
      s.shadow[k] = book.shadow_of_line(k);
    }
  }

  /// The equations of a last stage.
  template <class Stage>
  constexpr DerivedEquations equations(const Stage& s) {
    DerivedEquations e;
    const auto entry = [&s](int i, int j) { return s.mass[i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i]; };
    for (int i = 0; i < n; ++i) {
      bool is_alone = graph[entry(i, i)].kind == formula::Kind::constant && decisive(graph[entry(i, i)].c) != 0.0;
      for (int j = 0; j < n; ++j) is_alone = is_alone && (i == j || graph.is_constant(entry(i, j), 0.0));
      if (is_alone) {
        const int pivot = entry(i, i);
        const int acceleration = graph.quotient(s.right[i], pivot);
        e.eliminated.push_back({.coordinate = i, .pivot = pivot, .acceleration = acceleration, .coordinates = {}, .factors = {}});
        continue;
      }
      e.kept.push_back(i);
      e.right.push_back(s.right[i]);
      e.diagonal.push_back(-1);
    }
    for (const int i : e.kept)
      for (const int j : e.kept)
        if (j <= i) e.mass.push_back(graph.is_constant(entry(i, j), 0.0) ? -1 : entry(i, j));
    return e;
  }

  /// M, r and slopes of a last stage.
  template <class Stage>
  constexpr DerivedJacobian jacobian(const Stage& s) {
    DerivedJacobian jacobian;
    for (const int m : s.mass) jacobian.mass.push_back(graph.is_constant(m, 0.0) ? -1 : m);
    jacobian.right.assign(s.right, s.right + n);
    differentiate(graph, n, jacobian);
    return jacobian;
  }

 private:
  static constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }

  constexpr Coefficient opened(double shadow, int line) { return line < 0 ? Coefficient(shadow) : Coefficient(shadow, line, &book); }

  // d/dt of all that these nodes consist of; false when there was no time for it.
  template <class Stage, class HasTime>
  constexpr bool make_rates(Stage& s, const std::vector<int>& nodes, const HasTime& has_time) {
    if (nodes.empty()) return true;
    const int last = *std::max_element(nodes.begin(), nodes.end());
    const std::vector<char> needed = graph.needed_for(nodes);
    rates_.remember_to(last);
    for (; s.next_rate <= last; ++s.next_rate) {
      if (!has_time()) return false;
      if (needed[at(s.next_rate)] != 0) rates_.of(s.next_rate);
    }
    return true;
  }

  RatesOfNodes<DerivedEquations::Graph> rates_{graph, n};
};

// What a compiler can be asked to do in one constant, in nodes that are made or found.
#ifdef __clang__
inline constexpr int effort_of_a_stage = 500;
#else
inline constexpr int effort_of_a_stage = 5000;
#endif

// The stage after `before`, with room to spare.
template <int n, class Energies, int nodes, int lines>
constexpr auto wide_stage_after(const GraphStage<n, nodes, lines>& before) {
  GraphStage<n, nodes + 2 * effort_of_a_stage + 2000, lines + effort_of_a_stage + 1000> now;
  static_cast<GraphProgress<n>&>(now) = before;
  DerivationByGraph<n> d(before);
  d.advance(now, effort_of_a_stage, Energies::node_of_T, Energies::node_of_V);
  return now;
}

template <int n, int nodes, int lines, class Wide>
constexpr GraphStage<n, nodes, lines> trimmed_stage(const Wide& wide) {
  GraphStage<n, nodes, lines> s;
  static_cast<GraphProgress<n>&>(s) = wide;
  if (!s.is_possible) return s;
  s.nodes = nodes;
  s.lines = lines;
  std::copy(wide.node, wide.node + nodes, s.node);
  std::copy(wide.rate, wide.rate + nodes, s.rate);
  std::copy(wide.line, wide.line + lines, s.line);
  std::copy(wide.shadow, wide.shadow + lines, s.shadow);
  return s;
}

/// Stage `number` of the derivation for Energies, which has static node_of_T and node_of_V.
template <int n, class Energies, int number>
struct GraphStageOf;

template <int n, class Energies, int number>
struct WideGraphStageOf {
  static constexpr auto stage = wide_stage_after<n, Energies>(GraphStageOf<n, Energies, number - 1>::stage);
};
template <int n, class Energies>
struct WideGraphStageOf<n, Energies, 0> {
  static constexpr auto stage = wide_stage_after<n, Energies>(GraphStage<n, 0, 0>{});
};

template <int n, class Energies, int number>
struct GraphStageOf {
  using Wide = WideGraphStageOf<n, Energies, number>;
  static constexpr auto stage = trimmed_stage<n, Wide::stage.nodes, Wide::stage.lines>(Wide::stage);
};

/// The last of them.
template <int n, class Energies, int number = 0>
constexpr const auto& last_graph_stage() {
  constexpr const auto& stage = GraphStageOf<n, Energies, number>::stage;
  if constexpr (stage.is_possible && stage.next < stage.last) {
    return last_graph_stage<n, Energies, number + 1>();
  } else {
    return GraphStageOf<n, Energies, number>::stage;
  }
}

}  // namespace qdot::detail
