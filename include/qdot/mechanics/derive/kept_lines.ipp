#pragma once
// SPDX-License-Identifier: MIT
//
// Derivations that are made where they are missing, and found again: the work of mechanics/derive/kept_lines.hpp.
//
// Programs that link qdot::compiled do not read this file: the library has it.

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "qdot/mechanics/derive/kept_lines.hpp"
#include "qdot/mechanics/derive/kept_rates.hpp"

namespace qdot::detail {

template <class Number>
[[gnu::cold]] BasicBranchDerivations<Number>::BasicBranchDerivations(By by) : by_(by) {}
template <class Number>
BasicBranchDerivations<Number>::~BasicBranchDerivations() = default;

template <class Number>
KeptDerivation* BasicBranchDerivations<Number>::at(const RecordableFunctors& functors, const AtState& at, bool checked, BasicBranchDerivations* of_system) {
  const auto holds = [&](KeptDerivation& it) { return it.holds_at(at) && (!checked || it.is_of(functors)); };
  if (KeptDerivation* const it = latest(); it && holds(*it)) return it;
  const Held* const held = held_at(functors, at, holds, true, of_system);
  return held ? held->get() : nullptr;
}

// That of a state, and one more is made where it may be added.
template <class Number>
template <class Holds>
auto BasicBranchDerivations<Number>::held_at(const RecordableFunctors& functors, const AtState& at, const Holds& holds, bool may_add,
                                             BasicBranchDerivations* of_system) -> const Held* {
  if (const Held* const there = met_.found(holds)) return there;
  if (!may_add || met_.is_full() || !all_finite(at.q, functors.size) || !all_finite(at.qdot, functors.size)) return nullptr;
  return met_.added(holds, [&] {
    if (Held shared = of_system ? of_system->shared_at(functors, at) : nullptr) return shared;
    auto made = std::make_shared<KeptDerivation>(by_);
    made->derive(functors, &at);
    return made->lines() ? made : nullptr;
  });
}

template <class Number>
[[gnu::cold]] auto BasicBranchDerivations<Number>::shared_at(const RecordableFunctors& functors, const AtState& at) -> Held {
  const bool has_room = met_.count() < most / 2;  // the other half is for evaluations outside of runs
  const Held* const held = held_at(functors, at, [&](KeptDerivation& it) { return it.holds_at(at) && it.is_of(functors); }, has_room, nullptr);
  return held ? *held : nullptr;
}

template <class Number>
[[gnu::cold]] bool BasicBranchDerivations<Number>::still_hold(const RecordableFunctors& functors) const {
  return met_.all_of([&](const KeptDerivation& it) { return it.is_of(functors); });
}

template <class Number>
[[gnu::cold]] BasicDerivations<Number>::BasicDerivations(SharedDerivations& shared) : shared_(shared), branches_(shared.by) {}
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
  auto made = std::make_shared<KeptDerivation>(shared_.by);
  SharedRates* const rates = shared_.rates.load(std::memory_order_acquire);
  if (auto equations = rates != nullptr && now != 0 ? rates->equations(now) : nullptr) {
    made->take(std::move(equations), now);
  } else {
    made->derive(functors);
    if (!made->lines() || !made->print() || made->is_asked()) {
      has_branches_.store(true, std::memory_order_relaxed);
      return nullptr;
    }
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
    auto made = std::make_shared<Derivations>(shared);
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
