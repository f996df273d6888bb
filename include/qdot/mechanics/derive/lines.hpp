#pragma once
// SPDX-License-Identifier: MIT
//
// Lagrange's equations derived when a program runs, and carried out line by line.
//
// The compiler derives M and r of energies that it can run (mechanics/written_out.hpp). The same algebra works for an object that is there when
// the program runs: T and V are listed (ad/formula/trace.hpp), multiplied out, differentiated and simplified (mechanics/derive/by_terms.hpp), now with the
// object's own numbers in place of letters. What comes out is a table of lines (ad/formula/lines.hpp), first those of M and r, then those of
// ∂(r − M a)/∂(q, q̇), as few of them as in formulas that one derives by hand. A T that is too long to be multiplied
// out, the double sum over pairs of twelve links, is differentiated as it is written (mechanics/derive/derivatives_of_graph.hpp); of such a T there are
// lines of M and r only.

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "qdot/ad/formula/line_writer.hpp"
#include "qdot/ad/formula/list_graph.hpp"
#include "qdot/ad/formula/trace.hpp"
#include "qdot/mechanics/derive/by_terms.hpp"
#include "qdot/mechanics/derive/closed_form.hpp"
#include "qdot/mechanics/derive/derivatives_of_graph.hpp"
#include "qdot/mechanics/equations/energy_functors.hpp"

namespace qdot::detail {

// An energy as it was listed, for the question whether it is the same still.
struct ListedEnergy {
  std::vector<trace::Step> steps;
  std::vector<double> constants;
  int result = 0;

  ListedEnergy() = default;
  explicit ListedEnergy(const trace::Recording& run)
      : steps(run.step, run.step + run.steps), constants(run.constant, run.constant + run.constants), result(run.result) {}

  bool is(const trace::Recording& run) const {
    return run.steps == static_cast<int>(steps.size()) && run.constants == static_cast<int>(constants.size()) && run.result == result &&
           std::equal(steps.begin(), steps.end(), run.step) && (constants.empty() || std::memcmp(constants.data(), run.constant, constants.size() * sizeof(double)) == 0);
  }
};

/// The equations of one object. Inputs are q, q̇, t and accelerations, 3n + 1 numbers; lines come after them. −1 is zero.
struct DerivedLines {
  static constexpr int most = 4000;  // numbers: a vector of them lies on the stack

  formula::LineTable equations, further;  // M and r; and the slopes, which come after them
  std::vector<int> mass, right, slopes;  // lower triangle of M, row by row; derivatives of each row along q and then q̇
  struct Checked {
    int number;
    formula::Domain domain;
  };
  std::vector<Checked> checked;  // outside of which T or V has no value
  ListedEnergy T, V;             // what was derived

  bool exist() const { return !right.empty(); }
  bool have_slopes() const { return !slopes.empty(); }  // differentiated graphs have none: they would be ten times as many lines

  /// Whether T and V have values where these numbers are.
  bool have_values(const double* x) const {
    bool good = true;
    for (const Checked& c : checked) {
      const double value = x[c.number];
      if (c.domain == formula::Domain::positive) good &= value > 0.0;
      else if (c.domain == formula::Domain::nonnegative) good &= value >= 0.0;
      else good &= value != 0.0;
    }
    return good;
  }
};

// A list of one object, all of whose numbers are known, as node_of_list() asks for it.
struct ListOfObject {
  struct Always {
    constexpr bool operator[](int) const { return true; }
  };
  const trace::Step* step;
  const double* value;
  Always literal{};
  int count, result;

