#pragma once
// SPDX-License-Identifier: MIT
//
// What a run keeps of a system's equations, seen from the system.
//
// T and V written with loops hide from the compiler which derivatives are zero. A run (mechanics/first_order_form.hpp, effects/scene_form.hpp) asks for M and r thousands of
// times, and it pays to derive them as lines (mechanics/derive/kept_lines.hpp) and to go through these. Deriving takes what some five hundred evaluations without lines
// take, so the first five hundred of a run are without; with a number of coordinates that is known at run time only, where they are dear, there is no such delay. An evaluation outside of a run knows no kept lines: T and V may read something that will have changed by the next one.
//
// Copies share what one of them has derived, but each counts by itself, so that the numbers of a run do not depend on what else there is.

#include <atomic>
#include <memory>
#include <utility>

namespace qdot::detail {

class DerivedOnce;  // mechanics/derive/kept_lines.hpp

/// A system's share in lines that are derived once; of a system outside of runs there is none.
class KeptLines {
 public:
  KeptLines() = default;
  /// @param patience  how many evaluations are without lines
  explicit KeptLines(std::shared_ptr<DerivedOnce> once, int patience) : once_(std::move(once)), patience_(patience) {}
  KeptLines(const KeptLines& other) : once_(other.once_), patience_(other.patience_) {}
  KeptLines& operator=(const KeptLines& other) {
    once_ = other.once_;
    patience_ = other.patience_;
    asked_.store(0, std::memory_order_relaxed);
    return *this;
  }

  const std::shared_ptr<DerivedOnce>& once() const noexcept { return once_; }

  /// Whether it is time to go by lines; counts how often it has been asked.
  bool is_time() {
    if (!once_) return false;
    const int asked = asked_.load(std::memory_order_relaxed);
    if (asked >= patience_) return !is_aside_.load(std::memory_order_relaxed);
    if (!is_aside_.load(std::memory_order_relaxed)) asked_.store(asked + 1, std::memory_order_relaxed);
    return false;
  }

  /// Puts the lines aside as long as it lives.
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
  std::shared_ptr<DerivedOnce> once_;
  int patience_ = 0;
  std::atomic<int> asked_{0};
  std::atomic<bool> is_aside_{false};
};

}  // namespace qdot::detail
