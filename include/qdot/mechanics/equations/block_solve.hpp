#pragma once
// SPDX-License-Identifier: MIT
//
// L D Lᵀ of a full matrix by blocks of four columns.
//
// Up to 64 coordinates, or 32 where their number is known at run time, M is a lower triangle in rows of 4·blocks numbers. A pivot that is not above a
// fraction of its diagonal entry ends the elimination; the general way looks again and names what is wrong.

#include <algorithm>

#include "qdot/ad/vector.hpp"

namespace qdot::detail {

// Up to how many coordinates M is kept so, the blocks of its rows, and their length. The rows of a system of run-time size are as long as the largest.
template <int n>
inline constexpr int block_limit = n == Dynamic ? 32 : 64;
template <int n>
inline constexpr int blocks_of = ((n == Dynamic ? block_limit<n> : n <= block_limit<n> ? n : 1) + 3) / 4;
template <int n>
inline constexpr int block_stride = 4 * blocks_of<n>;

// Four numbers at once; in memory they are plain numbers at any alignment.
using Block = double __attribute__((vector_size(32)));

[[gnu::always_inline]] inline void read(Block& block, const double* from) { __builtin_memcpy(&block, from, sizeof block); }
[[gnu::always_inline]] inline void write(double* to, const Block& block) { __builtin_memcpy(to, &block, sizeof block); }
// to ← to + c from
[[gnu::always_inline]] inline void add_block(double* to, double c, const double* from) {
  Block a, b;
  read(a, to);
  read(b, from);
  write(to, a + c * b);
}

// b ← M⁻¹ b by L D Lᵀ, where M has rows of 4·blocks numbers, the lower triangle first; false when a pivot is below
// `threshold` of its diagonal entry or NaN. M becomes L, below its diagonal; 1/D is left in `inverse`.
template <int blocks>
bool solved_by_blocks(int n, double* M, double* b, double threshold, double* inverse) {
  constexpr int stride = 4 * blocks;
  double diagonal[stride];
  double column[4][stride];
  for (int k = 0; k < n; ++k) diagonal[k] = M[k * stride + k];
  for (int K = 0; 4 * K < n; ++K) {
    const int columns = std::min(4, n - 4 * K);
    for (int c = 0; c < columns; ++c) {
      const int k = 4 * K + c;
      const double pivot = M[k * stride + k];
      if (!(pivot > threshold * diagonal[k])) return false;
      inverse[k] = 1.0 / pivot;
      double* const below = column[c];
      for (int j = 4 * K; j <= k; ++j) below[j] = 0.0;
      for (int j = k + 1; j < n; ++j) below[j] = M[j * stride + k];
      for (int j = n; j < stride; ++j) below[j] = 0.0;
      for (int i = k + 1; i < n; ++i) {
        const double l = below[i] * inverse[k];
        add_block(M + i * stride + 4 * K, -l, below + 4 * K);
        M[i * stride + k] = l;
        b[i] -= l * b[k];
      }
    }
    for (int i = 4 * K + 4; i < n; ++i) {
      double* const row = M + i * stride;
      const double* const l = row + 4 * K;
      for (int J = K + 1; J <= i / 4; ++J) {
        Block m, c0, c1, c2, c3;
        read(m, row + 4 * J);
        read(c0, column[0] + 4 * J);
        read(c1, column[1] + 4 * J);
        read(c2, column[2] + 4 * J);
        read(c3, column[3] + 4 * J);
        m -= (l[0] * c0 + l[1] * c1) + (l[2] * c2 + l[3] * c3);
        write(row + 4 * J, m);
      }
    }
  }
  for (int k = 0; k < n; ++k) b[k] *= inverse[k];
  for (int i = n - 1; i > 0; --i)
    for (int k = 0; k < i; ++k) b[k] -= M[i * stride + k] * b[i];
  return true;
}

template <int blocks>
bool solved_by_blocks(int n, double* M, double* b, double threshold) {
  double inverse[4 * blocks];
  return solved_by_blocks<blocks>(n, M, b, threshold, inverse);
}

}  // namespace qdot::detail
