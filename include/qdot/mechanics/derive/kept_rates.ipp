#pragma once
// SPDX-License-Identifier: MIT
//
// q̈, λ and rates of effects' states by one table of lines with the elimination in it.
//
//     lines of M and r,  M = L D Lᵀ,  q̈ = M⁻¹ r                                 pivots are results that are looked at afterwards
//     and of J and γ,    J M⁻¹ Jᵀ λ = γ − J M⁻¹ r,  q̈ = M⁻¹ r + M⁻¹ Jᵀ λ        where there are constraints
//
// Sines and cosines of all angles come in one call, in lanes, what is zero or constant is left out, and nothing is handed from one function to the next. After
// some hundred evaluations there is machine code (ad/native/line_evaluator.ipp), with the same bits. An evaluation has its numbers on the stack, so threads do
// not wait for each other.
//
// The guards of a branch are results, too: where one has another sign, other lines are looked for, or made.
//
// Programs that link qdot::compiled do not read this file: the library has it.

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "qdot/mechanics/derive/fingerprint.hpp"
#include "qdot/mechanics/derive/kept_rates.hpp"
#include "qdot/mechanics/derive/traced_motion.hpp"

namespace qdot::detail {

// An evaluation has at most so many numbers, on the stack.
inline constexpr std::size_t most_solved_numbers = 2000;

/// q̈, ż and λ of T, V and effects by lines.
template <class Number>
class BasicSolvedRates final : public AnyRates {
 public:
  /// Of what was recorded.
  [[gnu::cold]] BasicSolvedRates(TracedEquations<Number> equations, const RecordableForm& form, bool with_multipliers)
      : lines_(std::move(equations)), limits_(form.limits) {
    TracedEquations<Number>& e = lines_.equations();
    phases_ = e.motion.phases;
    write_ = writer_of<1>(e.n());
    has_rows_ = e.rows() > 0;
    if (e.zdot.empty()) e.zdot.resize(e.states(), e.graph().constant(0.0));  // phases alone have none
    solved_ = lines_.solved_rates(limits_, most_solved_numbers, with_multipliers);
    are_of_branch_ = !solved_.sides.empty();
    if (solved_.lines) zdot_ = lines_.numbers(e.zdot);
  }

  /// Whether there are lines.
  bool exist() const { return solved_.lines != nullptr; }
  bool are_native() const { return solved_.lines->is_native(); }
  const TracedEquations<Number>& equations() const { return lines_.equations(); }
  std::shared_ptr<const TracedEquations<Number>> shared_equations() const { return lines_.shared_equations(); }
  const LimitsOfPivots& limits() const { return limits_; }

  /// Notes of which functors these are.
  [[gnu::cold]] void note(const RecordableForm& form, Answers answers) {
    all_answers_ = std::move(answers);
    answers_ = all_answers_.empty() ? nullptr : &all_answers_;
    print_ = form.print(form.form, phases_.data(), answers_);
  }
  /// Whether the functors are these; of those that have no fingerprint by recording them again.
  [[gnu::cold]] bool still_hold(const RecordableForm& form) {
    return print_ != 0 ? are_of(form.print(form.form, phases_.data(), answers_)) : lines_.still_holds(form);
  }

