#pragma once
// SPDX-License-Identifier: MIT
//
// Equations that are derived once and kept.
//
// T and V are recorded and M and r derived as lines; of four coordinates that takes some 20 µs, of eight 60, of 32 some 800. Slopes, derived when they
// are first asked for, take 50 and 200 µs. Lines that are evaluated often become machine code (ad/native/native_lines.hpp).
//
// Outside of runs each evaluation checks that the functors are those that were derived (mechanics/derive/derivation.hpp). So
// `acceleration(system, q, qdot)` in a user's own loop costs its lines and a hash of T and V, and never uses what a functor was before. A system keeps 16
// derivations, or 64 of branches; functors that have others at each call and those that ask for a value itself are evaluated by dual numbers.
//
// A run does not check at each evaluation. Its functors must not change between stop times, which the change watch
// (integrate/watch/change_watch.hpp) verifies; at each leg's start the lines are derived anew where T or V changed.

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "qdot/mechanics/derive/derivation.hpp"
#include "qdot/mechanics/equations/kept_lines.hpp"

namespace qdot::detail {

/// Derivations of the branches of some functors, made where they are met. May be asked by several threads.
class BranchDerivations {
 public:
  static constexpr std::size_t most = 64;

  explicit BranchDerivations(By by) : by_(by) {}

  /// The first derivation that `holds`, the latest before others, or one that is made; null where functors cannot be derived.
  template <int n, class E, class Holds>
  KeptDerivation* at(const E& e, const AtState& at, const Holds& holds) {
    if (KeptDerivation* const it = latest(); it && holds(*it)) return it;
    if (KeptDerivation* const made = found(holds)) return made;
    if (is_full_.load(std::memory_order_relaxed) || !all_finite(at.q, size_at<n>(at)) || !all_finite(at.qdot, size_at<n>(at))) return nullptr;
    return added<n>(e, at, holds);
  }
  /// The derivation that held at the last state, if there is one.
  KeptDerivation* latest() const {
    const std::size_t last = latest_.load(std::memory_order_relaxed);
    return last < count_.load(std::memory_order_acquire) ? all_[last].get() : nullptr;
  }
  template <int n, class E>
  bool still_hold(const E& e) const {
    const auto end = all_.begin() + static_cast<std::ptrdiff_t>(count_.load(std::memory_order_acquire));
    return std::all_of(all_.begin(), end, [&](const std::unique_ptr<KeptDerivation>& each) { return each->is_of<n>(e); });
  }

 private:
  static constexpr int most_failed = 8;  // derivations that do not hold where they were made; then no more are made

  template <class Holds>
  [[gnu::noinline]] KeptDerivation* found(const Holds& holds) {
    const std::size_t count = count_.load(std::memory_order_acquire);
    for (std::size_t i = 0; i < count; ++i)
      if (holds(*all_[i])) {
        latest_.store(i, std::memory_order_relaxed);
        return all_[i].get();
      }
    return nullptr;
  }
  template <int n, class E, class Holds>
  [[gnu::cold, gnu::noinline]] KeptDerivation* added(const E& e, const AtState& at, const Holds& holds) {
    const std::lock_guard lock(adding_);
    if (KeptDerivation* const made = found(holds)) return made;
    if (is_full_.load(std::memory_order_relaxed)) return nullptr;
    auto made = std::make_unique<KeptDerivation>(by_);
    made->derive_branch<n>(e, at);
    const std::size_t count = count_.load(std::memory_order_relaxed);
    const bool good = made->lines() && holds(*made);
    if (!good) ++failed_;
    if (!made->lines() || failed_ == most_failed || count + 1 == most) is_full_.store(true, std::memory_order_relaxed);
    if (!good) return nullptr;
    all_[count] = std::move(made);
    latest_.store(count, std::memory_order_relaxed);
    count_.store(count + 1, std::memory_order_release);
    return all_[count].get();
  }

  By by_;
  std::array<std::unique_ptr<KeptDerivation>, most> all_{};
  std::atomic<std::size_t> count_{0}, latest_{0};
  std::atomic<bool> is_full_{false};
  std::mutex adding_{};
  int failed_ = 0;
};

/// The derivations of a system, found by the fingerprints of its functors. May be asked by several threads.
///
/// 16 are kept, and one more for functors that have had more values of their captured numbers by then: it is replaced when a fingerprint that has none is
/// met twice in a row.
class Derivations {
 public:
  static constexpr std::size_t most = 16;
  using Held = std::shared_ptr<KeptDerivation>;  // empty for those that live as long as this

  explicit Derivations(By by) : by_(by), branches_(by) {}

