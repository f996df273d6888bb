#pragma once
// SPDX-License-Identifier: MIT
//
// Sums of Runge–Kutta methods in lanes: Σ wⱼ kⱼ of all components of eight motions.
//
// A step of Dop853 has some eighty terms for each component, as many operations as the equations of a double pendulum. They are written for two, four and
// eight doubles to an instruction, and the processor decides when the program runs. Products are not fused with sums, so that all have the same bits.

#include <cstddef>

#include "qdot/ad/formula/lane_lines.hpp"

namespace qdot::detail {

/// Terms of a sum: rows of numbers and their weights. A number is eight doubles, one of each lane.
struct LaneTerms {
  static constexpr std::size_t most = 16;
  const double* rows[most];
  double weights[most];
  std::size_t count = 0;

  void add(double weight, const double* row) {
    if (weight == 0.0) return;
    weights[count] = weight;
    rows[count++] = row;
  }
};

/// What a stage makes of a sum: y + (h Σ + lost), where h is one number.
struct LaneStage {
  const double *y, *h, *lost;
};

template <int width>
[[gnu::always_inline]] inline void add_lane_terms(double* to, std::size_t numbers, const LaneTerms& terms, const LaneStage* stage) {
#if defined(__clang__)
#pragma clang fp contract(off)
#endif
  using R = Register<double, width>;
  constexpr std::size_t lanes = formula::lanes_stored;
  for (std::size_t at = 0; at < numbers * lanes; at += width) {
    R sum, k;
    __builtin_memcpy(&k, terms.rows[0] + at, sizeof k);
    sum = terms.weights[0] * k;
    for (std::size_t j = 1; j < terms.count; ++j) {
      __builtin_memcpy(&k, terms.rows[j] + at, sizeof k);
      sum = sum + terms.weights[j] * k;
    }
    if (stage) {
      R y, h, lost;
      __builtin_memcpy(&y, stage->y + at, sizeof y);
      __builtin_memcpy(&h, stage->h + at % lanes, sizeof h);
      __builtin_memcpy(&lost, stage->lost + at, sizeof lost);
      sum = y + (h * sum + lost);
    }
    __builtin_memcpy(to + at, &sum, sizeof sum);
  }
}

#if defined(__GNUC__) && !defined(__clang__)
[[gnu::noinline, gnu::optimize("fp-contract=off")]]
#else
[[gnu::noinline]]
#endif
inline void add_lane_terms_by_any(double* to, std::size_t numbers, const LaneTerms& terms, const LaneStage* stage) noexcept {
  add_lane_terms<2>(to, numbers, terms, stage);
}
#if defined(__x86_64__)
#if defined(__GNUC__) && !defined(__clang__)
[[gnu::noinline, gnu::target("avx2"), gnu::optimize("fp-contract=off")]]
#else
[[gnu::noinline, gnu::target("avx2")]]
#endif
inline void add_lane_terms_by_avx2(double* to, std::size_t numbers, const LaneTerms& terms, const LaneStage* stage) noexcept {
  add_lane_terms<4>(to, numbers, terms, stage);
  __builtin_ia32_vzeroupper();
}
#if defined(__GNUC__) && !defined(__clang__)
[[gnu::noinline, gnu::target("avx512f"), gnu::optimize("fp-contract=off")]]
#else
[[gnu::noinline, gnu::target("avx512f")]]
#endif
inline void add_lane_terms_by_avx512(double* to, std::size_t numbers, const LaneTerms& terms, const LaneStage* stage) noexcept {
  add_lane_terms<8>(to, numbers, terms, stage);
  __builtin_ia32_vzeroupper();
}
#endif

/// The fastest of them on this processor: to[i] = Σ wⱼ kⱼ[i], or what a stage makes of it, for so many numbers; at least one term.
inline auto fastest_lane_sums() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") != 0) return add_lane_terms_by_avx512;
  if (__builtin_cpu_supports("avx2") != 0) return add_lane_terms_by_avx2;
#endif
  return add_lane_terms_by_any;
}

}  // namespace qdot::detail
