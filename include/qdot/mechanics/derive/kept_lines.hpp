#pragma once
// SPDX-License-Identifier: MIT
//
// Equations that are derived once and kept.
//
// T and V are recorded and M and r derived as lines; of four coordinates that takes some 20 µs, of eight 60, of 32 some 800. Slopes, derived when they
// are first asked for, take 50 and 200 µs. Lines that are evaluated often become machine code (ad/native/native_lines.hpp).
//
// A derivation holds as long as T and V compute the same. That is checked by T and V as plain numbers at a probe state, fixed for each n: the same
// functors give the same bits there, and another captured number gives others. So `acceleration(system, q, qdot)` in a user's own loop costs its lines
// and one evaluation of T and V, and never uses what a functor was before. A system keeps up to 16 derivations; functors that return another number for
// the same state, or that cannot be evaluated at the probe, have none outside of runs.
//
// Functors that compare numbers are derived for one branch at a time: a recording that knows the state notes the guards on which its branch depends
// (ad/formula/branches.hpp), and a state beyond a guard has another. A run keeps up to 64 of them.
//
// A run does not check at each evaluation. Its functors must not change between stop times, which the change watch
// (integrate/watch/change_watch.hpp) verifies; at each leg's start the lines are derived anew where T or V changed.

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "qdot/mechanics/derive/lines.hpp"
#include "qdot/mechanics/equations/kept_lines.hpp"

namespace qdot::detail {

// What was recorded, what has been derived of it, and its lines.
template <class Number = double>
struct Derivation {
  RecordedMotion recorded;
  DerivedJacobian derived;
  std::optional<DerivedLineWriter<Number>> writer;
  DerivedLines lines;

  void derive(RecordedMotion motion, const formula::Branches* branches = nullptr);
  void derive_slopes();
};

template <class Number>
[[gnu::cold]] void Derivation<Number>::derive(RecordedMotion motion, const formula::Branches* branches) {
  if (!motion.recording.assumptions.empty()) return;
  recorded = std::move(motion);
  GraphEquations e = equations_by_graph(recorded.recording.graph, static_cast<int>(recorded.q.size()), recorded.returned[0], recorded.returned[1]);
  derived = {std::move(e.mass), std::move(e.right), {}};
  writer.emplace(recorded.recording.graph, recorded.q.size(), std::size_t(4));
  writer->write_equations(derived, branches ? branches->met : std::vector<formula::Guard>(), lines);
  if (!lines_pay(lines, recorded)) lines = {};
}

template <class Number>
[[gnu::cold]] void Derivation<Number>::derive_slopes() {
  differentiate(recorded.recording.graph, static_cast<int>(recorded.q.size()), derived);
  writer->write_slopes(derived, lines);
}

#ifdef QDOT_COMPILED
extern template struct Derivation<double>;
#endif

/// T and V at the probe state, bit by bit; nothing where they have no finite value there.
using Fingerprint = std::optional<std::array<std::uint64_t, 2>>;

// Coordinates in (0.2, 1.2) and velocities in (-0.5, 0.5), without order: multiples of the golden section.
template <int n>
inline constexpr std::array<double, 2 * n> probe_state = [] {
  std::array<double, 2 * n> x{};
  double sum = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    sum += 0.6180339887498949;
    if (sum >= 1.0) sum -= 1.0;
    x[i] = i < n ? sum + 0.2 : sum - 0.5;
  }
  return x;
}();

// A plain number, for functors that compile for numbers with derivatives only.
struct OfProbe;
using Value = Dual<double, 0, OfProbe>;

template <int n, class E>
[[gnu::noinline]] Fingerprint fingerprint(const E& e) {
  Vector<Value, n> q, qdot;
  for (std::size_t i = 0; i < n; ++i) {
    q.data()[i].value = probe_state<n>[i];
    qdot.data()[i].value = probe_state<n>[n + i];
  }
  const Value t(0.7), T = kinetic<n>(e, q, qdot, t), V = potential<n>(e, q, t);
  if (!std::isfinite(T.value + V.value)) return std::nullopt;
  return std::array{std::bit_cast<std::uint64_t>(T.value), std::bit_cast<std::uint64_t>(V.value)};
}

template <int n, class E>
Fingerprint fingerprint_or_none(const E& e) {
  try {
    return fingerprint<n>(e);
  } catch (...) {
    return std::nullopt;
  }
}

