// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench eom`: the chains of eom_looped_chains.cpp, their plain `for` written out while compiling.
#include "bench/chain_rows.hpp"
#include "qdot/mechanics/written_out.hpp"

namespace qdot::bench {

namespace {

template <int n>
using WrittenOutChain = WrittenOut<n, LoopedChain>;

}  // namespace

std::vector<EquationsRow> written_out_chain_rows() {
  return general_chain_rows<WrittenOutChain, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 24, 32>("general, for, written out");
}

}  // namespace qdot::bench
