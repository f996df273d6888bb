#pragma once
// SPDX-License-Identifier: MIT
//
// Equations that are derived once and kept, for those who evaluate them many times (mechanics/equations/kept_lines.hpp says who and when).
//
// Within a run T and V must not become others, and who doubts it puts the lines aside and evaluates T and V themselves
// (integrate/watch/change_watch.hpp). Where a leg of the run begins they may have: they are recorded again, and derived again if so. To
// derive M and r of four coordinates takes some 20 µs, of eight 60, of 32 some 800; slopes, which are derived when they are first asked
// for, 50 and 200 µs. Lines that are evaluated often become machine code (ad/native/native_lines.hpp).

#include <atomic>
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

/// The lines of one object's equations, once there are any. May be asked by several threads.
class DerivedOnce {
 public:
  DerivedOnce() = default;
  DerivedOnce(const DerivedOnce&) = delete;
  DerivedOnce& operator=(const DerivedOnce&) = delete;

  /// The lines of energies e, derived now if nobody has asked before; null where T and V are no formulas, or too long.
  template <int n, class E>
  const DerivedLines* lines_of(const E& e) {
    if (!is_asked_.load(std::memory_order_acquire)) {
      const std::lock_guard lock(mutex_);
      try {
        if (!is_asked_.load(std::memory_order_relaxed)) derivation_.derive(recorded_motion<n>(e));
      } catch (...) {  // what functors throw they throw again, where they are asked for values
      }
      is_asked_.store(true, std::memory_order_release);
    }
    return derivation_.lines.exist() ? &derivation_.lines : nullptr;
  }

  /// The same with slopes, null where these are too long.
  template <int n, class E>
  const DerivedLines* lines_with_slopes_of(const E& e) {
    if (!lines_of<n>(e)) return nullptr;
    if (!is_asked_for_slopes_.load(std::memory_order_acquire)) {
      const std::lock_guard lock(mutex_);
      if (!is_asked_for_slopes_.load(std::memory_order_relaxed)) derivation_.derive_slopes();
      is_asked_for_slopes_.store(true, std::memory_order_release);
    }
    return derivation_.lines.have_slopes() ? &derivation_.lines : nullptr;
  }

  /// Whether energies are those that have been derived, if any have.
  template <int n, class E>
  [[gnu::cold, gnu::noinline]] bool still_holds(const E& e) {
    if (!is_asked_.load(std::memory_order_acquire) || !derivation_.lines.exist()) return true;
    const std::lock_guard lock(mutex_);
    return is_unchanged(derivation_.recorded, [&](RecordedMotion& m) { run_energies<n>(m, e); });
  }

 private:
  std::atomic<bool> is_asked_{false}, is_asked_for_slopes_{false};
  std::mutex mutex_;
  Derivation<> derivation_;
};

// Which energies may have kept lines: T and V, and positions (mechanics/kinematic_system.hpp). More coordinates than are known while compiling have
// other ways (mechanics/derive/traced_motion.hpp).
template <class E, int n>
inline constexpr bool may_keep_lines =
    n >= 1 && n <= graded_limit<n> && (!requires { requires E::has_own_equations; } || requires { requires E::may_keep_lines; }) && !is_written_out<E> &&
    RecordableEnergies<E, n>;

// The lines by which a system's M and r are evaluated now, if there are any.
template <int n, class E>
const DerivedLines* lines_now(KeptLines* kept, const E& e) {
  if constexpr (may_keep_lines<E, n>) {
    if (DerivedOnce* const once = kept ? kept->once() : nullptr) return once->lines_of<n>(e);
  }
  return nullptr;
}

// The same with slopes.
template <int n, class E>
const DerivedLines* lines_with_slopes_now(KeptLines* kept, const E& e) {
  if constexpr (may_keep_lines<E, n> && n >= 1 && n <= straight_line_limit) {
    if (DerivedOnce* const once = kept ? kept->once() : nullptr) return once->lines_with_slopes_of<n>(e);
  }
  return nullptr;
}

/// Makes a system or scene, which is a run's own, keep the lines of its equations.
template <class Sys, class Owner>
void keep_lines(Owner& owner) {
  if constexpr (may_keep_lines<typename Sys::EnergiesType, Sys::dof_at_compile_time>) owner.keep(KeptLines(std::make_shared<DerivedOnce>()));
}

/// Where T and V have become others since, they are derived anew.
template <class Sys, class Owner>
void renew_lines(Owner& owner, const Sys& system) {
  constexpr int n = Sys::dof_at_compile_time;
  if constexpr (may_keep_lines<typename Sys::EnergiesType, n>) {
    DerivedOnce* const once = system.kept_lines()->once();
    if (once && !once->template still_holds<n>(system.energies())) owner.keep(KeptLines(std::make_shared<DerivedOnce>()));
  }
}

}  // namespace qdot::detail
