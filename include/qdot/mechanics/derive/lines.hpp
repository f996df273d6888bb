#pragma once
// SPDX-License-Identifier: MIT
//
// Lagrange's equations derived when a program runs, and carried out line by line.
//
// T and V of an object are recorded (mechanics/derive/recorded_energies.hpp) and differentiated as they are written
// (mechanics/derive/derivatives_of_graph.hpp). What comes out is a table of lines (ad/formula/lines.hpp), first those of M and r, then those
// of ∂(r − M a)/∂(q, q̇).
//
// Who has such lines hands M and r on as every way to them does (mechanics/mass_and_rhs.hpp).

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "qdot/ad/formula/line_writer.hpp"
#include "qdot/ad/native/native_lines.hpp"
#include "qdot/mechanics/derive/derivatives_of_graph.hpp"
#include "qdot/mechanics/derive/recorded_energies.hpp"
#include "qdot/mechanics/derive/solution_lines.hpp"
#include "qdot/mechanics/equations/block_solve.hpp"
#include "qdot/mechanics/equations/small_solve.hpp"
#include "qdot/mechanics/equations/straight_line.hpp"

namespace qdot::detail {

/// The equations of one object. Inputs are q, q̇, t and accelerations, 3n + 1 numbers, and parameters; lines come after them. −1 is zero.
struct DerivedLines {
  static constexpr int lane_limit = 16;  // most coordinates for whose lanes there are lines to q̈
  // Numbers of an evaluation: a vector of them lies on the stack.
  static constexpr std::size_t most(std::size_t n) { return n <= 16 ? 4000 : 12000; }

  formula::LineEvaluator equations;               // M and r
  formula::LineEvaluator before_slopes, further;  // the same lines, with all that the slopes read; and the slopes
  std::vector<int> mass, right, slopes;   // lower triangle of M, row by row; derivatives of each row along q and then q̇
  struct Checked {
    int number;
    formula::Domain domain;
  };
  std::vector<Checked> checked;  // outside of which T or V has no value
  struct Sided {
    int number;
    formula::Side side;
  };
  std::vector<Sided> sides;  // beyond which T or V has another branch

  // q̈ of up to eight coordinates, and for lanes of up to 16, by machine code once it has been asked for often; without forces Q, and with them.
  struct Solution {
    formula::LineEvaluator lines;
    std::vector<int> accelerations;
    std::vector<std::pair<int, int>> pivots;
    bool will_be_native = false;
  };
  Solution solution[2];
  formula::MachineCodeBegins begins{};

  bool exist() const { return !right.empty(); }
  bool have_slopes() const { return !slopes.empty(); }
  bool are_native() const { return equations.is_native() || solution[0].lines.is_native() || solution[1].lines.is_native(); }

  /// M and r, handed to `use`; false where T or V has no value, and where `use` says so.
  template <int n, class Use>
  bool with_mass_and_rhs(const double* q, const double* qdot, double t, const Use& use) const {
    constexpr bool few = n >= 1 && n <= straight_line_limit;
    const int size = n == Dynamic ? static_cast<int>(right.size()) : n;
    double x[most(n == Dynamic ? block_limit<n> : n)];
    write_inputs(size, q, qdot, t, x);
    if constexpr (few && requires { use.by_solution(AtState{q, qdot, t}, *this, x); }) {
      // Elimination by lines has the bits of small_solve.hpp unless the compiler fuses products there; then the lines are used from the first evaluation.
      const Solution& s = solution[Use::is_forced];
      if ((formula::products_are_fused && s.will_be_native) || s.lines.is_native_by_now()) return use.by_solution(AtState{q, qdot, t}, *this, x);
      formula::carry_out(equations.table(), x);
    } else {
      equations(x);
    }
    if (!have_values(x)) return false;
    double r[block_stride<n>];
    for (int i = 0; i < size; ++i) r[i] = x[right[static_cast<std::size_t>(i)]];
    if constexpr (few) {
      double M[n * (n + 1) / 2];
      write_mass(x, M);
      return use.full(AtState{q, qdot, t}, M, r);
    } else {
      double M[block_stride<n> * block_stride<n>];
      const int* entry = mass.data();
      for (int i = 0; i < size; ++i)
        for (int j = 0; j <= i; ++j, ++entry) M[block_stride<n> * i + j] = *entry < 0 ? 0.0 : x[*entry];
      return use.template rows<blocks_of<n>>(AtState{q, qdot, t, size}, size, M, r);
    }
  }

