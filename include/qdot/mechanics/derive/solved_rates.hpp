#pragma once
// SPDX-License-Identifier: MIT
//
// q̈ of a run by one table of lines, with the elimination in it.
//
//     lines of M and r,   M = L D Lᵀ,   q̈ = M⁻¹ r        pivots are results that are looked at afterwards
//
// A run evaluates the same equations ten thousand times. After some thousand evaluations it derives these lines (mechanics/derive/traced_equations.hpp)
// and has machine code of them at once (ad/native/native_lines.hpp): sines and cosines of all angles come in one call, in lanes, what is zero or constant
// is left out, and nothing is handed from one function to the next. An evaluation has its numbers on the stack, so threads do not wait for each other.
//
// It is not the way for a formula of few operations: there what the compiler makes of T and V is as short, and is called directly. Functors
// that branch, and such as are no formulas, go their other ways as well (mechanics/mass_and_rhs.hpp).
//
// Programs that link qdot::compiled do not read this header: the library has it.

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "qdot/mechanics/derive/dense_factors.hpp"
#include "qdot/mechanics/derive/kept_equations.hpp"
#include "qdot/mechanics/derive/traced_motion.hpp"
#include "qdot/mechanics/equations/straight_line.hpp"

namespace qdot::detail {

/// Whether lines are sooner than what the compiler makes of T and V, as seen from what these write down: sines of several angles, or many operations, where
/// there is machine code.
[[gnu::cold]] inline bool lines_pay(const formula::Graph& graph) {
  if (!formula::native_lines_are_possible()) return false;
  constexpr std::size_t angles = 2, operations = 30;
  std::vector<int> seen;  // whose sine or cosine is asked
  for (const auto& node : graph.nodes()) {
    if (node.kind != formula::Kind::function || (node.function != formula::Function::sin && node.function != formula::Function::cos)) continue;
    if (std::ranges::find(seen, node.a) == seen.end()) seen.push_back(node.a);
  }
  return seen.size() >= angles || graph.nodes().size() >= operations;
}

/// q̈ of T, V and forces of n coordinates by lines.
template <int n>
class SolvedRates final : public AnyRates {
 public:
  /// @param least  the fraction of its diagonal entry above which a pivot must be
  /// @param most   lines that are sooner than other ways
  [[gnu::cold]] SolvedRates(TracedEquations<double> equations, double least, std::size_t most) : lines_(std::move(equations)), least_(least) {
    TracedEquations<double>& e = lines_.equations();
    e.begins = {1, e.begins.in_lanes};
    const std::vector<int> mass = lower_triangle(e.mass);
    solved_ = n <= most_in_graph ? lines_.solved(mass, e.right, {}, lines_.required(), least, most_numbers)
                                 : lines_.solved_in_order(mass, e.right, lines_.required(), most_numbers);
    if (!solved_.lines || solved_.lines->table().lines.size() > most) return;
    for (const Requirement& r : e.requirements) required_.emplace_back(lines_.numbers({r.node})[0], r);
    is_known_ = true;
  }

  /// Whether there are lines.
  bool is_known() const { return is_known_; }

  bool write(double t, const double* y, double* qddot) const override {
    double x[most_numbers];
    unroll<2 * n>([&](auto i) __attribute__((always_inline)) { x[i] = y[i]; });
    x[2 * n] = t;
    (*solved_.lines)(x);
    bool good = true;
    for (const auto& [number, requirement] : required_) good &= requirement.holds(x[number]);
    for (const auto& [pivot, whole] : solved_.pivots) good &= x[pivot] > least_ * x[whole];
    double found[n], sum = 0.0;
    const int* const number = solved_.x.data();
    unroll<n>([&](auto i) __attribute__((always_inline)) { sum += found[i] = x[number[i]]; });
    write_in_pairs<n>(qddot, found);
    return good & is_finite(sum);
  }

 private:
  static constexpr std::size_t most_numbers = 2000;
  static constexpr int most_in_graph = 4;  // rows that are eliminated in the graph

  TracedLines<> lines_;
  TracedLines<>::Solved solved_;
  std::vector<std::pair<int, Requirement>> required_;  // of numbers
  double least_;
  bool is_known_ = false;
};

template <int n>
[[gnu::cold]] std::unique_ptr<AnyRates> solved_rates(const RecordableForm& form, std::size_t most_lines) {
  try {
    TracedEquations<double> equations(n, 0);
    form(equations.motion);
    if (!lines_pay(equations.graph()) || equations.graph().nodes().size() > most_lines) return nullptr;
    equations.derive(form.has_forces, {});
    auto rates = std::make_unique<SolvedRates<n>>(std::move(equations), form.limits.singular, most_lines);
    if (rates->is_known()) return rates;
  } catch (...) {  // what functors throw they throw again, where they are asked for values
  }
  return nullptr;
}

}  // namespace qdot::detail
