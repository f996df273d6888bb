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
// that are no formulas go their other ways as well (mechanics/mass_and_rhs.hpp). Lines are those of one combination of phases, and of functors that compare
// numbers those of one branch: its guards are results, too, and where one has another sign the lines of the branch there are taken, or made.
//
// Programs that link qdot::compiled do not read this header: the library has it.

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "qdot/mechanics/derive/dense_factors.hpp"
#include "qdot/mechanics/derive/kept_equations.hpp"
#include "qdot/mechanics/derive/met_branches.hpp"
#include "qdot/mechanics/derive/traced_motion.hpp"
#include "qdot/mechanics/equations/straight_line.hpp"

namespace qdot::detail {

/// Whether lines are sooner than what the compiler makes of T and V of n coordinates, as seen from what these write down: sines of several angles, or many
/// operations.
[[gnu::cold]] inline bool lines_pay(const formula::Graph& graph, std::size_t n) {
  constexpr std::size_t angles = 2;
  const std::size_t operations = n < 3 ? 30 : 20;
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

// An evaluation has at most so many numbers, on the stack.
inline constexpr std::size_t most_solved_numbers = 2000;

enum class Written { yes, not_good, on_another_branch };

/// q̈ and ż of T, V and effects of n coordinates by lines.
template <int n>
class SolvedRates final : public AnyRates {
 public:
  [[gnu::cold]] SolvedRates(TracedEquations<double> equations, const LimitsOfPivots& limits)
      : lines_(std::move(equations)), limits_(limits) {
    TracedEquations<double>& e = lines_.equations();
    e.begins = {1, e.begins.in_lanes};
    if (e.zdot.empty()) e.zdot.resize(e.states(), e.graph().constant(0.0));  // phases alone have none
    solved_ = lines_.solved_rates(limits, most_solved_numbers);
    if (!solved_.lines) return;
    zdot_ = lines_.numbers(e.zdot);
    is_known_ = true;
  }

  /// Whether there are lines.
  bool is_known() const { return is_known_; }

  bool write(double t, const double* y, std::span<const double> phases, double* ydot) const override { return written(t, y, phases, ydot) == Written::yes; }
  [[gnu::always_inline]] Written written(double t, const double* y, std::span<const double> phases, double* ydot) const {
    if (!std::ranges::equal(phases, lines_.equations().motion.phases)) return Written::not_good;
    double x[most_solved_numbers];
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
    if (good & is_finite(sum)) return Written::yes;
    return solved_.is_on_branch(x) ? Written::not_good : Written::on_another_branch;
  }

 private:
  TracedLines<> lines_;
  TracedLines<>::Solved solved_;
  std::vector<int> zdot_;  // numbers
  LimitsOfPivots limits_;
  bool is_known_ = false;
};

/// Those of what was recorded.
///
/// @param must_pay  whether they must be sooner than what the compiler makes
template <int n>
[[gnu::cold]] std::unique_ptr<SolvedRates<n>> rates_of(TracedEquations<double> equations, const RecordableForm& form, const std::vector<char>& holonomic,
                                                       bool must_pay) {
  const bool pays = !must_pay || lines_pay(equations.graph(), equations.n());
  if (!(pays || !holonomic.empty()) || holonomic.size() > n || equations.graph().nodes().size() > most_solved_numbers) return nullptr;
  equations.finds_free_turns = true;
  equations.derive(form.has_forces, holonomic);
  if (!pays && rows_are_simple(equations)) return nullptr;
  auto rates = std::make_unique<SolvedRates<n>>(std::move(equations), form.limits);
  return rates->is_known() ? std::move(rates) : nullptr;
}

/// The same on the branch of a state.
template <int n>
[[gnu::cold]] std::unique_ptr<SolvedRates<n>> rates_of_branch(const RecordableForm& form, double t, const double* y, std::span<const double> phases,
                                                              bool must_pay) {
  formula::Branches branches;
  branches.variables.assign(y, y + 2 * n);
  branches.variables.push_back(t);
  branches.variables.insert(branches.variables.end(), y + 2 * n, y + 2 * n + form.states);
  std::vector<char> holonomic;
  TracedEquations<double> equations = recorded_form(form, phases, holonomic, &branches);
  if (branches.read_values || !branches.undecided.empty()) return nullptr;
  for (formula::Guard& guard : branches.met)
    if (std::ranges::none_of(equations.guards, [&](const formula::Guard& g) { return g.node == guard.node && g.is_side_of(guard); }))
      equations.guards.push_back(std::move(guard));
  return rates_of<n>(std::move(equations), form, holonomic, must_pay);
}

/// Rates on the branches that a run meets.
template <int n>
class RatesOfBranches final : public AnyRates {
  using Rates = SolvedRates<n>;

 public:
  RatesOfBranches(const RecordableForm& form, std::unique_ptr<Rates> first) : form_(form) {
    met_.added([](const Rates&) { return true; }, [&] { return std::shared_ptr<Rates>(std::move(first)); });
  }

  bool write(double t, const double* y, std::span<const double> phases, double* ydot) const override {
    Written written = Written::on_another_branch;
    const auto holds = [&](const Rates& rates) { return (written = rates.written(t, y, phases, ydot)) != Written::on_another_branch; };
    if (holds(*met_.latest())) {
      if (misses_.load(std::memory_order_relaxed) != 0) misses_.store(0, std::memory_order_relaxed);
    } else {
      find(t, y, phases, holds);
    }
    return written == Written::yes;
  }

 private:
  static constexpr int most_misses = 64;  // one after the other; then only the latest branch is tried until it holds again

  // Asks the other branches, and makes one more.
  template <class Holds>
  [[gnu::cold, gnu::noinline]] void find(double t, const double* y, std::span<const double> phases, const Holds& holds) const {
    if (misses_.load(std::memory_order_relaxed) >= most_misses || !all_finite(y, 2 * n + form_.states)) return;
    const auto make = [&]() -> std::shared_ptr<Rates> {
      try {
        return rates_of_branch<n>(form_, t, y, phases, false);
      } catch (...) {  // what functors throw they throw again, where they are asked for values
        return nullptr;
      }
    };
    const bool is_found = met_.found(holds) || (!met_.is_full() && met_.added(holds, make));
    if (is_found) misses_.store(0, std::memory_order_relaxed);
    else misses_.fetch_add(1, std::memory_order_relaxed);
  }

  RecordableForm form_;
  mutable MetBranches<Rates, 16> met_;
  mutable std::atomic<int> misses_{0};
};

template <int n>
[[gnu::cold]] std::unique_ptr<AnyRates> solved_rates(const RecordableForm& form, double t, const double* y, std::span<const double> phases) {
  if (!formula::native_lines_are_possible()) return nullptr;
  try {
    std::vector<char> holonomic;
    TracedEquations<double> equations = recorded_form(form, phases, holonomic);
    return rates_of<n>(std::move(equations), form, holonomic, true);
  } catch (const NotAnalytic&) {  // numbers are compared
  } catch (...) {  // what functors throw they throw again, where they are asked for values
    return nullptr;
  }
  try {
    auto first = rates_of_branch<n>(form, t, y, phases, true);
    if (first) return std::make_unique<RatesOfBranches<n>>(form, std::move(first));
  } catch (...) {
  }
  return nullptr;
}

}  // namespace qdot::detail
