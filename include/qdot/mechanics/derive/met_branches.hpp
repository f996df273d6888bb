#pragma once
// SPDX-License-Identifier: MIT
//
// What is made for each branch of some functors, where a branch is met first.
//
// Functors that compare numbers have other formulas on each branch (ad/formula/branches.hpp). An item is made for a branch, and holds as long as the guards of
// the branch do, so the one that held last is asked first. Several threads may ask at once: what has been added stays where it is.

#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>

namespace qdot::detail {

/// Items of the branches that are met, at most so many.
///
/// @tparam most_failed  items that could not be made, or do not hold where they were made; then no more are
template <class Item, std::size_t most, int most_failed = 8>
class MetBranches {
 public:
  using Held = std::shared_ptr<Item>;

  /// The item that held last; null where there is none.
  Item* latest() const {
    const std::size_t last = latest_.load(std::memory_order_acquire);
    return last < count() ? all_[last].get() : nullptr;
  }
  std::size_t count() const { return count_.load(std::memory_order_acquire); }
  /// Whether no more are made.
  bool is_full() const { return is_full_.load(std::memory_order_relaxed); }

  /// The first item of which holds(item); null where there is none.
  template <class Holds>
  const Held* found(const Holds& holds) {
    const std::size_t last = count();
    for (std::size_t i = 0; i < last; ++i)
      if (holds(*all_[i])) {
        latest_.store(i, std::memory_order_release);
        return &all_[i];
      }
    return nullptr;
  }
  /// The first item of which holds(item), or else what make() returns, if that is not null and holds. After some failures no more are made.
  template <class Holds, class Make>
  [[gnu::cold, gnu::noinline]] const Held* added(const Holds& holds, const Make& make) {
    const std::lock_guard lock(adding_);
    if (const Held* const there = found(holds)) return there;
    if (is_full()) return nullptr;
    Held made = make();
    const std::size_t last = count();
    const bool good = made && holds(*made);
    if (!good) ++failed_;
    if (failed_ == most_failed || last + 1 == most) is_full_.store(true, std::memory_order_relaxed);
    if (!good) return nullptr;
    all_[last] = std::move(made);
    count_.store(last + 1, std::memory_order_release);
    latest_.store(last, std::memory_order_release);
    return &all_[last];
  }
  template <class Holds>
  bool all_of(const Holds& holds) const {
    const std::size_t last = count();
    for (std::size_t i = 0; i < last; ++i)
      if (!holds(*all_[i])) return false;
    return true;
  }

 private:
  std::array<Held, most> all_;
  std::atomic<std::size_t> count_{0}, latest_{0};
  std::atomic<bool> is_full_{false};
  std::mutex adding_;
  int failed_ = 0;
};

}  // namespace qdot::detail