 private:
  template <int n>
  [[gnu::cold]] static WritesRates writer_of(std::size_t count) {
    if constexpr (n < unrolled_limit)
      if (count != n) return writer_of<n + 1>(count);
    return [](const AnyRates& rates, double t, const double* y, double* ydot, FoundMultipliers* multipliers) {
      return static_cast<const BasicSolvedRates&>(rates).template written<n>(t, y, ydot, multipliers);
    };
  }
  template <int n>
  [[gnu::always_inline]] Written written(double t, const double* y, double* ydot, FoundMultipliers* multipliers) const {
    double x[most_solved_numbers];
    Register<double, 2> two[n];
    unroll<n>([&](auto k) __attribute__((always_inline)) {
      __builtin_memcpy(&two[k], y + 2 * k, sizeof two[k]);
      __builtin_memcpy(x + 2 * k, &two[k], sizeof two[k]);
    });
    x[2 * n] = t;
    for (std::size_t k = 0; k < zdot_.size(); ++k) x[2 * n + 1 + k] = y[2 * n + k];
    (*solved_.lines)(x);
    const bool is_here = solved_.is_on_branch(x), good = solved_.has_values(x, limits_);
    double rates[2 * n], sum = has_rows_ ? t - t : 0.0;  // a derivative of a row may not hold t though the row does
    const int* const number = solved_.x.data();
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      rates[i] = two[(n + i) / 2][(n + i) % 2];
      sum += rates[n + i] = x[number[i]];
    });
    write_in_pairs<2 * n>(ydot, rates);
    for (std::size_t k = 0; k < zdot_.size(); ++k) sum += ydot[2 * n + k] = x[zdot_[k]];
    if (multipliers) sum += write_multipliers(x, *multipliers);
    if (good & is_finite(sum)) return is_here ? Written::yes : Written::beyond;
    return is_here ? Written::not_good : Written::elsewhere;
  }
  double write_multipliers(const double* x, FoundMultipliers& to) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < solved_.columns.size(); ++k) sum += to.lambda[k] = solved_.columns[k] < 0 ? 0.0 : x[solved_.columns[k]];
    to.smallest_pivot = 1.0;
    for (const auto& [pivot, whole] : solved_.row_pivots) to.smallest_pivot = std::min(to.smallest_pivot, x[pivot] / x[whole]);
    return sum;
  }
  TracedLines<Number> lines_;
  typename TracedLines<Number>::Solved solved_;
  std::vector<int> zdot_;  // numbers
  LimitsOfPivots limits_;
  bool has_rows_ = false;
  Answers all_answers_;
};

// Lines of what was recorded; null where there are none.
[[gnu::cold]] inline std::shared_ptr<SolvedRates> rates_of_recording(TracedEquations<double> equations, const RecordableForm& form,
                                                                     const std::vector<char>& holonomic, Answers answers, bool with_multipliers) {
  if (holonomic.size() > equations.n() || equations.graph().nodes().size() > most_solved_numbers) return nullptr;
  equations.finds_free_turns = true;
  equations.derive(form.has_forces, holonomic);
  auto rates = std::make_shared<SolvedRates>(std::move(equations), form, with_multipliers);
  if (!rates->exist()) return nullptr;
  rates->note(form, std::move(answers));
  return rates;
}

// Those on the branch of a state.
[[gnu::cold]] inline std::shared_ptr<SolvedRates> rates_of_branch(const RecordableForm& form, double t, const double* y, std::span<const double> phases,
                                                                  bool with_multipliers) {
  formula::Branches branches;
  branches.variables.assign(y, y + 2 * form.dof);
  branches.variables.push_back(t);
  branches.variables.insert(branches.variables.end(), y + 2 * form.dof, y + 2 * form.dof + form.states);
  std::vector<char> holonomic;
  TracedEquations<double> equations = recorded_form(form, phases, holonomic, &branches);
  if (branches.read_values || !branches.undecided.empty()) return nullptr;
  for (const formula::Guard& guard : branches.met)
    if (std::ranges::none_of(equations.guards, [&](const formula::Guard& g) { return g.node == guard.node && g.is_side_of(guard); }))
      equations.guards.push_back(guard);
  Answers answers = equations.motion.recording.answers;
  return rates_of_recording(std::move(equations), form, holonomic, std::move(answers), with_multipliers);
}

/// Lines of a form in some phases, on the branch of a state where functors compare numbers; null where there are none.
[[gnu::cold]] inline std::shared_ptr<SolvedRates> solved_rates(const RecordableForm& form, double t, const double* y, std::span<const double> phases,
                                                               bool with_multipliers = false) {
  try {
    std::vector<char> holonomic;
    TracedEquations<double> equations = recorded_form(form, phases, holonomic);
    Answers answers = equations.motion.recording.answers;
    return rates_of_recording(std::move(equations), form, holonomic, std::move(answers), with_multipliers);
  } catch (const NotAnalytic&) {  // numbers are compared
  } catch (...) {                 // what functors throw they throw again, where they are asked for values
    return nullptr;
  }
  try {
    return rates_of_branch(form, t, y, phases, with_multipliers);
  } catch (...) {
    return nullptr;
  }
}

