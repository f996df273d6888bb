#pragma once
// SPDX-License-Identifier: MIT
//
// Lagrange's equations derived when a program runs, and carried out line by line.
//
// The compiler derives M and r of energies that it can run (mechanics/written_out.hpp). The same algebra works for an object that is there when
// the program runs: T and V are listed (ad/formula/trace.hpp), multiplied out, differentiated and simplified (mechanics/derive/by_terms.hpp), now with the
// object's own numbers in place of letters. What comes out is a table of lines,
//
//     x₇ = x₃ x₅,     x₈ = sin x₀, x₉ = cos x₀,     x₁₀ = 2 x₇ − x₈,   …
//
// first those of M and r, then those of ∂(r − M a)/∂(q, q̇), and an evaluation goes through it from operation to operation. A line costs one or
// two nanoseconds beside what it computes, and there are as few of them as in formulas that one derives by hand. A T that is too long to be multiplied
// out, the double sum over pairs of twelve links, is differentiated as it is written (mechanics/derive/derivatives_of_graph.hpp); of such a T there are
// lines of M and r only.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "qdot/ad/formula/list_graph.hpp"
#include "qdot/ad/formula/trace.hpp"
#include "qdot/mechanics/derive/by_terms.hpp"
#include "qdot/mechanics/derive/closed_form.hpp"
#include "qdot/mechanics/derive/derivatives_of_graph.hpp"
#include "qdot/mechanics/equations/energy_functors.hpp"

namespace qdot::detail {

/// One line: x[to] = …
struct Line {
  enum class Operation : std::uint8_t {
    end, constant, scaled, combination, sum, difference, product, square, quotient, inverse, root, inverse_root, power, sine_and_cosine, function
  };
  Operation operation = Operation::end;
  formula::Function function = formula::Function::none;
  std::uint16_t to = 0, also_to = 0, a = 0, b = 0;
  double ca = 0.0, cb = 0.0, c = 0.0;
};

// The lines from `line` to one whose operation is `end`. Each jumps to the next by itself: a processor remembers where each of several jumps goes, of one
// jump in a loop it remembers less, and the lines take half as long again.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpedantic"  // labels as values, which g++ and clang have
inline void carry_out(const Line* line, double* x) {
  static const void* const ways[] = {&&end,     &&constant, &&scaled, &&combination,  &&sum,   &&difference,      &&product, &&square,
                                     &&quotient, &&inverse,  &&root,   &&inverse_root, &&power, &&sine_and_cosine, &&function};
  const auto way = [](const Line* l) { return static_cast<std::size_t>(l->operation); };
  goto* ways[way(line)];
constant:
  x[line->to] = line->c;
  goto* ways[way(++line)];
scaled:
  x[line->to] = line->ca * x[line->a] + line->c;
  goto* ways[way(++line)];
combination:
  x[line->to] = line->ca * x[line->a] + line->cb * x[line->b] + line->c;
  goto* ways[way(++line)];
sum:
  x[line->to] = x[line->a] + x[line->b];
  goto* ways[way(++line)];
difference:
  x[line->to] = x[line->a] - x[line->b];
  goto* ways[way(++line)];
product:
  x[line->to] = x[line->a] * x[line->b];
  goto* ways[way(++line)];
square:
  x[line->to] = x[line->a] * x[line->a];
  goto* ways[way(++line)];
quotient:
  x[line->to] = x[line->a] / x[line->b];
  goto* ways[way(++line)];
inverse:
  x[line->to] = 1.0 / x[line->a];
  goto* ways[way(++line)];
root:
  x[line->to] = std::sqrt(x[line->a]);
  goto* ways[way(++line)];
inverse_root:
  x[line->to] = 1.0 / std::sqrt(x[line->a]);
  goto* ways[way(++line)];
power:
  x[line->to] = std::pow(x[line->a], line->c);
  goto* ways[way(++line)];
sine_and_cosine: {
  const double angle = x[line->a];
  x[line->to] = std::sin(angle);
  x[line->also_to] = std::cos(angle);
}
  goto* ways[way(++line)];
function:
  x[line->to] = formula::value_of(line->function, x[line->a], x[line->b]);
  goto* ways[way(++line)];
end:;
}
#pragma GCC diagnostic pop

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