  /// q̈ by machine code, on numbers that have the inputs; false where it is not finite, or a pivot is not above a fraction of its diagonal entry.
  template <int n>
  bool write_accelerations(double* x, const double* Q, double threshold, double* qddot) const {
    const Solution& s = solution[Q != nullptr];
    if (Q)
      for (int i = 0; i < n; ++i) x[2 * n + 1 + i] = Q[i];
    s.lines(x);
    bool good = !are_checked() || have_values(x);
    const std::pair<int, int>* const pivots = s.pivots.data();  // one of each row
    unroll<n>([&](auto k) __attribute__((always_inline)) { good &= x[pivots[k].first] > threshold * x[pivots[k].second]; });
    const int* const number = s.accelerations.data();
    double sum = -0.0;
    unroll<n / 2>([&](auto i) __attribute__((always_inline)) {
      const Register<double, 2> two{x[number[2 * i]], x[number[2 * i + 1]]};  // who copies q̈ reads two at once, and waits for two that were written apart
      __builtin_memcpy(qddot + 2 * i, &two, sizeof two);
      sum += two[0] + two[1];
    });
    if constexpr (n % 2 == 1) sum += qddot[n - 1] = x[number[n - 1]];
    return good & is_finite(sum);
  }

  /// M, and the derivatives of r − M a at accelerations a (mechanics/equations/equation_slopes.hpp), which come from (M, r): `put_accelerations` leaves them in
  /// r's place; false where it says so.
  template <int n, class Row, class F>
  bool write_slopes(const double* q, const double* qdot, double t, double* M, Row* rows, const F& put_accelerations) const {
    double x[most(n)];
    write_inputs(n, q, qdot, t, x);
    before_slopes(x);
    if (!have_values(x)) return false;
    write_mass(x, M);
    double* const a = x + 2 * n + 1;
    for (int i = 0; i < n; ++i) a[i] = x[right[static_cast<std::size_t>(i)]];
    if (!put_accelerations(static_cast<const double*>(M), a)) return false;
    further(x);
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
  bool are_checked() const { return !checked.empty() || !sides.empty(); }
  bool have_values(const double* x) const {
    bool good = true;
    for (const Checked& c : checked) good &= formula::is_in(c.domain, x[c.number]);
    for (const Sided& s : sides) good &= s.side.has(x[s.number]);
    return good;
  }
};

/// Accelerations that are known, for DerivedLines::write_slopes().
struct AccelerationsAre {
  const double* a;
  int n;
  bool operator()(const double*, double* to) const {
    std::copy_n(a, n, to);
    return true;
  }
};

/// Writes the lines of M and r, and those of the slopes once there are any.
template <class Coefficient>
class DerivedLineWriter {
 public:
  DerivedLineWriter(const formula::BasicGraph<Coefficient>& graph, std::size_t n, std::size_t shortest_run, std::size_t parameters = 0)
      : graph_(graph), n_(n), most_(DerivedLines::most(n)), writer_(graph, 3 * n + 1 + parameters, shortest_run) {}

