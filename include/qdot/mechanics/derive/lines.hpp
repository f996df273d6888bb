#pragma once
// SPDX-License-Identifier: MIT
//
// Lagrange's equations derived when a program runs, and carried out line by line.
//
// The compiler derives M and r of energies that it can run (mechanics/written_out.hpp). The same algebra works for an object that is there when
// the program runs: T and V are recorded (mechanics/derive/recorded_energies.hpp), multiplied out, differentiated and simplified
// (mechanics/derive/by_terms.hpp), now with the object's own numbers in place of letters. What comes out is a table of lines (ad/formula/lines.hpp),
// first those of M and r, then those of ∂(r − M a)/∂(q, q̇), as few of them as in formulas that one derives by hand. A T that is too long to be multiplied
// out, the double sum over pairs of twelve links, is differentiated as it is written (mechanics/derive/derivatives_of_graph.hpp); of such a T there are
// lines of M and r only.
//
// Who has such lines hands M and r on as every way to them does (mechanics/mass_and_rhs.hpp).

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "qdot/ad/formula/line_writer.hpp"
#include "qdot/mechanics/derive/by_terms.hpp"
#include "qdot/mechanics/derive/derivatives_of_graph.hpp"
#include "qdot/mechanics/derive/recorded_energies.hpp"
#include "qdot/mechanics/equations/graded_evaluation.hpp"

namespace qdot::detail {

/// The equations of one object. Inputs are q, q̇, t and accelerations, 3n + 1 numbers; lines come after them. −1 is zero.
struct DerivedLines {
  // Numbers of an evaluation: a vector of them lies on the stack.
  static constexpr std::size_t most(std::size_t n) { return n <= 16 ? 4000 : 12000; }
  template <int n>
  static constexpr std::size_t most_of = most(n == Dynamic ? std::size_t(by_terms_limit) : std::size_t(n));

  formula::LineTable equations, further;  // M and r; and the slopes, which come after them
  std::vector<int> mass, right, slopes;   // lower triangle of M, row by row; derivatives of each row along q and then q̇
  struct Checked {
    int number;
    formula::Domain domain;
  };
  std::vector<Checked> checked;  // outside of which T or V has no value

  bool exist() const { return !right.empty(); }
  bool have_slopes() const { return !slopes.empty(); }  // differentiated graphs have none: they would be ten times as many lines

  /// M and r, handed to `use`; false where T or V has no value, and where `use` says so.
  template <int n, class Use>
  bool with_mass_and_rhs(const double* q, const double* qdot, double t, const Use& use) const {
    const int size = n == Dynamic ? static_cast<int>(right.size()) : n;
    double x[most_of<n>];
    write_inputs(size, q, qdot, t, x);
    formula::carry_out(equations, x);
    if (!have_values(x)) return false;
    double r[graded_stride<n>];
    for (int i = 0; i < size; ++i) r[i] = x[right[static_cast<std::size_t>(i)]];
    if constexpr (n != Dynamic && n <= straight_line_limit) {
      double M[n * (n + 1) / 2];
      write_mass(x, M);
      return use.full(AtState{q, qdot, t}, M, r);
    } else {
      double M[graded_stride<n> * graded_stride<n>];
      const int* entry = mass.data();
      for (int i = 0; i < size; ++i)
        for (int j = 0; j <= i; ++j, ++entry) M[graded_stride<n> * i + j] = *entry < 0 ? 0.0 : x[*entry];
      return use.template rows<graded_blocks<n>>(AtState{q, qdot, t}, size, M, r);
    }
  }

  /// M, and the derivatives of r − M a at accelerations a (mechanics/equations/equation_slopes.hpp).
  template <int n, class Row>
  bool write_slopes(const double* q, const double* qdot, const double* a, double t, double* M, Row* rows) const {
    double x[most_of<n>];
    write_inputs(n, q, qdot, t, x);
    for (int i = 0; i < n; ++i) x[2 * n + 1 + i] = a[i];
    formula::carry_out(equations, x);
    formula::carry_out(further, x);
    if (!have_values(x)) return false;
    write_mass(x, M);
    const int* slope = slopes.data();
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < 2 * n; ++j, ++slope) rows[i][j] = *slope < 0 ? 0.0 : x[*slope];
    return true;
  }

