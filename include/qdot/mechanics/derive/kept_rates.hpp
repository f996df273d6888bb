#pragma once
// SPDX-License-Identifier: MIT
//
// Lines of q̈, of rates and of multipliers that are derived once and kept.
//
// T, V and the effects of a form are recorded together, and M q̈ = r + Jᵀλ, J q̈ = γ is eliminated in their lines (mechanics/derive/kept_rates.ipp).
// That takes some tens of microseconds. What has been derived is kept with the system, for all its copies and scenes.
//
// Lines are those of one combination of phases, of one branch of functors that compare numbers, and of the numbers that functors have captured.
// Outside of runs all this is checked at each evaluation, by a hash of what the functors do (mechanics/derive/fingerprint.hpp). A run, which begins with
// renew(), checks functors where a leg begins, phases and branches always.

#include <Eigen/Core>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "qdot/mechanics/derive/met_branches.hpp"
#include "qdot/mechanics/derive/recordable_form.hpp"
#include "qdot/mechanics/equations/kept_lines.hpp"
#include "qdot/mechanics/equations/small_solve.hpp"

namespace qdot::detail {

/// How many coordinates may have such lines.
template <int n>
inline constexpr bool may_have_rates = n >= 1 && n <= unrolled_limit;

/// The multipliers of the rows that are active, and how far these are from depending on each other: 1 where they are not near it.
struct FoundMultipliers {
  double* lambda;
  double smallest_pivot = 1.0;
};

/// Lines of a form in some phases, on some branch.
class AnyRates {
 public:
  /// Whether rates were written: beyond is where the functors have another branch, and these rates are still those of this one.
  enum class Written { yes, not_good, beyond, elsewhere };
  static constexpr bool is_on_branch(Written written) { return written == Written::yes || written == Written::not_good; }

  AnyRates() = default;
  AnyRates(const AnyRates&) = delete;
  AnyRates& operator=(const AnyRates&) = delete;

  /// What the functors answer where they compare numbers; null where they do not.
  const Answers* answers() const { return answers_; }
  /// Whether they hold only where comparisons of the functors have the same results.
  bool are_of_branch() const { return are_of_branch_; }
  /// Whether functors with this fingerprint are those that were derived.
  bool are_of(Fingerprint print) const { return print != 0 && print == print_; }
  Fingerprint print() const { return print_; }
  bool are_in(std::span<const double> phases) const {
    for (std::size_t k = 0; k < phases.size(); ++k)
      if (phases_[k] != phases[k]) return false;
    return true;
  }
  /// ydot ← [q̇; q̈; ż], and multipliers. Steppers write y in pairs and read ydot so: a load of a pair waits for two that were written apart.
  Written write(double t, const double* y, double* ydot, FoundMultipliers* multipliers = nullptr) const {
    return write_(*this, t, y, ydot, multipliers);
  }

  /// What other headers derive of the same functors in the same phases, such as projections (effects/rows/kept_projection.hpp).
  struct Attached {
    virtual ~Attached() = default;
  };
  /// What make() returned when it was first asked for: a std::unique_ptr<const Attached>, not null. Two threads may both make one; one of them is kept.
  template <class Make>
  const Attached& attached(const Make& make) const {
    const Attached* there = attached_.load(std::memory_order_acquire);
    return there ? *there : added(make());
  }

 protected:
  using WritesRates = Written (*)(const AnyRates&, double, const double*, double*, FoundMultipliers*);
  WritesRates write_ = nullptr;
  std::vector<double> phases_{};
  Fingerprint print_ = 0;
  const Answers* answers_ = nullptr;
  bool are_of_branch_ = false;

  ~AnyRates() { delete attached_.load(); }

 private:
  [[gnu::cold, gnu::noinline]] const Attached& added(std::unique_ptr<const Attached> made) const {
    const Attached* there = nullptr;
    return *(attached_.compare_exchange_strong(there, made.get(), std::memory_order_acq_rel) ? made.release() : there);
  }

  mutable std::atomic<const Attached*> attached_{nullptr};
};

template <class Number>
class BasicSolvedRates;  // mechanics/derive/kept_rates.ipp has it
template <class Number>
class TracedEquations;  // mechanics/derive/traced_equations.hpp
using SolvedRates = BasicSolvedRates<double>;
/// Whether lines are machine code by now.
template <class = void>
bool are_native(const AnyRates& rates);

/// The lines of a system, its copies and scenes. May be asked by several threads.
template <class Number>
class BasicSharedRates {
 public:
  static constexpr std::size_t most = 64;  // of one form
  static constexpr int most_failures = 8;

  BasicSharedRates() = default;
  ~BasicSharedRates();

  /// ydot ← [q̇; q̈; ż] at y = [q; q̇; z], and multipliers where they are asked for; false where another way must see to it.
  bool write(const RecordableForm& form, double t, const double* y, std::span<const double> phases, double* ydot, FoundMultipliers* multipliers = nullptr);
  /// The lines that held last of a form; null where there are none.
  const AnyRates* latest(RunsFunctors key, bool with_multipliers) const {
    for (const OfForm* it = first_.load(std::memory_order_acquire); it != nullptr; it = it->next)
      if (it->key == key && it->with_multipliers == with_multipliers) return it->latest.load(std::memory_order_acquire);
    return nullptr;
  }
  /// Equations without effects, of functors with this fingerprint that compare nothing, where lines have been derived of them; otherwise null.
  std::shared_ptr<const TracedEquations<Number>> equations(Fingerprint print);
  /// Lines of the functors as they are, which hold at y; null where there are none. They are found by an evaluation, ydot ← [q̇; q̈; ż].
  std::shared_ptr<SolvedRates> at(const RecordableForm& form, double t, const double* y, std::span<const double> phases, double* ydot);