  explicit ListOfObject(const trace::Recording& run) : step(run.step), value(run.constant), count(run.steps), result(run.result) {}
};

// A run of T or V on vectors like all others.
template <int n, class Run>
std::unique_ptr<trace::Recording> recorded(const Run& run) {
  auto all = std::make_unique_for_overwrite<trace::Recording>();
  all->inputs = 2 * n + 1;
  Vector<trace::Listed, n> q, qdot;
  for (int i = 0; i < n; ++i) {
    q[i] = trace::Listed(*all, i);
    qdot[i] = trace::Listed(*all, n + i);
  }
  const trace::Listed result = run(q, qdot, trace::Listed(*all, 2 * n));
  all->result = result.operand_in(*all);
  auto ordered = std::make_unique_for_overwrite<trace::Recording>();
  all->put_in_order(*ordered);
  return ordered;
}

// The lines of a derivation: those of M and r, and of the slopes where these were derived.
inline DerivedLines lines_of(const DerivedEquations::Graph& graph, int n, const DerivedJacobian& derived) {
  DerivedLines lines;
  std::vector<int> equations = derived.mass;
  equations.insert(equations.end(), derived.right.begin(), derived.right.end());
  const std::vector<formula::Domain> domains = domains_to_check(graph, equations);
  constexpr std::size_t no_runs = DerivedLines::most;  // few lines are alike here, and an evaluation ends sooner than a loop has begun
  formula::LineWriter writer(graph, static_cast<std::size_t>(3 * n + 1), no_runs);
  writer.write(with_checked(equations, domains), lines.equations);
  writer.write(derived.slopes, lines.further);
  if (writer.count() > DerivedLines::most) return {};
  lines.mass = writer.numbers(derived.mass);
  lines.right = writer.numbers(derived.right);
  for (std::size_t w = 0; w < domains.size(); ++w)
    if (domains[w] != formula::Domain::everything) lines.checked.push_back({static_cast<int>(writer.number(static_cast<int>(w))), domains[w]});
  lines.slopes = writer.numbers(derived.slopes);
  lines.equations.lines.emplace_back();
  lines.further.lines.emplace_back();
  return lines;
}

/// The lines of T and V that were recorded; none where these are no formulas, or too long.
inline DerivedLines lines_of_recordings(int n, const trace::Recording& T, const trace::Recording& V) {
  if (T.branches || V.branches || T.too_long || V.too_long) return {};
  const auto node = [n](auto& d, const trace::Recording& run) {
    const ListOfObject list(run);
    return formula::node_of_list(d.graph, list, 2 * n + 1, d.is_possible, [&](int k) -> formula::Coefficient { return list.value[k]; });
  };
  const auto derived = [&](const auto& derivation) -> DerivedLines {
    DerivationByTerms d(n);
    const int node_of_T = node(d, T), node_of_V = node(d, V);
    if (!d.is_possible) return {};
    const DerivedJacobian equations = derivation(d, node_of_T, node_of_V);
    if (!d.is_possible) return {};
    DerivedLines lines = lines_of(d.graph, n, equations);
    lines.T = ListedEnergy(T);
    lines.V = ListedEnergy(V);
    return lines;
  };
  if (n <= by_terms_limit) {
    DerivedLines lines = derived([](DerivationByTerms& d, int t, int v) { return d.jacobian_by_terms(t, v); });
    if (lines.exist()) return lines;
  }
  DerivedLines lines = derived([n](DerivationByTerms& d, int t, int v) {
    GraphEquations e = equations_by_graph(d.graph, n, t, v);
    return DerivedJacobian{std::move(e.mass), std::move(e.right), {}};
  });
  // A line takes a third of the time that an operation of T takes on numbers with derivatives. Of rotations the library knows more than their formulas.
  const bool pays = lines.equations.lines.size() <= 3 * static_cast<std::size_t>(T.steps + V.steps);
  return pays ? lines : DerivedLines{};
}

template <int n, class E>
auto recorded_kinetic(const E& e) {
  using V = Vector<trace::Listed, n>;
  return recorded<n>([&](const V& q, const V& qdot, const trace::Listed& t) { return kinetic<n>(e, q, qdot, t); });
}
template <int n, class E>
auto recorded_potential(const E& e) {
  using V = Vector<trace::Listed, n>;
  return recorded<n>([&](const V& q, const V&, const trace::Listed& t) { return potential<n>(e, q, t); });
}

template <int n, class E>
DerivedLines derived_lines(const E& e) {
  return lines_of_recordings(n, *recorded_kinetic<n>(e), *recorded_potential<n>(e));
}

}  // namespace qdot::detail
