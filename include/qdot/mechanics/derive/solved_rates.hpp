#pragma once
// SPDX-License-Identifier: MIT
//
// q̈ of a run, and rates of effects' states, by one table of lines with the elimination in it.
//
//     lines of M and r,  M = L D Lᵀ,  q̈ = M⁻¹ r                                 pivots are results that are looked at afterwards
//     and of J and γ,    J M⁻¹ Jᵀ λ = γ − J M⁻¹ r,  q̈ = M⁻¹ r + M⁻¹ Jᵀ λ        where there are constraints
//
// A run evaluates the same equations ten thousand times. After some thousand evaluations it derives these lines (mechanics/derive/traced_equations.hpp)
// and has machine code of them at once (ad/native/native_lines.hpp): sines and cosines of all angles come in one call, in lanes, what is zero or constant
// is left out, and nothing is handed from one function to the next. An evaluation has its numbers on the stack, so threads do not wait for each other.
//
// It is not the way for T and V of few operations without constraints: there what the compiler makes of them is as short, and is called directly. Functors
// that branch, and such as are no formulas, go their other ways as well (mechanics/mass_and_rhs.hpp). Lines are those of one combination of phases.
//
// Programs that link qdot::compiled do not read this header: the library has it.

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "qdot/mechanics/derive/dense_factors.hpp"
#include "qdot/mechanics/derive/kept_equations.hpp"
#include "qdot/mechanics/derive/traced_motion.hpp"
#include "qdot/mechanics/equations/straight_line.hpp"

namespace qdot::detail {

/// Whether lines are sooner than what the compiler makes of T and V, as seen from what these write down: sines of several angles, or many operations.
[[gnu::cold]] inline bool lines_pay(const formula::Graph& graph) {
  constexpr std::size_t angles = 2, operations = 30;
  std::vector<int> seen;  // whose sine or cosine is asked
  for (const auto& node : graph.nodes()) {
    if (node.kind != formula::Kind::function || (node.function != formula::Function::sin && node.function != formula::Function::cos)) continue;
    if (std::ranges::find(seen, node.a) == seen.end()) seen.push_back(node.a);
  }
  return seen.size() >= angles || graph.nodes().size() >= operations;
}

/// Whether what the compiler makes of constraints is sooner: of one coordinate, and of one row on a material point in a plane
/// (effects/equations/one_constraint.hpp).
[[gnu::cold]] inline bool rows_are_simple(const TracedEquations<double>& e) {
  if (e.n() == 1) return true;
  if (e.n() != 2 || e.rows() != 1 || !e.mass_is_diagonal) return false;
  const auto first = e.mass.row(0), second = e.mass.row(1);
  return !first.empty() && !second.empty() && first[0].what == second[0].what;
}

/// q̈ and ż of T, V and effects of n coordinates by lines.
template <int n>
class SolvedRates final : public AnyRates {
 public:
  /// @param most   lines that are sooner than other ways
  [[gnu::cold]] SolvedRates(TracedEquations<double> equations, const LimitsOfPivots& limits, std::size_t most)
      : lines_(std::move(equations)), limits_(limits) {
    TracedEquations<double>& e = lines_.equations();
    e.begins = {1, e.begins.in_lanes};
    if (e.zdot.empty()) e.zdot.resize(e.states(), e.graph().constant(0.0));  // phases alone have none
    solved_ = lines_.solved_rates(limits, most_numbers);
    if (!solved_.lines || solved_.lines->table().lines.size() > most) return;
    zdot_ = lines_.numbers(e.zdot);
    is_known_ = true;
  }

  /// Whether there are lines.
  bool is_known() const { return is_known_; }

  bool write(double t, const double* y, std::span<const double> phases, double* ydot) const override {
    if (!std::ranges::equal(phases, lines_.equations().motion.phases)) return false;
    double x[most_numbers];
    Register<double, 2> two[n];  // steppers write y in pairs, and read ydot so: a load of a pair waits for two that were written apart
    unroll<n>([&](auto k) __attribute__((always_inline)) {
      __builtin_memcpy(&two[k], y + 2 * k, sizeof two[k]);
      __builtin_memcpy(x + 2 * k, &two[k], sizeof two[k]);
    });
    x[2 * n] = t;
    for (std::size_t k = 0; k < zdot_.size(); ++k) x[2 * n + 1 + k] = y[2 * n + k];
    const bool good = solved_.evaluate(x, limits_);
    double rates[2 * n], sum = 0.0;
    const int* const number = solved_.x.data();
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      rates[i] = two[(n + i) / 2][(n + i) % 2];
      sum += rates[n + i] = x[number[i]];
    });
    write_in_pairs<2 * n>(ydot, rates);
    for (std::size_t k = 0; k < zdot_.size(); ++k) sum += ydot[2 * n + k] = x[zdot_[k]];
    return good & is_finite(sum);
  }

 private:
  static constexpr std::size_t most_numbers = 2000;

  TracedLines<> lines_;
  TracedLines<>::Solved solved_;
  std::vector<int> zdot_;  // numbers
  LimitsOfPivots limits_;
  bool is_known_ = false;
};

template <int n>
[[gnu::cold]] std::unique_ptr<AnyRates> solved_rates(const RecordableForm& form, std::span<const double> phases, std::size_t most_lines) {
  if (!formula::native_lines_are_possible()) return nullptr;
  try {
    TracedEquations<double> equations(n, form.states);
    equations.motion.phases.assign(phases.begin(), phases.end());
    std::vector<char> holonomic;
    form.run(form.form, equations.motion, &holonomic);
    const bool pays = lines_pay(equations.graph());
    if (!(pays || !holonomic.empty()) || holonomic.size() > n || equations.graph().nodes().size() > most_lines) return nullptr;
    equations.derive(form.has_forces, holonomic);
    if (!pays && rows_are_simple(equations)) return nullptr;
    auto rates = std::make_unique<SolvedRates<n>>(std::move(equations), form.limits, most_lines);
    if (rates->is_known()) return rates;
  } catch (...) {  // what functors throw they throw again, where they are asked for values
  }
  return nullptr;
}

}  // namespace qdot::detail