 private:
  // Those of one form.
  struct OfForm {
    RunsFunctors key;
    bool with_multipliers;
    std::atomic<const AnyRates*> latest{nullptr};  // of `met`
    MetBranches<SolvedRates, most, 1 << 30> met{};  // failures are counted here
    std::array<std::atomic<int>, 64> failures{};    // by phases
    std::atomic<std::uint64_t> missed{0};           // functors that were met last without lines of theirs, and how often in a row
    std::atomic<int> misses{0};
    std::mutex replacing{};
    std::shared_ptr<SolvedRates> further{};
    OfForm* next = nullptr;
  };
  class Search;

  OfForm& of(const RecordableForm& form, bool with_multipliers);

  std::atomic<OfForm*> first_{nullptr};
  std::mutex adding_;
};

/// The lines of all that share derivations.
template <class = void>
SharedRates& made_rates(SharedDerivations& shared);
inline SharedRates& rates_of(SharedDerivations& shared) {
  SharedRates* const made = shared.rates.load(std::memory_order_acquire);
  return made ? *made : made_rates(shared);
}

/// The lines of a run, which begins with renew(): before that functors are looked at in each evaluation. Several threads may ask at once; copies begin
/// with no lines.
template <class Number = double>
class BasicRunRates {
 public:
  BasicRunRates() = default;
  BasicRunRates(const BasicRunRates& other) : has_begun_(other.has_begun_) {}
  BasicRunRates& operator=(const BasicRunRates& other) {
    has_begun_ = other.has_begun_;
    forget();
    return *this;
  }

  /// As SharedRates::write(), with no look at the functors; form() is asked where lines are looked for.
  template <class Form>
  bool write(const KeptLines& kept, const Form& form, double t, const double* y, std::span<const double> phases, double* ydot) const {
    if (!has_begun_) return kept.shared() && rates_of(*kept.shared()).write(form(), t, y, phases, ydot);
    if (held_ != nullptr && held_->are_in(phases)) {
      const AnyRates::Written written = held_->write(t, y, ydot);
      if (written != AnyRates::Written::elsewhere) return written != AnyRates::Written::not_good;
    }
    const AnyRates* const latest = latest_.load(std::memory_order_acquire);
    if (latest != nullptr && latest->are_in(phases)) {
      const AnyRates::Written written = latest->write(t, y, ydot);
      if (AnyRates::is_on_branch(written)) return written == AnyRates::Written::yes;
    }
    AnyRates::Written written;
    return find(kept, form(), t, y, phases, ydot, written) != nullptr && written == AnyRates::Written::yes;
  }
  /// Holds the branch of a state: from now on write() goes by its lines beyond its guards as well, wherever they have values. False where the functors
  /// compare nothing there, or have no lines. No other thread may ask meanwhile.
  template <class Form>
  bool hold_branch(const KeptLines& kept, const Form& form, double t, const double* y, std::span<const double> phases, double* ydot) const {
    held_ = nullptr;
    if (met_->is_full()) return false;  // branches that do not come again are not worth their lines
    const AnyRates* const here = at(kept, form, t, y, phases, ydot);
    if (here != nullptr && here->are_of_branch()) held_ = here;
    return held_ != nullptr;
  }
  void leave_branch() const { held_ = nullptr; }
  /// Looks at the functors: a leg begins. No other thread may ask meanwhile.
  void renew(const RecordableForm& form);
  /// The lines of a run that hold at a state; null where there are none. Where they hold on one branch only they are looked for, by an evaluation
  /// ydot ← [q̇; q̈; ż]. Outside of runs there are none: what other runs have derived must not decide how a form is evaluated.
  template <class Form>
  const AnyRates* at(const KeptLines& kept, const Form& form, double t, const double* y, std::span<const double> phases, double* ydot) const {
    if (!has_begun_) return nullptr;
    const AnyRates* const latest = latest_.load(std::memory_order_acquire);
    if (latest != nullptr && !latest->are_of_branch() && latest->are_in(phases)) return latest;
    AnyRates::Written written;
    return find(kept, form(), t, y, phases, ydot, written);
  }
  /// The lines of the last evaluation; null where there are none.
  const AnyRates* latest(const KeptLines& kept, RunsFunctors key) const {
    if (has_begun_) return latest_.load(std::memory_order_acquire);
    return kept.shared() ? rates_of(*kept.shared()).latest(key, false) : nullptr;
  }

 private:
  void forget() {
    latest_ = held_ = nullptr;
    met_ = std::make_unique<MetBranches<SolvedRates, 16>>();
  }

  static constexpr int most_misses = 64;  // one after the other; then no more are made until some hold again

  const AnyRates* find(const KeptLines& kept, const RecordableForm& form, double t, const double* y, std::span<const double> phases, double* ydot,
                       AnyRates::Written& written) const;

  bool has_begun_ = false;
  mutable std::unique_ptr<MetBranches<SolvedRates, 16>> met_ = std::make_unique<MetBranches<SolvedRates, 16>>();
  mutable std::atomic<const AnyRates*> latest_{nullptr};
  mutable const AnyRates* held_ = nullptr;
  mutable std::atomic<int> misses_{0};
};
using RunRates = BasicRunRates<double>;

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template class BasicSharedRates<double>;
extern template class BasicRunRates<double>;
extern template SharedRates& made_rates<void>(SharedDerivations&);
extern template bool are_native<void>(const AnyRates&);
}  // namespace qdot::detail
#else
#include "qdot/mechanics/derive/kept_rates.ipp"
#endif
