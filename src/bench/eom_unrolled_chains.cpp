// SPDX-License-Identifier: MIT
//
// Rows of `qdot bench eom`: chains summed with qdot::unroll.
#include "bench/chain_rows.hpp"

namespace qdot::bench {

std::vector<EquationsRow> unrolled_chain_rows() { return general_chain_rows<UnrolledChain, 1, 2, 3, 4, 5, 6, 7, 8>("general, unroll"); }

}  // namespace qdot::bench