  /// Lines of M, r, of the guards of a branch, and of numbers that are not zero where these hold; none where there would be too many.
  [[gnu::cold]] void write_equations(const DerivedJacobian& derived, const std::vector<formula::Guard>& guards, const std::vector<int>& nonzero,
                                     DerivedLines& lines) {
    std::vector<int> equations = derived.mass;
    equations.insert(equations.end(), derived.right.begin(), derived.right.end());
    for (const formula::Guard& guard : guards) equations.push_back(guard.node);
    equations.insert(equations.end(), nonzero.begin(), nonzero.end());
    const std::vector<formula::Domain> domains = domains_to_check(graph_, equations);
    formula::LineTable table;
    writer_.write(with_checked(equations, domains), table);
    table.lines.push_back(formula::Line{});
    lines.equations.set(std::move(table), writer_.count(), lines.begins);
    if (writer_.count() > most_) return;
    for (std::size_t w = 0; w < domains.size(); ++w)
      if (domains[w] != formula::Domain::everything) lines.checked.push_back({writer_.number(static_cast<int>(w)), domains[w]});
    for (const int node : nonzero) lines.checked.push_back({writer_.number(node), formula::Domain::nonzero});
    for (const formula::Guard& guard : guards) lines.sides.push_back({writer_.number(guard.node), guard});
    lines.mass = writer_.numbers(derived.mass);
    lines.right = writer_.numbers(derived.right);
    add_read(lines, lines.equations);
    if (n_ <= straight_line_limit) write_solutions(lines);
  }
  /// Those that go on to q̈.
  [[gnu::cold]] void write_solutions(DerivedLines& lines) {
    for (const bool forced : {false, true}) write_solution(lines, lines.solution[forced], forced);
  }
  /// Likewise of the slopes.
  [[gnu::cold]] void write_slopes(const DerivedJacobian& derived, DerivedLines& lines) {
    formula::LineTable table;
    writer_.write(derived.slopes, table);
    table.lines.push_back(formula::Line{});
    lines.further.set(std::move(table), writer_.count(), lines.begins);
    if (writer_.count() > most_) return;
    lines.slopes = writer_.numbers(derived.slopes);
    lines.further.add_read(lines.slopes);
    lines.before_slopes.set(lines.equations.table(), writer_.count(), lines.begins);
    add_read(lines, lines.before_slopes);
    lines.before_slopes.add_read(lines.slopes);
    lines.before_slopes.add_read(lines.further);
  }

 private:
  static void add_checked(const DerivedLines& lines, formula::LineEvaluator& evaluator) {
    for (const DerivedLines::Checked& c : lines.checked) evaluator.add_read(std::array{c.number});
    for (const DerivedLines::Sided& s : lines.sides) evaluator.add_read(std::array{s.number});
  }
  static void add_read(const DerivedLines& lines, formula::LineEvaluator& evaluator) {
    evaluator.add_read(lines.mass);
    evaluator.add_read(lines.right);
    add_checked(lines, evaluator);
  }

  [[gnu::cold]] void write_solution(const DerivedLines& lines, DerivedLines::Solution& solution, bool forced) {
    SolutionLines more(static_cast<std::uint32_t>(lines.equations.count()), lines.mass, lines.right, forced ? static_cast<int>(2 * n_ + 1) : -1);
    if (more.accelerations.empty() || more.count() > most_) return;
    formula::LineTable table = lines.equations.table();
    table.lines.pop_back();
    table.lines.insert(table.lines.end(), more.lines.begin(), more.lines.end());
    table.lines.push_back(formula::Line{});
    solution.lines.set(std::move(table), more.count(), lines.begins);
    solution.will_be_native = formula::native_lines_are_possible();
    solution.accelerations = std::move(more.accelerations);
    solution.pivots = std::move(more.pivots);
    solution.lines.add_read(solution.accelerations);
    for (const auto& [pivot, whole] : solution.pivots) solution.lines.add_read(std::array{pivot, whole});
    add_checked(lines, solution.lines);
  }

  const formula::BasicGraph<Coefficient>& graph_;
  std::size_t n_, most_;
  formula::LineWriter<Coefficient> writer_;
};

/// Variables for q, q̇ and t, with nothing recorded yet.
[[gnu::cold]] inline RecordedMotion motion_variables(int size) {
  RecordedMotion m;
  m.q = new_variables(m.recording, 0, size);
  m.qdot = new_variables(m.recording, size, size);
  m.t = formula::variable_in(m.recording, 2 * size);
  return m;
}
/// T and V of one object, recorded with these variables; where they compare numbers, on a branch.
template <int n, class E>
RecordedMotion recorded_motion(const E& e, int size = n, formula::Branches* branches = nullptr) {
  RecordedMotion m = motion_variables(size);
  m.recording.branches = branches;
  run_energies<n>(m, e);
  m.returned_before.reserve(m.returned.size());  // so that looking whether it still holds allocates nothing
  return m;
}

}  // namespace qdot::detail
