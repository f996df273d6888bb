#pragma once
// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench eom` about chains of some lengths.

#include <vector>

#include "bench/chain_energies.hpp"
#include "bench/eom.hpp"
#include "bench/hand_derived.hpp"

namespace qdot::bench {

/// A row for each length; measured is <int n>() ↦ an AccelerationFunction.
template <int... n, class Measured>
std::vector<EquationsRow> chain_rows(const char* door, const Measured& measured) {
  return {EquationsRow{.system = "chain", .n = n, .door = door, .baseline = chain_by_hand<n>,
                       .measured = measured.template operator()<n>(), .lowest = -2.0, .highest = 2.0}...};
}

/// Rows of energies E<n> by the general door.
template <template <int> class E, int... n>
std::vector<EquationsRow> general_chain_rows(const char* door) {
  return chain_rows<n...>(door, []<int m>() -> AccelerationFunction { return by_general_door<m, E<m>>; });
}

}  // namespace qdot::bench