/// A derivation, where it holds, and slopes on request. May be asked by several threads.
class KeptDerivation {
 public:
  /// Of functors without comparisons, which are known again by their fingerprint.
  template <int n, class E>
  void derive(const E& e, const Fingerprint& print) {
    print_ = print;
    try {
      derivation_.derive(recorded_motion<n>(e));
    } catch (...) {  // what functors throw they throw again, where they are asked for values
    }
  }
  /// Of the branch at a state.
  template <int n, class E>
  [[gnu::cold, gnu::noinline]] void derive_branch(const E& e, const AtState& at) {
    branches_ = std::make_unique<formula::Branches>();
    branches_->variables.assign(at.q, at.q + n);
    branches_->variables.insert(branches_->variables.end(), at.qdot, at.qdot + n);
    branches_->variables.push_back(at.t);
    try {
      RecordedMotion recorded = recorded_motion<n>(e, branches_.get());
      if (!branches_->read_values) derivation_.derive(std::move(recorded), branches_.get());
    } catch (...) {  // likewise
    }
    if (lines()) write_guards(n);
  }

  const Fingerprint& print() const { return print_; }
  /// The lines; null where T and V are no formulas, or too long.
  const DerivedLines* lines() const { return derivation_.lines.exist() ? &derivation_.lines : nullptr; }
  /// The lines with slopes; null where these are too long.
  const DerivedLines* lines_with_slopes() {
    if (!lines()) return nullptr;
    if (!is_asked_for_slopes_.load(std::memory_order_acquire)) {
      const std::lock_guard lock(mutex_);
      if (!is_asked_for_slopes_.load(std::memory_order_relaxed)) derivation_.derive_slopes();
      is_asked_for_slopes_.store(true, std::memory_order_release);
    }
    return derivation_.lines.have_slopes() ? &derivation_.lines : nullptr;
  }

  /// Whether a state is on the branch that was recorded.
  template <int n>
  bool holds_at(const AtState& at) const {
    if (guards_.empty()) return true;
    double x[DerivedLines::most(n)];
    std::copy_n(at.q, n, x);
    std::copy_n(at.qdot, n, x + n);
    x[2 * n] = at.t;
    guard_lines_(x);
    for (std::size_t i = 0; i < guards_.size(); ++i)
      if (!branches_->met[i].has(x[guards_[i]])) return false;
    return true;
  }

  /// Whether the functors are still those that were derived.
  template <int n, class E>
  [[gnu::cold, gnu::noinline]] bool still_holds(const E& e) {
    if (!lines()) return true;
    if (print_) return fingerprint_or_none<n>(e) == print_;
    const std::lock_guard lock(mutex_);
    const auto run = [&](RecordedMotion& m) { run_energies<n>(m, e); };
    if (!branches_) return is_unchanged(derivation_.recorded, run);
    const std::vector<formula::Guard> met = branches_->met;
    branches_->answers = &met;
    branches_->met.clear();
    const bool same = is_unchanged(derivation_.recorded, run) && std::equal(met.begin(), met.end(), branches_->met.begin(), branches_->met.end(),
                                                                            [](const formula::Guard& a, const formula::Guard& b) { return a.is_same(b); });
    branches_->answers = nullptr;
    branches_->met = met;
    return same;
  }

 private:
  void write_guards(std::size_t n) {
    const std::vector<formula::Guard>& met = branches_->met;
    if (met.empty()) return;
    std::vector<int> nodes;
    for (const formula::Guard& guard : met) nodes.push_back(guard.node);
    formula::LineTable table;
    formula::LineWriter<double> writer(derivation_.recorded.recording.graph, 2 * n + 1);
    writer.write(nodes, table);
    table.lines.push_back(formula::Line{});
    guard_lines_.set(std::move(table), writer.count());
    guards_ = writer.numbers(nodes);
    guard_lines_.add_read(guards_);
    if (writer.count() > DerivedLines::most(n)) derivation_.lines = {};
  }

  Fingerprint print_{};
  std::unique_ptr<formula::Branches> branches_{};
  formula::LineEvaluator guard_lines_{};
  std::vector<int> guards_{};
  std::mutex mutex_{};
  std::atomic<bool> is_asked_for_slopes_{false};
  Derivation<> derivation_{};
};

/// The derivations of a system, found by the fingerprints of its functors. May be asked by several threads.
class Derivations {
 public:
  static constexpr std::size_t most = 16;