  /// The derivation of energies as they are now, which holds at every state; null where there is none.
  template <int n, class E>
  KeptDerivation* everywhere(const E& e, int size, Held& held) {
    if (has_branches_.load(std::memory_order_relaxed)) return nullptr;
    if (count_.load(std::memory_order_acquire) > 0)
      if (KeptDerivation* const found = made_with(fingerprint<n>(e, size))) return found;
    return added<n>(e, size, held);
  }
  /// The derivation of energies as they are now, which holds at a state; null where there is none.
  template <int n, class E>
  KeptDerivation* at(const E& e, const AtState& at, Held& held) {
    if (KeptDerivation* const it = everywhere<n>(e, size_at<n>(at), held)) return it;
    if (!has_branches_.load(std::memory_order_relaxed)) return nullptr;
    return branches_.at<n>(e, at, [&](KeptDerivation& it) { return it.holds_at<n>(at) && it.is_of<n>(e); });
  }

 private:
  KeptDerivation* made_with(const Fingerprint& print) const {
    const std::size_t count = count_.load(std::memory_order_acquire);
    for (std::size_t i = 0; i < count && print; ++i)
      if (all_[i]->print() == print) return all_[i].get();
    return nullptr;
  }

  template <int n, class E>
  [[gnu::noinline]] KeptDerivation* added(const E& e, int size, Held& held) {
    const std::lock_guard lock(adding_);
    const Fingerprint now = fingerprint<n>(e, size);
    if (KeptDerivation* const found = made_with(now)) return found;
    const std::size_t count = count_.load(std::memory_order_relaxed);
    if (count == most) {
      held = further_;
      if (further_ && further_->print() == now) return further_.get();
      const bool again = std::exchange(missed_, now) == now;
      if (!again) return nullptr;
    }
    auto made = std::make_shared<KeptDerivation>(by_);
    made->derive<n>(e, size);
    if (!made->lines() || !made->print()) {
      has_branches_.store(true, std::memory_order_relaxed);
      return nullptr;
    }
    if (count == most) {
      held = further_ = std::move(made);
      return held.get();
    }
    all_[count] = std::move(made);
    count_.store(count + 1, std::memory_order_release);
    return all_[count].get();
  }

  By by_;
  std::array<Held, most> all_{};
  Held further_{};
  Fingerprint missed_{};
  std::atomic<std::size_t> count_{0};
  std::atomic<bool> has_branches_{false};
  std::mutex adding_{};
  BranchDerivations branches_;
};

/// The derivations that a system and its copies share.
[[gnu::cold, gnu::noinline]] inline Derivations& made_derivations(SharedDerivations& shared) {
  const std::lock_guard lock(shared.making);
  if (!shared.owner) {
    auto made = std::make_shared<Derivations>(shared.by);
    shared.made.store(made.get(), std::memory_order_release);
    shared.owner = std::move(made);
  }
  return *static_cast<Derivations*>(shared.owner.get());
}
inline Derivations& derivations_of(SharedDerivations& shared) {
  Derivations* const made = shared.made.load(std::memory_order_acquire);
  return made ? *made : made_derivations(shared);
}

/// The derivations of a run: its system's, or of the branches that it meets. May be asked by several threads.
class DerivedOnce {
 public:
  explicit DerivedOnce(std::shared_ptr<SharedDerivations> shared) : shared_(std::move(shared)), branches_(shared_->by) {}

  /// The derivation of energies e that holds at a state, made now if there is none yet; null where T and V are no formulas, or too long.
  template <int n, class E>
  KeptDerivation* at(const E& e, const AtState& at) {
    if (!is_asked_.load(std::memory_order_acquire)) look_at_system<n>(e, size_at<n>(at));
    if (everywhere_) return everywhere_;
    return branches_.at<n>(e, at, [&](KeptDerivation& it) { return it.holds_at<n>(at); });
  }
  /// The derivation that held at the last state, if there is one; may be of another branch.
  KeptDerivation* latest() const {
    if (!is_asked_.load(std::memory_order_acquire)) return nullptr;
    return everywhere_ ? everywhere_ : branches_.latest();
  }

  /// Whether any evaluation has asked for lines.
  bool is_asked() const { return is_asked_.load(std::memory_order_acquire); }

  /// Whether energies are those that have been derived, if any have.
  template <int n, class E>
  bool still_holds(const E& e) {
    if (!is_asked_.load(std::memory_order_acquire)) return true;
    return everywhere_ ? everywhere_->is_of<n>(e) : branches_.still_hold<n>(e);
  }

 private:
  template <int n, class E>
  [[gnu::cold, gnu::noinline]] void look_at_system(const E& e, int size) {
    const std::lock_guard lock(asking_);
    if (is_asked_.load(std::memory_order_relaxed)) return;
    everywhere_ = derivations_of(*shared_).everywhere<n>(e, size, held_);
    is_asked_.store(true, std::memory_order_release);
  }

