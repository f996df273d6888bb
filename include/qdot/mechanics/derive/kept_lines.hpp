#pragma once
// SPDX-License-Identifier: MIT
//
// Equations that are derived once and kept.
//
// T and V are recorded and M and r derived as lines; of four coordinates that takes some 20 µs, of eight 60, of 32 some 800. Slopes, derived when they
// are first asked for, take 50 and 200 µs. Lines that are evaluated often become machine code (ad/native/line_evaluator.ipp).
//
// Outside of runs each evaluation checks that the functors are those that were derived (mechanics/derive/derivation.hpp). So
// `acceleration(system, q, qdot)` in a user's own loop costs its lines and a hash of T and V, and never uses what a functor was before. A system keeps 16
// derivations, or 64 of branches; functors that have others at each call and those that ask for a value itself are evaluated by dual numbers.
//
// A run does not check at each evaluation. Its functors must not change between stop times, which the change watch
// (integrate/watch/change_watch.hpp) verifies; at each leg's start the lines are derived anew where T or V changed.

#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <string>

#include "qdot/mechanics/derive/derivation.hpp"
#include "qdot/mechanics/derive/met_branches.hpp"
#include "qdot/mechanics/equations/kept_lines.hpp"

namespace qdot::detail {

/// Derivations of the branches of some functors, made where they are met. May be asked by several threads.
template <class Number = double>
class BasicBranchDerivations {
 public:
  static constexpr std::size_t most = 64;

  explicit BasicBranchDerivations(By by);
  ~BasicBranchDerivations();

  /// The first derivation that holds at a state, the latest before others, or one that is made; null where functors cannot be derived.
  ///
  /// @param checked    whether it must be of the functors as they are now, too
  /// @param of_system  derivations that a run shares with its system: one of these is taken before a new one is made
  KeptDerivation* at(const RecordableFunctors& functors, const AtState& at, bool checked, BasicBranchDerivations* of_system = nullptr);
  /// The derivation that held at the last state, if there is one.
  KeptDerivation* latest() const { return met_.latest(); }
  /// Whether all are of the functors as they are now.
  bool still_hold(const RecordableFunctors& functors) const;

 private:
  using Held = std::shared_ptr<KeptDerivation>;

  template <class Holds>
  const Held* held_at(const RecordableFunctors& functors, const AtState& at, const Holds& holds, bool may_add, BasicBranchDerivations* of_system);
  Held shared_at(const RecordableFunctors& functors, const AtState& at);

  By by_;
  MetBranches<KeptDerivation, most> met_;
};

/// The derivations of a system, found by the fingerprints of its functors. May be asked by several threads.
///
/// 16 are kept, and one more for functors that have had more values of their captured numbers by then. That one is replaced when an unknown fingerprint
/// is met twice in a row.
template <class Number = double>
class BasicDerivations {
 public:
  static constexpr std::size_t most = 16;
  using Held = std::shared_ptr<KeptDerivation>;  // empty for those that live as long as this

  explicit BasicDerivations(SharedDerivations& shared);
  ~BasicDerivations();

  /// The derivation of energies as they are now, which holds at every state; null where there is none.
  template <int n, class E>
  KeptDerivation* everywhere(const E& e, int size, Held& held) {
    if (has_branches_.load(std::memory_order_relaxed)) return nullptr;
    if (count_.load(std::memory_order_acquire) > 0)
      if (KeptDerivation* const found = made_with(fingerprint<n>(e, size))) return found;
    return added(RecordableFunctors::of<n>(e, size), held);
  }
  /// The derivation of energies as they are now, which holds at a state; null where there is none.
  template <int n, class E>
  KeptDerivation* at(const E& e, const AtState& at, Held& held) {
    if (KeptDerivation* const it = everywhere<n>(e, size_at<n>(at), held)) return it;
    if (!has_branches_.load(std::memory_order_relaxed)) return nullptr;
    return branches_.at(RecordableFunctors::of<n>(e, size_at<n>(at)), at, true);
  }
  /// Derivations of branches.
  BasicBranchDerivations<Number>& branches() { return branches_; }

 private:
  KeptDerivation* made_with(Fingerprint print) const {
    const std::size_t count = count_.load(std::memory_order_acquire);
    for (std::size_t i = 0; i < count && print != 0; ++i)
      if (all_[i]->print() == print) return all_[i].get();
    return nullptr;
  }
  KeptDerivation* added(const RecordableFunctors& functors, Held& held);

  SharedDerivations& shared_;  // whose part this is
  std::array<Held, most> all_;
  Held further_;
  Fingerprint missed_ = 0;
  std::atomic<std::size_t> count_{0};
  std::atomic<bool> has_branches_{false};
  std::mutex adding_;
  BasicBranchDerivations<Number> branches_;
};

/// The derivations that a system and its copies share.
template <class = void>
Derivations& made_derivations(SharedDerivations& shared);
inline Derivations& derivations_of(SharedDerivations& shared) {
  Derivations* const made = shared.made.load(std::memory_order_acquire);
  return made ? *made : made_derivations(shared);
}

/// The derivations of a run: its system's, or of the branches that it meets. May be asked by several threads.
template <class Number = double>
class BasicDerivedOnce {
 public:
  explicit BasicDerivedOnce(std::shared_ptr<SharedDerivations> shared);
  ~BasicDerivedOnce();

