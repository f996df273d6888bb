// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench eom`: chains summed with a plain `for`, as they are, in a run, and by each way that can be asked for.
#include "bench/chain_rows.hpp"

namespace qdot::bench {

namespace {

template <int n>
using Looped = LoopedChain;
template <int n>
using Paired = PairedChain;

}  // namespace

std::vector<EquationsRow> looped_chain_rows() {
  return joined({general_chain_rows<Looped, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 24, 32>("general, for"),
                 chain_rows<1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 24, 32, 48, 64>("general, for, in a run",
                                                                            []<int n>() -> AccelerationFunction { return by_run<n, LoopedChain>; }),
                 chain_rows<2, 4, 8, 16>("in a run, duals", []<int n>() -> AccelerationFunction { return by_way<n, LoopedChain, By::duals>; }),
                 chain_rows<2, 4, 8, 16>("in a run, lines", []<int n>() -> AccelerationFunction { return by_way<n, LoopedChain, By::lines>; }),
                 chain_rows<2, 4, 8, 16>("in a run, machine code", []<int n>() -> AccelerationFunction { return by_way<n, LoopedChain, By::machine_code>; }),
                 general_chain_rows<Paired, 8>("general, for over pairs"),
                 general_chain_rows<Paired, 16>("general, for over pairs")});
}

}  // namespace qdot::bench