template <class Number>
BasicSharedRates<Number>::~BasicSharedRates() {
  for (OfForm* it = first_.load(); it != nullptr;) delete std::exchange(it, it->next);
}

template <class Number>
auto BasicSharedRates<Number>::of(const RecordableForm& form, bool with_multipliers) -> OfForm& {
  const auto found = [&]() -> OfForm* {
    for (OfForm* it = first_.load(std::memory_order_acquire); it != nullptr; it = it->next)
      if (it->key == form.key && it->with_multipliers == with_multipliers) return it;
    return nullptr;
  };
  if (OfForm* const it = found()) return *it;
  const std::lock_guard lock(adding_);
  if (OfForm* const it = found()) return *it;
  auto* const made = new OfForm{.key = form.key, .with_multipliers = with_multipliers, .next = first_.load(std::memory_order_relaxed)};
  first_.store(made, std::memory_order_release);
  return *made;
}

// One evaluation: which lines are of the functors as they are now and of some phases, and hold at a state.
template <class Number>
class BasicSharedRates<Number>::Search {
 public:
  Search(OfForm& of, const RecordableForm& form, double t, const double* y, std::span<const double> phases, double* ydot, FoundMultipliers* multipliers)
      : of_(of), form_(form), t_(t), y_(y), phases_(phases), ydot_(ydot), multipliers_(multipliers) {}

  bool operator()(const SolvedRates& rates) {
    if (!rates.are_in(phases_) || !rates.are_of(rates.answers() ? form_.print(form_.form, phases_.data(), rates.answers()) : unasked())) return false;
    written_ = rates.write(t_, y_, ydot_, multipliers_);
    return AnyRates::is_on_branch(written_);
  }
  bool has_written() const { return written_ == SolvedRates::Written::yes; }

  /// Lines that hold, made if there are none and they are worth it.
  [[gnu::cold, gnu::noinline]] std::shared_ptr<SolvedRates> found_or_made() {
    const auto holds = [&](const SolvedRates& rates) { return (*this)(rates); };
    if (const auto* const there = of_.met.found(holds)) return *there;
    if (!all_finite(y_, 2 * form_.dof + form_.states) || !std::isfinite(t_) || !are_worth_it()) return nullptr;
    const auto make = [&] { return solved_rates(form_, t_, y_, phases_, multipliers_ != nullptr); };
    if (of_.met.count() + 1 < most) {
      const auto* const made = of_.met.added(holds, make);
      if (!made) count_failure();
      return made ? *made : nullptr;
    }
    const std::lock_guard lock(of_.replacing);
    if (of_.further && holds(*of_.further)) return of_.further;
    auto made = make();
    if (!made || !holds(*made)) return count_failure();
    return of_.further = std::move(made);
  }

 private:
  // The fingerprint of functors that compare nothing.
  Fingerprint unasked() {
    if (!is_hashed_) unasked_ = form_.print(form_.form, phases_.data(), nullptr);
    is_hashed_ = true;
    return unasked_;
  }
  static std::uint64_t joined(std::uint64_t sum, std::uint64_t bits) { return (sum ^ bits) * 0x9E3779B97F4A7C15U; }
  std::uint64_t key_of_phases() const {
    std::uint64_t sum = 1;
    for (const double phase : phases_) sum = joined(sum, std::bit_cast<std::uint64_t>(phase));
    return sum;
  }
  // In phases in which several lines could not be made no more are. Functors whose numbers are others at each call are not worth it: beyond the first
  // few, they must be met as often as deriving them takes times an evaluation without.
  bool are_worth_it() {
    constexpr std::size_t few = 16;
    constexpr int often = 32;
    const std::size_t place = key_of_phases() % of_.failures.size();
    if (of_.failures[place].load(std::memory_order_relaxed) >= most_failures) return false;
    const SolvedRates* const latest = of_.met.latest();
    if (of_.met.count() < few || latest == nullptr) return true;
    const Fingerprint now = form_.print(form_.form, phases_.data(), latest->answers());
    if (latest->are_of(now) && latest->are_in(phases_)) return true;  // another branch of the same
    const std::uint64_t key = joined(key_of_phases(), now);
    if (of_.missed.exchange(key, std::memory_order_relaxed) != key) of_.misses.store(0, std::memory_order_relaxed);
    return of_.misses.fetch_add(1, std::memory_order_relaxed) >= often;
  }
  std::shared_ptr<SolvedRates> count_failure() {
    of_.failures[key_of_phases() % of_.failures.size()].fetch_add(1, std::memory_order_relaxed);
    return nullptr;
  }

