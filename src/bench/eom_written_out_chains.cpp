// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench eom`: the chains of eom_looped_chains.cpp, their plain `for` written out while compiling.
#include "bench/chain_energies.hpp"
#include "bench/eom.hpp"
#include "bench/hand_derived.hpp"
#include "qdot/mechanics/written_out.hpp"

namespace qdot::bench {

namespace {

template <int... n>
std::vector<EquationsRow> rows_of_lengths() {
  return {EquationsRow{.system = "chain",
                       .n = n,
                       .door = "general, for, written out",
                       .baseline = chain_by_hand<n>,
                       .measured = by_general_door<n, WrittenOut<n, LoopedChain>>,
                       .lowest = -2.0,
                       .highest = 2.0}...};
}

}  // namespace

std::vector<EquationsRow> written_out_chain_rows() { return rows_of_lengths<1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 24, 32>(); }

}  // namespace qdot::bench
