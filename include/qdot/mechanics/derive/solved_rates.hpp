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

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "qdot/mechanics/derive/dense_factors.hpp"
#include "qdot/mechanics/derive/traced_motion.hpp"
#include "qdot/mechanics/equations/straight_line.hpp"

namespace qdot::detail {

/// q̈ of T and V of n coordinates by lines. Several threads may ask it at once.
template <int n>
class SolvedRates {
 public:
  /// @param least  the fraction of its diagonal entry above which a pivot must be
  /// @param most   lines that are sooner than other ways
  SolvedRates(TracedEquations<> equations, double least, std::size_t most);

  /// Whether there are lines.
  bool is_known() const { return is_known_; }

  /// qddot ← q̈ at y = [q; q̇]; false where another way must see to it.
  bool write(double t, const double* y, double* qddot) const;

 private:
  static constexpr std::size_t most_numbers = 2000;
  static constexpr int most_in_graph = 4;  // rows that are eliminated in the graph

  TracedLines<> lines_;
  TracedLines<>::Solved solved_;
  std::vector<std::pair<int, Requirement>> required_;  // of numbers
  double least_;
  bool is_known_ = false;
};

/// Whether lines are sooner than what the compiler makes of T and V, as seen from what these write down: sines of several angles, or many operations, where
/// there is machine code.
template <class = void>
bool lines_pay(const formula::Graph& graph);

/// Which energies may have such lines.
template <class E, int n>
inline constexpr bool may_have_solved_rates = [] {
  if constexpr (n < 1 || n > straight_line_limit) return false;
  else if constexpr (requires { requires E::has_own_equations; }) return true;
  else return !turns<n, E>;
}();

/// The lines that a form keeps for its run, once it has been asked some thousand times. Several threads may ask it at once; copies begin anew.
///
/// Only where a run has said that it expects to be long: the bits of an evaluation depend on how many were before, which a simulator that is restored and a
/// loop of a user's own must not see.
///
/// A form of energies E has record_again() and limits_of_pivots().
template <class Form, class E, int n>
class KeptRates {
 public:
  KeptRates() = default;
  KeptRates(const KeptRates& other) : is_expected_(other.is_expected_) { forget(); }
  KeptRates& operator=(const KeptRates& other) {
    is_expected_ = other.is_expected_;
    forget();
    return *this;
  }

  /// Begins to count evaluations.
  void expect_long_run() {
    is_expected_ = true;
    forget();
  }

  /// As SolvedRates::write(); false where there are no lines yet, or none at all.
  bool write(const Form& form, double t, const double* y, double* qddot) const {
    const std::uintptr_t state = state_.load(std::memory_order_acquire);
    if (state > none) return std::bit_cast<const Rates*>(state)->write(t, y, qddot);
    if (state == counting) count(form);
    return false;
  }
  bool are_used() const { return state_.load(std::memory_order_relaxed) > none; }

  /// Counts anew: a leg begins, and functors may be others. No other thread may ask meanwhile.
  void renew() { forget(); }

 private:
  using Rates = SolvedRates<n>;
  // Bodies by their rotations have more lines than that, and positions know better of them.
  static constexpr std::size_t most_lines = requires { requires E::has_own_equations; } ? 30 * n : 2000;
  static constexpr int begins_after = 3000;  // evaluations: to derive and to translate lines takes some tens of microseconds
  static constexpr std::uintptr_t counting = 0, none = 1;  // beside where the lines are

  void forget() {
    rates_.reset();
    left_.store(begins_after);
    state_.store(is_expected_ ? counting : none);
  }
  void count(const Form& form) const {
    const int left = left_.load(std::memory_order_relaxed) - 1;  // of several threads some may count as one
    left_.store(left, std::memory_order_relaxed);
    if (left <= 0) make(form);
  }
  // The first thread makes the lines, and others go on without them.
  [[gnu::cold, gnu::noinline]] void make(const Form& form) const {
    std::uintptr_t state = counting;
    if (!state_.compare_exchange_strong(state, none)) return;
    try {
      TracedEquations<> equations(n, 0);
      form.record_again(equations.motion);
      if (!lines_pay(equations.graph()) || equations.graph().nodes().size() > most_lines) return;
      equations.derive(requires { requires Form::has_forces; }, {});
      rates_ = std::make_unique<Rates>(std::move(equations), form.limits_of_pivots().singular, most_lines);
      if (rates_->is_known()) return state_.store(std::bit_cast<std::uintptr_t>(rates_.get()), std::memory_order_release);
    } catch (...) {  // what functors throw they throw again, where they are asked for values
    }
    rates_.reset();
  }

  mutable std::unique_ptr<Rates> rates_;
  mutable std::atomic<int> left_{begins_after};
  mutable std::atomic<std::uintptr_t> state_{none};
  bool is_expected_ = false;
};

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template bool lines_pay<void>(const formula::Graph&);
extern template class SolvedRates<1>;
extern template class SolvedRates<2>;
extern template class SolvedRates<3>;
extern template class SolvedRates<4>;
extern template class SolvedRates<5>;
extern template class SolvedRates<6>;
extern template class SolvedRates<7>;
extern template class SolvedRates<8>;
}  // namespace qdot::detail
#else
#include "qdot/mechanics/derive/jacobian_lines.hpp"
#endif
