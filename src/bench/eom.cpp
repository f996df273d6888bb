// SPDX-License-Identifier: MIT
//
// How much the derivation of the equations of motion by the library costs over equations derived by hand. Every
// row calls acceleration(), as a user does, on the natural way to write T and V.
#include "bench/eom.hpp"

#include "bench/bench.hpp"

namespace qdot::bench {

namespace {

Findings measured() {
  Findings findings;
  for (const auto rows_of : {system_rows, unrolled_chain_rows, looped_chain_rows, kinematic_chain_rows, jacobian_rows})
    for (const EquationsRow& row : rows_of()) findings.rows.push_back(timed(row, row.door));
  findings.note = "One evaluation; 64 states in turn, the least of up to 300 repeats in which both ways alternate.";
  return findings;
}

}  // namespace

Benchmark benchmark() { return {"eom", "time of one q̈ from T and V against equations derived by hand", measured}; }

}  // namespace qdot::bench
