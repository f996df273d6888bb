#pragma once
// SPDX-License-Identifier: MIT
//
// Four numbers at once, for rows of numbers that are processed in blocks (ad/places/position_row.hpp, mechanics/equations/block_solve.hpp).

namespace qdot::detail {

// On every machine; in memory they are plain numbers at any alignment.
using Block = double __attribute__((vector_size(32)));

[[gnu::always_inline]] inline void read(Block& block, const double* from) { __builtin_memcpy(&block, from, sizeof block); }
[[gnu::always_inline]] inline void write(double* to, const Block& block) { __builtin_memcpy(to, &block, sizeof block); }

// to ← c from;  to ← to + c from
[[gnu::always_inline]] inline void set_block(double* to, double c, const double* from) {
  Block b;
  read(b, from);
  write(to, c * b);
}
[[gnu::always_inline]] inline void add_block(double* to, double c, const double* from) {
  Block a, b;
  read(a, to);
  read(b, from);
  write(to, a + c * b);
}

}  // namespace qdot::detail