  OfForm& of_;
  const RecordableForm& form_;
  double t_;
  const double* y_;
  std::span<const double> phases_;
  double* ydot_;
  FoundMultipliers* multipliers_;
  Fingerprint unasked_ = 0;
  bool is_hashed_ = false;
  SolvedRates::Written written_ = SolvedRates::Written::elsewhere;
};

template <class Number>
bool BasicSharedRates<Number>::write(const RecordableForm& form, double t, const double* y, std::span<const double> phases, double* ydot,
                                     FoundMultipliers* multipliers) {
  OfForm& all = of(form, multipliers != nullptr);
  Search search(all, form, t, y, phases, ydot, multipliers);
  search.found_or_made();
  all.latest.store(all.met.latest(), std::memory_order_release);
  return search.has_written();
}

template <class Number>
[[gnu::cold]] std::shared_ptr<SolvedRates> BasicSharedRates<Number>::at(const RecordableForm& form, double t, const double* y,
                                                                        std::span<const double> phases, double* ydot) {
  return Search(of(form, false), form, t, y, phases, ydot, nullptr).found_or_made();
}

template <class Number>
[[gnu::cold]] std::shared_ptr<const TracedEquations<Number>> BasicSharedRates<Number>::equations(Fingerprint print) {
  for (OfForm* it = first_.load(std::memory_order_acquire); it != nullptr; it = it->next) {
    if (it->key != plain_system) continue;
    const auto is_of = [&](const SolvedRates& rates) { return rates.are_of(print) && !rates.are_of_branch() && rates.answers() == nullptr; };
    if (const auto* const found = it->met.found(is_of)) return (*found)->shared_equations();
  }
  return nullptr;
}

template <class>
[[gnu::cold, gnu::noinline]] SharedRates& made_rates(SharedDerivations& shared) {
  const std::lock_guard lock(shared.making);
  if (!shared.owner_of_rates) {
    auto made = std::make_shared<SharedRates>();
    shared.rates.store(made.get(), std::memory_order_release);
    shared.owner_of_rates = std::move(made);
  }
  return *shared.rates.load(std::memory_order_relaxed);
}

template <class Number>
[[gnu::cold, gnu::noinline]] const AnyRates* BasicRunRates<Number>::find(const KeptLines& kept, const RecordableForm& form, double t, const double* y,
                                                                         std::span<const double> phases, double* ydot, AnyRates::Written& written) const {
  using Written = AnyRates::Written;
  written = Written::elsewhere;
  const auto holds = [&](const SolvedRates& rates) {
    return rates.are_in(phases) && AnyRates::is_on_branch(written = rates.write(t, y, ydot));
  };
  const auto make = [&]() -> std::shared_ptr<SolvedRates> {
    if (auto shared = rates_of(*kept.shared()).at(form, t, y, phases, ydot)) return shared;
    return solved_rates(form, t, y, phases);  // of functors that have no fingerprint, or whose numbers are others too often
  };
  const auto* found = met_->found(holds);
  if (found == nullptr) {
    if (!kept.shared() || misses_.load(std::memory_order_relaxed) >= most_misses || !all_finite(y, 2 * form.dof + form.states)) return nullptr;
    if (!met_->is_full()) found = met_->added(holds, make);
  }
  if (!found) {
    misses_.fetch_add(1, std::memory_order_relaxed);
    return nullptr;
  }
  misses_.store(0, std::memory_order_relaxed);
  latest_.store(found->get(), std::memory_order_release);
  return found->get();
}

template <class Number>
void BasicRunRates<Number>::renew(const RecordableForm& form) {
  has_begun_ = true;
  misses_ = 0;
  if (met_->is_full() || !met_->all_of([&](SolvedRates& rates) { return rates.still_hold(form); })) forget();
}
template <class>
[[gnu::cold]] bool are_native(const AnyRates& rates) {
  return static_cast<const SolvedRates&>(rates).are_native();
}

}  // namespace qdot::detail
