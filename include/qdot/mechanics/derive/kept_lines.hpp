#pragma once
// SPDX-License-Identifier: MIT
//
// Equations that are derived once and kept, for those who evaluate them many times (mechanics/equations/kept_lines.hpp says who and when).
//
// Within a run T and V must not become others, and who doubts it puts the lines aside and evaluates T and V themselves (integrate/watch/change_watch.hpp). Where a leg of
// the run begins they may have: they are recorded again, and derived again if so.

#include <atomic>
#include <memory>
#include <mutex>

#include "qdot/mechanics/derive/lines.hpp"
#include "qdot/mechanics/equations/kept_lines.hpp"

namespace qdot::detail {

/// The lines of one object's equations, once there are any. May be asked by several threads.
class DerivedOnce {
 public:
  /// The lines, or none.
  const DerivedLines* lines() const { return ready_.load(std::memory_order_acquire); }

  /// The lines of energies e, derived now if nobody has asked before; none where T and V are no formulas, or too long.
  template <int n, class E>
  const DerivedLines* lines_of(const E& e, Eigen::Index size = n) {
    if (!is_asked_.load(std::memory_order_acquire)) derive<n>(e, size);
    return lines();
  }

  /// Whether energies are those that have been derived, if any have.
  template <int n, class E>
  [[gnu::cold, gnu::noinline]] bool still_holds(const E& e) {
    if (!lines()) return true;
    const std::lock_guard lock(mutex_);
    try {
      return detail::still_holds(recorded_, [&](RecordedMotion& m) { run_energies<n>(m, e); });
    } catch (...) {  // no formulas any more
      return false;
    }
  }

 private:
  template <int n, class E>
  [[gnu::cold, gnu::noinline]] void derive(const E& e, Eigen::Index size) {
    const std::lock_guard lock(mutex_);
    if (is_asked_.load(std::memory_order_relaxed)) return;
    try {
      recorded_ = recorded_motion<n>(e, size);
      lines_ = detail::lines_of(recorded_);
    } catch (...) {  // what functors throw they throw again, where they are asked for values
      lines_ = {};
    }
    if (lines_.exist()) ready_.store(&lines_, std::memory_order_release);
    else recorded_ = {};
    is_asked_.store(true, std::memory_order_release);
  }

  std::atomic<const DerivedLines*> ready_{nullptr};
  std::atomic<bool> is_asked_{false};
  std::mutex mutex_;
  RecordedMotion recorded_;
  DerivedLines lines_;
};

// Which energies may have kept lines. More coordinates than are known while compiling have other ways (mechanics/derive/traced_motion.hpp).
template <class E, int n>
inline constexpr bool may_keep_lines = (n == Dynamic || n >= 1) && n <= graded_limit<n> && !requires { requires E::has_own_equations; } && !is_written_out<E> && RecordableEnergies<E, n>;

// The lines by which a system's M and r are evaluated now, if there are any.
template <int n, class E>
const DerivedLines* lines_now(KeptLines* kept, const E& e, Eigen::Index size = n) {
  if constexpr (may_keep_lines<E, n>) {
    if (kept && (n != Dynamic || size <= by_terms_limit) && kept->is_time()) return kept->once()->lines_of<n>(e, size);
  }
  return nullptr;
}

/// Makes a system or scene, which is a run's own, keep the lines of its equations.
template <class Sys, class Owner>
void keep_lines(Owner& owner) {
  if constexpr (may_keep_lines<typename Sys::EnergiesType, Sys::dof_at_compile_time>) owner.keep(KeptLines(std::make_shared<DerivedOnce>(), Sys::dof_at_compile_time == Dynamic ? 0 : 500));
}

/// Where T and V have become others since, they are derived anew.
template <class Sys, class Owner>
void renew_lines(Owner& owner, const Sys& system) {
  constexpr int n = Sys::dof_at_compile_time;
  if constexpr (may_keep_lines<typename Sys::EnergiesType, n>) {
    const auto& once = system.kept_lines()->once();
    if (once && !once->template still_holds<n>(system.energies())) owner.keep(KeptLines(std::make_shared<DerivedOnce>(), 0));
  }
}

}  // namespace qdot::detail
