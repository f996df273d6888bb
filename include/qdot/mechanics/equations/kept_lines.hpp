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

namespace qdot::detail {

class Derivations;  // mechanics/derive/kept_lines.hpp
class DerivedOnce;

/// The derivations of one system and its copies, made when they are first asked for.
struct SharedDerivations {
  std::atomic<Derivations*> made{nullptr};
  std::mutex making{};
  std::shared_ptr<void> owner{};
};

/// A system's share in derived lines: checked at each evaluation, or a run's own.
class KeptLines {
 public:
  KeptLines() : shared_(std::make_shared<SharedDerivations>()) {}
  /// No lines: of a system that is evaluated so few times that deriving them does not pay.
  static KeptLines none() { return KeptLines(std::shared_ptr<SharedDerivations>()); }
  /// Lines of a run, derived together with those of `system`.
  KeptLines(const KeptLines& system, std::shared_ptr<DerivedOnce> once) : shared_(system.shared_), once_(std::move(once)) {}
  KeptLines(const KeptLines& other) : shared_(other.shared_), once_(other.once_) {}
  KeptLines& operator=(const KeptLines& other) {
    shared_ = other.shared_;
    once_ = other.once_;
    return *this;
  }

  /// The lines of a run; null outside of runs.
  DerivedOnce* once() const { return is_aside_.load(std::memory_order_relaxed) ? nullptr : once_.get(); }
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
  explicit KeptLines(std::shared_ptr<SharedDerivations> shared) : shared_(std::move(shared)) {}

  std::shared_ptr<SharedDerivations> shared_;
  std::shared_ptr<DerivedOnce> once_;
  std::atomic<bool> is_aside_{false};
};

}  // namespace qdot::detail