  /// The derivation of energies as they are now; null where they have none that can be checked.
  template <int n, class E>
  KeptDerivation* of(const E& e) {
    if (has_none_.load(std::memory_order_relaxed)) return nullptr;
    const Fingerprint now = fingerprint_or_none<n>(e);
    if (KeptDerivation* const found = made_with(now)) return found;
    return added<n>(e, now);
  }

 private:
  KeptDerivation* made_with(const Fingerprint& print) const {
    const std::size_t count = count_.load(std::memory_order_acquire);
    for (std::size_t i = 0; i < count; ++i)
      if (all_[i]->print() == print) return all_[i].get();
    return nullptr;
  }

  template <int n, class E>
  [[gnu::cold, gnu::noinline]] KeptDerivation* added(const E& e, const Fingerprint& print) {
    const std::lock_guard lock(adding_);
    if (KeptDerivation* const found = made_with(print)) return found;
    const std::size_t count = count_.load(std::memory_order_relaxed);
    if (print && count < most) {
      all_[count] = std::make_unique<KeptDerivation>();
      all_[count]->derive<n>(e, print);
    }
    if (!print || count == most || !all_[count]->lines()) {
      has_none_.store(true, std::memory_order_relaxed);
      return nullptr;
    }
    count_.store(count + 1, std::memory_order_release);
    return all_[count].get();
  }

  std::array<std::unique_ptr<KeptDerivation>, most> all_{};
  std::atomic<std::size_t> count_{0};
  std::atomic<bool> has_none_{false};
  std::mutex adding_{};
};

/// The derivations that a system and its copies share.
[[gnu::cold, gnu::noinline]] inline Derivations& made_derivations(SharedDerivations& shared) {
  const std::lock_guard lock(shared.making);
  if (!shared.owner) {
    auto made = std::make_shared<Derivations>();
    shared.made.store(made.get(), std::memory_order_release);
    shared.owner = std::move(made);
  }
  return *static_cast<Derivations*>(shared.owner.get());
}
inline Derivations& derivations_of(SharedDerivations& shared) {
  Derivations* const made = shared.made.load(std::memory_order_acquire);
  return made ? *made : made_derivations(shared);
}

/// The lines of a run's equations, once there are any. May be asked by several threads.
class DerivedOnce {
 public:
  static constexpr std::size_t most_branches = 64;

  DerivedOnce() = default;
  /// Of a run: takes what its system has derived already.
  explicit DerivedOnce(std::shared_ptr<SharedDerivations> shared) : shared_(std::move(shared)) {}

  /// The derivation of energies e that holds at a state, made now if there is none yet; null where T and V are no formulas, or too long.
  template <int n, class E>
  KeptDerivation* derivation(const E& e, const AtState& at) {
    if (!is_asked_.load(std::memory_order_acquire)) look_at_system<n>(e);
    if (whole_) return whole_;
    const std::size_t count = count_.load(std::memory_order_acquire);
    const std::size_t last = last_.load(std::memory_order_relaxed);
    if (last < count && branches_[last]->holds_at<n>(at)) return branches_[last].get();
    return other_branch<n>(e, at, count);
  }
  /// The derivation that held at the last state, if there is one; may be of another branch.
  KeptDerivation* latest() const {
    if (whole_) return whole_;
    const std::size_t last = last_.load(std::memory_order_relaxed);
    return last < count_.load(std::memory_order_acquire) ? branches_[last].get() : nullptr;
  }

  /// Whether energies are those that have been derived, if any have.
  template <int n, class E>
  bool still_holds(const E& e) {
    if (!is_asked_.load(std::memory_order_acquire)) return true;
    if (whole_) return whole_->still_holds<n>(e);
    const std::size_t count = count_.load(std::memory_order_acquire);
    return std::all_of(branches_.begin(), branches_.begin() + static_cast<std::ptrdiff_t>(count),
                       [&](const std::unique_ptr<KeptDerivation>& each) { return each->still_holds<n>(e); });
  }

