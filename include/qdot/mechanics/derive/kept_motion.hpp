#pragma once
// SPDX-License-Identifier: MIT
//
// Objects that were traced from a form's functors, and kept.
//
// One is made for each combination of phases, when it is first asked for, and again where a leg begins and the functors are others by then. Copies of a form
// share what one of them has made, and work by themselves.

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "qdot/mechanics/derive/recordable_form.hpp"
#include "qdot/mechanics/derive/traced.hpp"

namespace qdot::detail {

/// The rates of a form without constraints.
template <class = void>
std::unique_ptr<TracedRates> traced_rates(const RecordableForm& form);

template <class Number>
class TracedEquations;  // mechanics/derive/traced_equations.hpp
/// The equations of a form, recorded anew.
template <class = void>
std::shared_ptr<TracedEquations<double>> recorded_equations(const RecordableForm& form);

/// A lock that is held for some nanoseconds, or once for what is derived, and hardly ever waited for.
class ShortLock {
 public:
  void lock() noexcept {
    while (is_held_.test_and_set(std::memory_order_acquire)) is_held_.wait(true, std::memory_order_relaxed);
  }
  void unlock() noexcept {
    is_held_.clear(std::memory_order_release);
    is_held_.notify_one();
  }

 private:
  std::atomic_flag is_held_;
};

/// What a form keeps, one for each combination of phases. Nothing is there where functors are no formulas, or where it does not pay. Each is asked by one
/// thread at a time, others wait.
///
/// @tparam Motion  derived from Traced
template <class Motion>
class KeptMotion {
 public:
  using Phases = std::span<const double>;

  KeptMotion() = default;
  KeptMotion(const KeptMotion& other) : made_(other.made()) {}
  KeptMotion& operator=(const KeptMotion& other) {
    auto theirs = other.made();
    const std::lock_guard lock(lock_);
    made_ = std::move(theirs);
    own_.clear();
    return *this;
  }

  /// use(motion), which says whether it did; false where there is none. make() returns a pointer to a new one.
  template <class Make, class Use>
  bool use(Phases phases, const Make& make, const Use& use) const {
    const std::lock_guard lock(lock_);
    InPhases* own = in(own_, phases);
    if (!made_) made_ = std::make_shared<Made>();
    if (!own) own = &added(own_, made_->made_or(phases, make));
    return own->motion && use(*own->motion);
  }
  template <class Make, class Use>
  bool use(const Make& make, const Use& use) const {
    return this->use({}, make, use);
  }

  /// Looks whether the functors are the same still. If not, all is forgotten.
  void renew(const RecordableForm& form) {
    const std::lock_guard lock(lock_);
    if (!made_) return;
    made_->add_missing(own_);
    try {
      if (std::ranges::all_of(own_, [&](InPhases& own) { return own.motion && own.motion->still_holds(form); })) return;
    } catch (...) {  // no formulas any more
    }
    made_.reset();
    own_.clear();
  }

 private:
  struct InPhases {
    std::vector<double> phases;
    std::unique_ptr<Motion> motion;

    InPhases copy() const { return {phases, motion ? copy_of(*motion) : nullptr}; }
  };
  static std::unique_ptr<Motion> copy_of(const Motion& motion) { return std::unique_ptr<Motion>(static_cast<Motion*>(motion.copy().release())); }
  static constexpr std::size_t most = 16;

  static InPhases* in(std::vector<InPhases>& all, Phases phases) {
    for (InPhases& one : all)
      if (std::ranges::equal(one.phases, phases)) return &one;
    return nullptr;
  }
  static InPhases& added(std::vector<InPhases>& all, InPhases one) {
    if (all.size() == most) all.erase(all.begin());
    all.push_back(std::move(one));
    return all.back();
  }

  // What copies share.
  class Made {
   public:
    template <class Make>
    InPhases made_or(Phases phases, const Make& make) {
      const std::lock_guard lock(mutex_);
      if (const InPhases* one = in(all_, phases)) return one->copy();
      InPhases& made = added(all_, {{phases.begin(), phases.end()}, {}});
      try {
        made.motion = make();
        if (!made.motion->is_known()) made.motion.reset();
      } catch (...) {  // what functors throw they throw again, where the general way asks them
        made.motion.reset();
      }
      return made.copy();
    }
    void add_missing(std::vector<InPhases>& own) {
      const std::lock_guard lock(mutex_);
      for (const InPhases& one : all_)
        if (!in(own, one.phases)) added(own, one.copy());
    }

   private:
    std::mutex mutex_;
    std::vector<InPhases> all_;
  };
  std::shared_ptr<Made> made() const {
    const std::lock_guard lock(lock_);
    return made_;
  }

  mutable ShortLock lock_;
  mutable std::shared_ptr<Made> made_;  // null until the first use
  mutable std::vector<InPhases> own_;
};

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template std::unique_ptr<TracedRates> traced_rates<void>(const RecordableForm&);
extern template std::shared_ptr<TracedEquations<double>> recorded_equations<void>(const RecordableForm&);
}  // namespace qdot::detail
#else
#include "qdot/mechanics/derive/kept_motion.ipp"
#endif
