#pragma once
// SPDX-License-Identifier: MIT
//
// Derivations that are made where they are missing, and found again: the work of mechanics/derive/kept_lines.hpp.
//
// Programs that link qdot::compiled do not read this header: the library has it.

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "qdot/mechanics/derive/kept_lines.hpp"

namespace qdot::detail {

template <class Number>
[[gnu::cold]] BasicBranchDerivations<Number>::BasicBranchDerivations(By by) : by_(by) {}
template <class Number>
BasicBranchDerivations<Number>::~BasicBranchDerivations() = default;

template <class Number>
KeptDerivation* BasicBranchDerivations<Number>::at(const RecordableFunctors& functors, const AtState& at, bool checked, BasicBranchDerivations* of_system) {
  const auto holds = [&](KeptDerivation& it) { return it.holds_at(at) && (!checked || it.is_of(functors)); };
  if (KeptDerivation* const it = latest(); it && holds(*it)) return it;
  if (KeptDerivation* const made = found(holds)) return made;
  if (is_full_.load(std::memory_order_relaxed) || !all_finite(at.q, functors.size) || !all_finite(at.qdot, functors.size)) return nullptr;
  return added(functors, at, holds, of_system);
}

template <class Number>
[[gnu::cold]] std::shared_ptr<KeptDerivation> BasicBranchDerivations<Number>::shared_at(const RecordableFunctors& functors, const AtState& at) {
  const auto holds = [&](KeptDerivation& it) { return it.holds_at(at) && it.is_of(functors); };
  const bool has_room = count_.load(std::memory_order_acquire) < most / 2;  // the other half is for evaluations outside of runs
  KeptDerivation* const it = has_room ? this->at(functors, at, true) : found(holds);
  if (!it) return nullptr;
  const auto end = all_.begin() + static_cast<std::ptrdiff_t>(count_.load(std::memory_order_acquire));
  return *std::find_if(all_.begin(), end, [it](const std::shared_ptr<KeptDerivation>& each) { return each.get() == it; });
}

template <class Number>
[[gnu::cold]] bool BasicBranchDerivations<Number>::still_hold(const RecordableFunctors& functors) const {
  const auto end = all_.begin() + static_cast<std::ptrdiff_t>(count_.load(std::memory_order_acquire));
  return std::all_of(all_.begin(), end, [&](const std::shared_ptr<KeptDerivation>& each) { return each->is_of(functors); });
}

template <class Number>
template <class Holds>
[[gnu::noinline]] KeptDerivation* BasicBranchDerivations<Number>::found(const Holds& holds) {
  const std::size_t count = count_.load(std::memory_order_acquire);
  for (std::size_t i = 0; i < count; ++i)
    if (holds(*all_[i])) {
      latest_.store(i, std::memory_order_relaxed);
      return all_[i].get();
    }
  return nullptr;
}
template <class Number>
template <class Holds>
[[gnu::cold, gnu::noinline]] KeptDerivation* BasicBranchDerivations<Number>::added(const RecordableFunctors& functors, const AtState& at,
                                                                                   const Holds& holds, BasicBranchDerivations* of_system) {
  const std::lock_guard lock(adding_);
  if (KeptDerivation* const made = found(holds)) return made;
  if (is_full_.load(std::memory_order_relaxed)) return nullptr;
  std::shared_ptr<KeptDerivation> made = of_system ? of_system->shared_at(functors, at) : nullptr;
  if (!made) {
    made = std::make_shared<KeptDerivation>(by_);
    made->derive(functors, &at);
  }
  const std::size_t count = count_.load(std::memory_order_relaxed);
  const bool good = made->lines() && holds(*made);
  if (!good) ++failed_;
  if (!made->lines() || failed_ == most_failed || count + 1 == most) is_full_.store(true, std::memory_order_relaxed);
  if (!good) return nullptr;
  all_[count] = std::move(made);
  latest_.store(count, std::memory_order_relaxed);
  count_.store(count + 1, std::memory_order_release);
  return all_[count].get();
}

template <class Number>
[[gnu::cold]] BasicDerivations<Number>::BasicDerivations(By by) : by_(by), branches_(by) {}
template <class Number>
BasicDerivations<Number>::~BasicDerivations() = default;

template <class Number>
[[gnu::cold]] KeptDerivation* BasicDerivations<Number>::added(const RecordableFunctors& functors, Held& held) {
  const std::lock_guard lock(adding_);
  const Fingerprint now = functors.print(functors.energies, functors.size, nullptr);
  if (KeptDerivation* const found = made_with(now)) return found;
  const std::size_t count = count_.load(std::memory_order_relaxed);
  if (count == most) {
    held = further_;
    if (further_ && further_->print() == now) return further_.get();
    const bool again = std::exchange(missed_, now) == now;
    if (!again) return nullptr;
  }
  auto made = std::make_shared<KeptDerivation>(by_);
  made->derive(functors);
  if (!made->lines() || !made->print()) {
    has_branches_.store(true, std::memory_order_relaxed);
    return nullptr;
  }
  if (count == most) {
    held = further_ = std::move(made);
    return held.get();
  }
  all_[count] = std::move(made);
  count_.store(count + 1, std::memory_order_release);
  return all_[count].get();
}

template <class>
[[gnu::cold, gnu::noinline]] Derivations& made_derivations(SharedDerivations& shared) {
  const std::lock_guard lock(shared.making);
  if (!shared.owner) {
    auto made = std::make_shared<Derivations>(shared.by);
    shared.made.store(made.get(), std::memory_order_release);
    shared.owner = std::move(made);
  }
  return *static_cast<Derivations*>(shared.owner.get());
}

template <class Number>
[[gnu::cold]] BasicDerivedOnce<Number>::BasicDerivedOnce(std::shared_ptr<SharedDerivations> shared) : shared_(std::move(shared)), branches_(shared_->by) {}
template <class Number>
BasicDerivedOnce<Number>::~BasicDerivedOnce() = default;

template <class Number>
[[gnu::cold]] bool BasicDerivedOnce<Number>::still_holds(const RecordableFunctors& functors) {
  if (!is_asked_.load(std::memory_order_acquire)) return true;
  return everywhere_ ? everywhere_->is_of(functors) : branches_.still_hold(functors);
}

template <class>
[[gnu::cold]] std::shared_ptr<DerivedOnce> derived_once(const std::shared_ptr<SharedDerivations>& shared) {
  return std::make_shared<DerivedOnce>(shared);
}

template <class>
[[gnu::cold]] std::string way_of_lines(bool are_native, By asked, bool are_long) {
  if (are_native) return asked == By::machine_code ? "machine code of recorded formulas, as asked" : "machine code of recorded formulas";
  if (asked == By::lines) return "recorded formulas, interpreted, as asked";
  if (!formula::native_lines_are_possible())
    return "recorded formulas, interpreted, because there is no machine code: another processor or system, no executable memory, or QDOT_NATIVE=0";
  return are_long ? "recorded formulas, interpreted, because they are too many for machine code"
         : asked == By::machine_code ? "recorded formulas, interpreted, because there is machine code from the second evaluation on only"
                                     : "recorded formulas, interpreted, because there is machine code after 500 evaluations only";
}

}  // namespace qdot::detail