  std::vector<Line> equations, all;  // lines of M and r; and with those of the slopes after them
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

/// Writes the lines of a derivation.
class LineWriter {
 public:
  LineWriter(const DerivedEquations::Graph& graph, int inputs) : graph_(graph), number_(graph.nodes().size(), -1), count_(inputs) {
    for (std::size_t w = 0; w < number_.size(); ++w)
      if (graph.nodes()[w].kind == formula::Kind::variable) number_[w] = graph.nodes()[w].a;
  }

  /// Appends what `outputs` need and is not there.
  void write(const std::vector<int>& outputs, std::vector<Line>& lines) {
    const std::vector<char> needed = graph_.needed_for(outputs);
    for (std::size_t w = 0; w < needed.size(); ++w)
      if (needed[w] != 0 && number_[w] < 0) write(w, lines);
  }

  int count() const { return count_; }
  int number(int node) const { return node < 0 ? -1 : number_[static_cast<std::size_t>(node)]; }
  std::vector<int> numbers(const std::vector<int>& nodes) const {
    std::vector<int> all;
    for (const int node : nodes) all.push_back(number(node));
    return all;
  }

 private:
  std::uint16_t argument(int node) const { return static_cast<std::uint16_t>(node < 0 ? 0 : number(node)); }

  void write(std::size_t w, std::vector<Line>& lines) {
    using Operation = Line::Operation;
    const auto& node = graph_.nodes()[w];
    number_[w] = count_++;
    Line l{Operation::constant, node.function, static_cast<std::uint16_t>(number_[w]), 0, argument(node.a), argument(node.b), decisive(node.ca), decisive(node.cb),
           decisive(node.c)};
    switch (node.kind) {
      case formula::Kind::constant:
      case formula::Kind::variable: break;
      case formula::Kind::affine:
        if (node.b < 0) l.operation = Operation::scaled;
        else if (l.ca == 1.0 && l.c == 0.0 && l.cb == 1.0) l.operation = Operation::sum;
        else if (l.ca == 1.0 && l.c == 0.0 && l.cb == -1.0) l.operation = Operation::difference;
        else l.operation = Operation::combination;
        break;
      case formula::Kind::product: l.operation = l.a == l.b ? Operation::square : Operation::product; break;
      case formula::Kind::quotient: l.operation = Operation::quotient; break;
      case formula::Kind::power:
        l.operation = l.c == -1.0 ? Operation::inverse : l.c == 0.5 ? Operation::root : l.c == -0.5 ? Operation::inverse_root : Operation::power;
        break;
      case formula::Kind::function:
        l.operation = Operation::function;
        if (merged_with_partner(l, lines)) return;
        break;
    }
    lines.push_back(l);
  }

  // A sine and a cosine of one angle are one line.
  static bool merged_with_partner(const Line& l, std::vector<Line>& lines) {
    using formula::Function;
    if (l.function != Function::sin && l.function != Function::cos) return false;
    const Function partner = l.function == Function::sin ? Function::cos : Function::sin;
    for (Line& before : lines) {
      if (before.operation != Line::Operation::function || before.function != partner || before.a != l.a) continue;
      before.operation = Line::Operation::sine_and_cosine;
      before.also_to = partner == Function::sin ? l.to : before.to;
      if (partner == Function::cos) before.to = l.to;
      return true;
    }
    return false;
  }

  const DerivedEquations::Graph& graph_;
  std::vector<int> number_;  // of each node
  int count_;
};

// The lines of a derivation: those of M and r, and of the slopes where these were derived.
inline DerivedLines lines_of(const DerivedEquations::Graph& graph, int n, const DerivedJacobian& derived) {
  DerivedLines lines;
  std::vector<int> equations = derived.mass;
  equations.insert(equations.end(), derived.right.begin(), derived.right.end());
  const std::vector<formula::Domain> domains = domains_to_check(graph, equations);
  LineWriter writer(graph, 3 * n + 1);
  writer.write(with_checked(equations, domains), lines.equations);
  lines.all = lines.equations;
  writer.write(derived.slopes, lines.all);
  if (writer.count() > DerivedLines::most) return {};
  lines.mass = writer.numbers(derived.mass);
  lines.right = writer.numbers(derived.right);
  for (std::size_t w = 0; w < domains.size(); ++w)
    if (domains[w] != formula::Domain::everything) lines.checked.push_back({writer.number(static_cast<int>(w)), domains[w]});
  lines.slopes = writer.numbers(derived.slopes);
  lines.equations.emplace_back();
  lines.all.emplace_back();
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
  const bool pays = lines.equations.size() <= 3 * static_cast<std::size_t>(T.steps + V.steps);
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
