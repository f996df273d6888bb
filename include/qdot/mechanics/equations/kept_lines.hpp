#pragma once
// SPDX-License-Identifier: MIT
//
// What a run keeps of a system's equations, seen from the system.
//
// T and V written with loops hide from the compiler which derivatives are zero. A run (mechanics/first_order_form.hpp,
// effects/scene_form.hpp) asks for M and r thousands of times, and it pays to derive them as lines (mechanics/derive/kept_lines.hpp) and
// to go through these. An evaluation outside of a run knows no kept lines: T and V may read something that will have changed by the next
// one.

#include <atomic>
#include <memory>
#include <utility>

namespace qdot::detail {

class DerivedOnce;  // mechanics/derive/kept_lines.hpp

/// A system's share in lines that are derived once; of a system outside of runs there is none.
class KeptLines {
 public:
  KeptLines() = default;
  explicit KeptLines(std::shared_ptr<DerivedOnce> once) : once_(std::move(once)) {}
  KeptLines(const KeptLines& other) : once_(other.once_) {}
  KeptLines& operator=(const KeptLines& other) {
    once_ = other.once_;
    return *this;
  }

  /// The lines, to be derived or not; null where they are none of this system's.
  DerivedOnce* once() const { return is_aside_.load(std::memory_order_relaxed) ? nullptr : once_.get(); }

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
  std::atomic<bool> is_aside_{false};
};

}  // namespace qdot::detail
