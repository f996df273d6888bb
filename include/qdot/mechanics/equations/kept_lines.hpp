#pragma once
// SPDX-License-Identifier: MIT
//
// Where a system keeps its equations once they have been derived as lines (mechanics/derive/kept_lines.hpp).
//
// A system outside of runs and all its copies share one list of derivations. An evaluation there may use one of them only after a check that T and V
// still are what was derived. A run (mechanics/first_order_form.hpp, effects/scene_form.hpp) evaluates one derivation thousands of times: it checks at
// the start of each leg, and the change watch checks at its looks.

#include <atomic>
#include <memory>
#include <mutex>
#include <utility>

#include "qdot/mechanics/by.hpp"

namespace qdot::detail {

template <class Number>
class BasicDerivations;  // mechanics/derive/kept_lines.hpp has them
template <class Number>
class BasicDerivedOnce;
using Derivations = BasicDerivations<double>;
using DerivedOnce = BasicDerivedOnce<double>;
template <class Number>
class BasicSharedRates;  // mechanics/derive/kept_rates.hpp has them
using SharedRates = BasicSharedRates<double>;

/// The derivations of one system and its copies, made when they are first asked for.
struct SharedDerivations {
  std::atomic<Derivations*> made{nullptr};
  std::mutex making{};
  std::shared_ptr<void> owner{};
  std::atomic<SharedRates*> rates{nullptr};
  std::shared_ptr<void> owner_of_rates{};
  By by = By::fastest;
  std::shared_ptr<SharedDerivations> asked_for[2]{};  // of copies that go by lines, and by machine code
};
template <class = void>
std::shared_ptr<SharedDerivations> no_derivations_yet();
/// Those of a copy that goes another way; null where it has none.
template <class = void>
std::shared_ptr<SharedDerivations> derivations_by(const std::shared_ptr<SharedDerivations>& own, By way);

/// A system's share in derived lines: checked at each evaluation, or a run's own; and by which way it is evaluated.
class KeptLines {
 public:
  KeptLines() : KeptLines(no_derivations_yet(), By::fastest) {}
  /// No lines: of a system that is evaluated so few times that deriving them does not pay.
  static KeptLines none() { return KeptLines(std::shared_ptr<SharedDerivations>(), By::fastest); }
  /// Of a copy of a system that goes another way.
  KeptLines(const KeptLines& system, By way)
      : shared_(way == system.by_ ? system.shared_ : derivations_by(system.shared_, way)), by_(way) {
    if (way == system.by_) once_ = system.once_;
  }
  /// Lines of a run, derived together with those of `system`.
  KeptLines(const KeptLines& system, std::shared_ptr<DerivedOnce> once) : shared_(system.shared_), once_(std::move(once)), by_(system.by_) {}
  KeptLines(const KeptLines& other) : shared_(other.shared_), once_(other.once_), by_(other.by_) {}
  KeptLines& operator=(const KeptLines& other) {
    shared_ = other.shared_;
    once_ = other.once_;
    by_ = other.by_;
    return *this;
  }

  By by() const { return by_; }
  /// Whether the library chooses the way.
  bool is_fastest() const { return by_ == By::fastest; }
  /// Whether recorded formulas may be used.
  bool may_be_lines() const { return by_ != By::duals; }

  /// Whether what a run has kept must not be used now.
  bool is_aside() const { return is_aside_.load(std::memory_order_relaxed); }
  /// The lines of a run; null outside of runs.
  DerivedOnce* once() const { return is_aside() ? nullptr : once_.get(); }
  /// Null where there are to be none.
  const std::shared_ptr<SharedDerivations>& shared() const { return shared_; }

  /// Makes evaluations check T and V, in a run as well, as long as it lives.
  class Aside {
   public:
    explicit Aside(KeptLines* lines) : lines_(lines) { put(true); }
    ~Aside() { put(false); }
    Aside(const Aside&) = delete;
    Aside& operator=(const Aside&) = delete;

   private:
    void put(bool aside) {
      if (lines_) lines_->is_aside_.store(aside, std::memory_order_relaxed);
    }
    KeptLines* lines_;
  };

 private:
  KeptLines(std::shared_ptr<SharedDerivations> shared, By by) : shared_(std::move(shared)), by_(by) {}

  std::shared_ptr<SharedDerivations> shared_;
  std::shared_ptr<DerivedOnce> once_;
  By by_;
  std::atomic<bool> is_aside_{false};
};

template <class>
[[gnu::cold]] std::shared_ptr<SharedDerivations> no_derivations_yet() {
  return std::make_shared<SharedDerivations>();
}
template <class>
[[gnu::cold]] std::shared_ptr<SharedDerivations> derivations_by(const std::shared_ptr<SharedDerivations>& own, By way) {
  if (way == By::duals) return nullptr;
  if (way == By::fastest || !own) return no_derivations_yet();
  const std::lock_guard lock(own->making);
  auto& found = own->asked_for[way == By::lines ? 0 : 1];
  if (!found) {
    found = no_derivations_yet();
    found->by = way;
  }
  return found;
}

#ifdef QDOT_COMPILED
extern template std::shared_ptr<SharedDerivations> no_derivations_yet<void>();
extern template std::shared_ptr<SharedDerivations> derivations_by<void>(const std::shared_ptr<SharedDerivations>&, By);
#endif

}  // namespace qdot::detail