  /// The derivation of energies e that holds at a state, made now if there is none yet; null where T and V are no formulas, or too long.
  template <int n, class E>
  KeptDerivation* at(const E& e, const AtState& at) {
    if (!is_asked_.load(std::memory_order_acquire)) look_at_system<n>(e, size_at<n>(at));
    if (everywhere_) return everywhere_;
    return branches_.at(RecordableFunctors::of<n>(e, size_at<n>(at)), at, false, &derivations_of(*shared_).branches());
  }
  /// The derivation that held at the last state, if there is one; may be of another branch.
  KeptDerivation* latest() const {
    if (!is_asked_.load(std::memory_order_acquire)) return nullptr;
    return everywhere_ ? everywhere_ : branches_.latest();
  }

  /// Whether any evaluation has asked for lines.
  bool is_asked() const { return is_asked_.load(std::memory_order_acquire); }

  /// Whether functors are those that have been derived, if any have.
  bool still_holds(const RecordableFunctors& functors);

 private:
  template <int n, class E>
  [[gnu::cold, gnu::noinline]] void look_at_system(const E& e, int size) {
    const std::lock_guard lock(asking_);
    if (is_asked_.load(std::memory_order_relaxed)) return;
    everywhere_ = derivations_of(*shared_).template everywhere<n>(e, size, held_);
    is_asked_.store(true, std::memory_order_release);
  }

  std::shared_ptr<SharedDerivations> shared_;
  std::atomic<bool> is_asked_{false};
  std::mutex asking_;
  KeptDerivation* everywhere_ = nullptr;
  Derivations::Held held_;
  BasicBranchDerivations<Number> branches_;
};

/// Derivations for a run of a system.
template <class = void>
std::shared_ptr<DerivedOnce> derived_once(const std::shared_ptr<SharedDerivations>& shared);

// Which energies may have kept lines: those that can be recorded. Runs of many coordinates, or of a number that is known at
// run time, have other ways (mechanics/derive/traced_motion.hpp).
template <class E, int n>
inline constexpr bool may_keep_lines = n <= block_limit<n> && RecordableEnergies<E, n>;

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
// `of_mass`: by lines of M alone.
template <int n, bool of_mass = false, class E, class Found>
bool with_lines(KeptLines* kept, const E& e, const AtState& at, const Found& found) {
  if constexpr (may_keep_lines<E, n>)
    if (size_at<n>(at) <= block_limit<n>)
      return with_lines<n>(kept, e, at, [](KeptDerivation& it) { return of_mass ? it.lines_of_mass() : it.lines(); }, found);
  return false;
}
template <int n, class E, class Found>
bool with_lines_and_slopes(KeptLines* kept, const E& e, const AtState& at, const Found& found) {
  if constexpr (RecordableEnergies<E, n> && n >= 1 && n <= unrolled_limit)
    return with_lines<n>(kept, e, at, [](KeptDerivation& it) { return it.lines_with_slopes(); }, found);
  else return (void)kept, (void)e, (void)at, (void)found, false;
}

/// In words, how lines are carried out.
template <class = void>
std::string way_of_lines(bool are_native, By asked, bool are_long);

/// In words, how the last evaluation of a system, which is a run's own, went.
template <class Sys>
[[gnu::cold]] std::string way_taken(const Sys& system) {
  using E = typename Sys::EnergiesType;
  constexpr int n = Sys::dof_at_compile_time;
  const KeptLines& kept = *system.kept_lines();
  if (kept.by() == By::duals) return "dual numbers, as asked";
  const DerivedOnce* const once = may_keep_lines<E, n> ? kept.once() : nullptr;
  if (once && once->is_asked()) {
    KeptDerivation* const latest = once->latest();
    if (const DerivedLines* const lines = latest ? latest->lines() : nullptr)
      return way_of_lines(lines->are_native(), kept.by(), lines->equations.count() > formula::longest_native_lines);
    return "dual numbers, because T or V asks for a plain value, compares in too many ways, or is too long to be recorded";
  }
  return RecordableEnergies<E, n> ? "dual numbers, because formulas of this number of coordinates are not recorded"
                                  : "dual numbers, because T and V do not take the scalar that records";
}

/// Makes a system or scene, which is a run's own, keep the lines of its equations.
template <class Sys, class Owner>
void keep_lines(Owner& owner, const Sys& system) {
  if constexpr (may_keep_lines<typename Sys::EnergiesType, Sys::dof_at_compile_time>)
    if (const auto& shared = system.kept_lines()->shared()) owner.keep(KeptLines(*system.kept_lines(), derived_once(shared)));
}

/// Where T and V have become others since, they are derived anew.
template <class Sys, class Owner>
void renew_lines(Owner& owner, const Sys& system) {
  constexpr int n = Sys::dof_at_compile_time;
  if constexpr (may_keep_lines<typename Sys::EnergiesType, n>) {
    DerivedOnce* const once = system.kept_lines()->once();
    if (once && !once->still_holds(RecordableFunctors::of<n>(system.energies(), static_cast<int>(system.dof())))) keep_lines(owner, system);
  }
}

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template class BasicBranchDerivations<double>;
extern template class BasicDerivations<double>;
extern template class BasicDerivedOnce<double>;
extern template Derivations& made_derivations<void>(SharedDerivations&);
extern template std::shared_ptr<DerivedOnce> derived_once<void>(const std::shared_ptr<SharedDerivations>&);
extern template std::string way_of_lines<void>(bool, By, bool);
}  // namespace qdot::detail
#else
#include "qdot/mechanics/derive/kept_lines.ipp"
#endif