 private:
  static void write_inputs(int n, const double* q, const double* qdot, double t, double* x) {
    for (int i = 0; i < n; ++i) {
      x[i] = q[i];
      x[n + i] = qdot[i];
    }
    x[2 * n] = t;
  }
  void write_mass(const double* x, double* M) const {
    for (const int entry : mass) *M++ = entry < 0 ? 0.0 : x[entry];
  }
  bool have_values(const double* x) const {
    bool good = true;
    for (const Checked& c : checked) good &= formula::is_in(c.domain, x[c.number]);
    return good;
  }
};

// The lines of a derivation: those of M and r, and of the slopes where these were derived.
[[gnu::cold]] inline DerivedLines lines_of(const DerivedEquations::Graph& graph, std::size_t n, const DerivedJacobian& derived, std::size_t shortest_run) {
  DerivedLines lines;
  std::vector<int> equations = derived.mass;
  equations.insert(equations.end(), derived.right.begin(), derived.right.end());
  const std::vector<formula::Domain> domains = domains_to_check(graph, equations);
  formula::LineWriter writer(graph, 3 * n + 1, shortest_run);
  writer.write(with_checked(equations, domains), lines.equations);
  writer.write(derived.slopes, lines.further);
  if (writer.count() > DerivedLines::most(n)) return {};
  lines.mass = writer.numbers(derived.mass);
  lines.right = writer.numbers(derived.right);
  for (std::size_t w = 0; w < domains.size(); ++w)
    if (domains[w] != formula::Domain::everything) lines.checked.push_back({static_cast<int>(writer.number(static_cast<int>(w))), domains[w]});
  lines.slopes = writer.numbers(derived.slopes);
  lines.equations.lines.emplace_back();
  lines.further.lines.emplace_back();
  return lines;
}

/// T and V of one object, recorded with variables for q, q̇ and t.
template <int n, class E>
RecordedMotion recorded_motion(const E& e, Eigen::Index size) {
  RecordedMotion m;
  m.q = new_variables(m.recording, 0, size);
  m.qdot = new_variables(m.recording, size, size);
  m.t = m.recording.graph.variable(static_cast<int>(2 * size));
  run_energies<n>(m, e);
  return m;
}

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
[[gnu::cold]] inline DerivedLines lines_of(const RecordedMotion& recorded) {
  if (!recorded.recording.assumptions.empty()) return {};
  const formula::Graph& graph = recorded.recording.graph;
  const std::size_t n = recorded.q.size();
  const int size = static_cast<int>(n);
  const auto derived = [&](std::size_t shortest_run, const auto& derivation) -> DerivedLines {
    DerivationByTerms d(size);
    const std::vector<int> copy = copied(graph, d.graph);
    const DerivedJacobian equations = derivation(d, copy[static_cast<std::size_t>(recorded.returned[0])], copy[static_cast<std::size_t>(recorded.returned[1])]);
    return d.is_possible ? lines_of(d.graph, n, equations, shortest_run) : DerivedLines{};
  };
  if (size <= by_terms_limit) {
    constexpr std::size_t no_runs = DerivedLines::most(by_terms_limit);  // few lines are alike here, and an evaluation ends sooner than a loop has begun
    DerivedLines lines = derived(no_runs, [](DerivationByTerms& d, int T, int V) { return d.jacobian_by_terms(T, V); });
    if (lines.exist()) return lines;
  }
  DerivedLines lines = derived(4, [size](DerivationByTerms& d, int T, int V) {
    GraphEquations e = equations_by_graph(d.graph, size, T, V);
    return DerivedJacobian{std::move(e.mass), std::move(e.right), {}};
  });
  // A line takes a third of the time that an operation of T takes on numbers with derivatives. Of rotations the library knows more than their formulas.
  const std::vector<char> needed = graph.needed_for(recorded.returned);
  const bool pays = lines.equations.lines.size() <= 3 * static_cast<std::size_t>(std::count(needed.begin(), needed.end(), 1));
  return pays ? lines : DerivedLines{};
}

}  // namespace qdot::detail
