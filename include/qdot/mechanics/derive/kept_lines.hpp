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
// A run does not check at each evaluation. Its functors must not change between stop times, which the change watch
// (integrate/watch/change_watch.hpp) verifies; at each leg's start the lines are derived anew where T or V changed.

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

  void derive(RecordedMotion motion);
  void derive_slopes();
};

template <class Number>
[[gnu::cold]] void Derivation<Number>::derive(RecordedMotion motion) {
  if (!motion.recording.assumptions.empty()) return;
  recorded = std::move(motion);
  GraphEquations e = equations_by_graph(recorded.recording.graph, static_cast<int>(recorded.q.size()), recorded.returned[0], recorded.returned[1]);
  derived = {std::move(e.mass), std::move(e.right), {}};
  writer.emplace(recorded.recording.graph, recorded.q.size(), std::size_t(4));
  writer->write_equations(derived, lines);
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

template <int n, class E>
[[gnu::noinline]] Fingerprint fingerprint(const E& e) {
  const Vector<double, n> q = Eigen::Map<const Vector<double, n>>(probe_state<n>.data()), qdot = Eigen::Map<const Vector<double, n>>(probe_state<n>.data() + n);
  constexpr double t = 0.7;
  const double T = kinetic<n>(e, q, qdot, t), V = potential<n>(e, q, t);
  if (!std::isfinite(T + V)) return std::nullopt;
  return std::array{std::bit_cast<std::uint64_t>(T), std::bit_cast<std::uint64_t>(V)};
}

/// A derivation, the fingerprint of its functors, and slopes on request. May be asked by several threads.
class KeptDerivation {
 public:
  explicit KeptDerivation(const Fingerprint& print = std::nullopt) : print_(print) {}

  /// Records T and V and derives M and r.
  template <int n, class E>
  void derive(const E& e) {
    try {
      derivation_.derive(recorded_motion<n>(e));
    } catch (...) {  // what functors throw they throw again, where they are asked for values
    }
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

  /// Whether the functors are still those that were derived.
  template <int n, class E>
  [[gnu::cold, gnu::noinline]] bool still_holds(const E& e) {
    if (!lines()) return true;
    if (print_) return fingerprint_or_none<n>(e) == print_;
    const std::lock_guard lock(mutex_);
    return is_unchanged(derivation_.recorded, [&](RecordedMotion& m) { run_energies<n>(m, e); });
  }

  template <int n, class E>
  static Fingerprint fingerprint_or_none(const E& e) {
    try {
      return fingerprint<n>(e);
    } catch (...) {
      return std::nullopt;
    }
  }

 private:
  Fingerprint print_;
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
    const Fingerprint now = KeptDerivation::fingerprint_or_none<n>(e);
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
      all_[count] = std::make_unique<KeptDerivation>(print);
      all_[count]->derive<n>(e);
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
  DerivedOnce() = default;
  /// Of a run: takes what its system has derived already.
  explicit DerivedOnce(std::shared_ptr<SharedDerivations> shared) : shared_(std::move(shared)) {}

  /// The derivation of energies e, made now if this is the first call; null where T and V are no formulas, or too long.
  template <int n, class E>
  const DerivedLines* lines_of(const E& e) {
    KeptDerivation* const it = derivation<n>(e);
    return it ? it->lines() : nullptr;
  }
  /// The same with slopes, null where these are too long.
  template <int n, class E>
  const DerivedLines* lines_with_slopes_of(const E& e) {
    KeptDerivation* const it = derivation<n>(e);
    return it ? it->lines_with_slopes() : nullptr;
  }
  /// Whether energies are those that have been derived, if any have.
  template <int n, class E>
  bool still_holds(const E& e) {
    return !is_asked_.load(std::memory_order_acquire) || !derivation_ || derivation_->still_holds<n>(e);
  }

 private:
  template <int n, class E>
  KeptDerivation* derivation(const E& e) {
    if (!is_asked_.load(std::memory_order_acquire)) derive<n>(e);
    return derivation_;
  }
  template <int n, class E>
  [[gnu::cold, gnu::noinline]] void derive(const E& e) {
    const std::lock_guard lock(mutex_);
    if (is_asked_.load(std::memory_order_relaxed)) return;
    derivation_ = shared_ ? derivations_of(*shared_).of<n>(e) : nullptr;
    if (!derivation_) {
      own_ = std::make_unique<KeptDerivation>();
      own_->derive<n>(e);
      derivation_ = own_.get();
    }
    is_asked_.store(true, std::memory_order_release);
  }

  std::shared_ptr<SharedDerivations> shared_;
  std::atomic<bool> is_asked_{false};
  std::mutex mutex_{};
  std::unique_ptr<KeptDerivation> own_{};
  KeptDerivation* derivation_ = nullptr;
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

// The lines by which a system's M and r are evaluated now, if there are any.
template <int n, class E>
const DerivedLines* lines_now(KeptLines* kept, const E& e) {
  if constexpr (may_keep_lines<E, n>) {
    if (DerivedOnce* const once = kept ? kept->once() : nullptr) return once->lines_of<n>(e);
    if (KeptDerivation* const checked = checked_derivation<n>(kept, e)) return checked->lines();
  }
  return nullptr;
}

// The same with slopes.
template <int n, class E>
const DerivedLines* lines_with_slopes_now(KeptLines* kept, const E& e) {
  if constexpr (may_keep_lines<E, n> && n >= 1 && n <= straight_line_limit) {
    if (DerivedOnce* const once = kept ? kept->once() : nullptr) return once->lines_with_slopes_of<n>(e);
    if (KeptDerivation* const checked = checked_derivation<n>(kept, e)) return checked->lines_with_slopes();
  }
  return nullptr;
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