 private:
  template <int n, class E>
  [[gnu::cold, gnu::noinline]] void look_at_system(const E& e) {
    const std::lock_guard lock(mutex_);
    if (is_asked_.load(std::memory_order_relaxed)) return;
    whole_ = shared_ ? derivations_of(*shared_).of<n>(e) : nullptr;
    is_asked_.store(true, std::memory_order_release);
  }
  template <int n>
  KeptDerivation* made_for(const AtState& at, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
      if (branches_[i]->holds_at<n>(at)) {
        last_.store(i, std::memory_order_relaxed);
        return branches_[i].get();
      }
    return nullptr;
  }
  template <int n, class E>
  [[gnu::noinline]] KeptDerivation* other_branch(const E& e, const AtState& at, std::size_t count) {
    if (KeptDerivation* const made = made_for<n>(at, count)) return made;
    if (is_full_.load(std::memory_order_relaxed) || !all_finite(at.q, n) || !all_finite(at.qdot, n)) return nullptr;
    const std::lock_guard lock(mutex_);
    count = count_.load(std::memory_order_relaxed);
    if (KeptDerivation* const made = made_for<n>(at, count)) return made;
    if (is_full_.load(std::memory_order_relaxed)) return nullptr;
    auto made = std::make_unique<KeptDerivation>();
    made->derive_branch<n>(e, at);
    if (!made->lines() || count + 1 == most_branches) is_full_.store(true, std::memory_order_relaxed);
    if (!made->lines()) return nullptr;
    branches_[count] = std::move(made);
    last_.store(count, std::memory_order_relaxed);
    count_.store(count + 1, std::memory_order_release);
    return branches_[count].get();
  }

  std::shared_ptr<SharedDerivations> shared_;
  std::atomic<bool> is_asked_{false}, is_full_{false};
  std::mutex mutex_{};
  KeptDerivation* whole_ = nullptr;
  std::array<std::unique_ptr<KeptDerivation>, most_branches> branches_{};
  std::atomic<std::size_t> count_{0}, last_{0};
};

// Which energies may have kept lines: T and V, and positions (mechanics/kinematic_system.hpp). More coordinates than are known while compiling have
// other ways (mechanics/derive/traced_motion.hpp).
template <class E, int n>
inline constexpr bool may_keep_lines =
    n >= 1 && n <= graded_limit<n> && (!requires { requires E::has_own_equations; } || requires { requires E::may_keep_lines; }) && !is_written_out<E> &&
    RecordableEnergies<E, n>;

// The derivation by which a system's M and r are evaluated now, if there is one: a run's, or one that has just been checked.
template <int n, class E>
KeptDerivation* checked_derivation(KeptLines* kept, const E& e) {
  return kept && kept->shared() ? derivations_of(*kept->shared()).of<n>(e) : nullptr;
}

// Calls found(lines), for `f` what a derivation has, with the lines by which a system's M and r are evaluated at a state; false where there are none and
// where found() returns false. Beyond a guard lines say that they have no values there, and are looked for again.
template <int n, class E, class F, class Found>
bool with_lines(KeptLines* kept, const E& e, const AtState& at, const F& f, const Found& found) {
  const auto try_with = [&](KeptDerivation* it) {
    const DerivedLines* const lines = it ? f(*it) : nullptr;
    return lines && found(*lines);
  };
  DerivedOnce* const once = kept ? kept->once() : nullptr;
  if (!once) return try_with(checked_derivation<n>(kept, e));
  KeptDerivation* const latest = once->latest();
  if (latest && try_with(latest)) return true;
  KeptDerivation* const holds = once->derivation<n>(e, at);
  return holds != latest && try_with(holds);
}
template <int n, class E, class Found>
bool with_lines(KeptLines* kept, const E& e, const AtState& at, const Found& found) {
  if constexpr (may_keep_lines<E, n>) return with_lines<n>(kept, e, at, [](KeptDerivation& it) { return it.lines(); }, found);
  return false;
}
template <int n, class E, class Found>
bool with_lines_and_slopes(KeptLines* kept, const E& e, const AtState& at, const Found& found) {
  if constexpr (may_keep_lines<E, n> && n <= straight_line_limit) return with_lines<n>(kept, e, at, [](KeptDerivation& it) { return it.lines_with_slopes(); }, found);
  return false;
}

/// Makes a system or scene, which is a run's own, keep the lines of its equations.
template <class Sys, class Owner>
void keep_lines(Owner& owner, const Sys& system) {
  if constexpr (may_keep_lines<typename Sys::EnergiesType, Sys::dof_at_compile_time>)
    owner.keep(KeptLines(*system.kept_lines(), std::make_shared<DerivedOnce>(system.kept_lines()->shared())));
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