  std::shared_ptr<SharedDerivations> shared_;
  std::atomic<bool> is_asked_{false};
  std::mutex asking_{};
  KeptDerivation* everywhere_ = nullptr;
  Derivations::Held held_{};
  BranchDerivations branches_;
};

// Which energies may have kept lines: T and V, and positions (mechanics/kinematic_system.hpp). Runs of many coordinates, or of a number that is known at
// run time, have other ways (mechanics/derive/traced_motion.hpp).
template <class E, int n>
inline constexpr bool may_keep_lines =
    n <= block_limit<n> && (!requires { requires E::has_own_equations; } || requires { requires E::may_keep_lines; }) && RecordableEnergies<E, n>;

// Calls found(lines), for `f` what a derivation has, with the lines by which a system's M and r are evaluated at a state; false where there are none and
// where found() returns false. Beyond a guard lines say that they have no values there, and are looked for again.
template <int n, class E, class F, class Found>
bool with_lines(KeptLines* kept, const E& e, const AtState& at, const F& f, const Found& found) {
  const auto try_with = [&](KeptDerivation* it) {
    const DerivedLines* const lines = it ? f(*it) : nullptr;
    return lines && found(*lines);
  };
  DerivedOnce* const once = kept ? kept->once() : nullptr;
  if (!once) {
    Derivations::Held held;
    return kept && kept->shared() && try_with(derivations_of(*kept->shared()).at<n>(e, at, held));
  }
  KeptDerivation* const latest = once->latest();
  if (latest && try_with(latest)) return true;
  KeptDerivation* const holds = once->at<n>(e, at);
  return holds != latest && try_with(holds);
}
template <int n, class E, class Found>
bool with_lines(KeptLines* kept, const E& e, const AtState& at, const Found& found) {
  if constexpr (may_keep_lines<E, n>)
    if (size_at<n>(at) <= block_limit<n>) return with_lines<n>(kept, e, at, [](KeptDerivation& it) { return it.lines(); }, found);
  return false;
}
template <int n, class E, class Found>
bool with_lines_and_slopes(KeptLines* kept, const E& e, const AtState& at, const Found& found) {
  if constexpr (may_keep_lines<E, n> && n >= 1 && n <= straight_line_limit)
    return with_lines<n>(kept, e, at, [](KeptDerivation& it) { return it.lines_with_slopes(); }, found);
  return false;
}

/// In words, how lines are carried out.
template <class = void>
[[gnu::cold]] std::string way_of_lines(bool are_native, By asked, bool are_long) {
  if (are_native) return asked == By::machine_code ? "machine code of recorded formulas, as asked" : "machine code of recorded formulas";
  if (asked == By::lines) return "recorded formulas, interpreted, as asked";
  if (!formula::native_lines_are_possible())
    return "recorded formulas, interpreted, because there is no machine code: another processor or system, no executable memory, or QDOT_NATIVE=0";
  return are_long ? "recorded formulas, interpreted, because they are too many for machine code"
         : asked == By::machine_code ? "recorded formulas, interpreted, because there is machine code from the second evaluation on only"
                                     : "recorded formulas, interpreted, because there is machine code after 500 evaluations only";
}
#ifdef QDOT_COMPILED
extern template std::string way_of_lines<void>(bool, By, bool);
#endif

/// In words, how the last evaluation of a system, which is a run's own, went.
template <class Sys>
[[gnu::cold]] std::string way_taken(const Sys& system) {
  using E = typename Sys::EnergiesType;
  constexpr int n = Sys::dof_at_compile_time;
  const KeptLines& kept = *system.kept_lines();
  if (kept.by() == By::duals) return "dual numbers, as asked";
  const DerivedOnce* const once = may_keep_lines<E, n> ? kept.once() : nullptr;
  if (once && once->is_asked()) {
    const KeptDerivation* const latest = once->latest();
    if (const DerivedLines* const lines = latest ? latest->lines() : nullptr)
      return way_of_lines(lines->are_native(), kept.by(), lines->equations.count() > formula::longest_native_lines);
    return "dual numbers, because T or V asks for a plain value, compares in too many ways, or is too long to be recorded";
  }
  if constexpr (requires { requires E::has_own_equations; })
    if (kept.may_be_straight()) return "equations of positions and masses";
  if (kept.may_be_straight() && n >= 1 && n <= straight_line_limit && straight_line_pays) return "straight-line code";
  return RecordableEnergies<E, n> ? "dual numbers, because formulas of this number of coordinates are not recorded"
                                  : "dual numbers, because T and V do not take the scalar that records";
}

/// Makes a system or scene, which is a run's own, keep the lines of its equations.
template <class Sys, class Owner>
void keep_lines(Owner& owner, const Sys& system) {
  if constexpr (may_keep_lines<typename Sys::EnergiesType, Sys::dof_at_compile_time>)
    if (const auto& shared = system.kept_lines()->shared()) owner.keep(KeptLines(*system.kept_lines(), std::make_shared<DerivedOnce>(shared)));
}

/// Where T and V have become others since, they are derived anew.
template <class Sys, class Owner>
void renew_lines(Owner& owner, const Sys& system) {
  constexpr int n = Sys::dof_at_compile_time;
  if constexpr (may_keep_lines<typename Sys::EnergiesType, n>) {
    DerivedOnce* const once = system.kept_lines()->once();
    if (once && !once->template still_holds<n>(system.energies())) keep_lines(owner, system);
  }
}

}  // namespace qdot::detail
