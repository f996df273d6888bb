#pragma once
// SPDX-License-Identifier: MIT
//
// Interiors of power series: Σ_{j=1…k−1} L_j R_{k−j} of many products at once.
//
// A row holds one coefficient of all lanes, one behind the other. So an instruction adds to as many sums as the processor has room for: two, four
// or eight, which is decided when the program runs. Terms with odd and even j are added up apart, so that fewer additions wait for others.
// Products are not fused with sums, and each lane is summed in the same order, so all widths have the same bits.
//
// Of a square, L = R, every term but the middle one occurs twice: half of the sum is made, and doubled.

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "qdot/ad/formula/lane_lines.hpp"

namespace qdot::taylor {

/// Lanes of a row are so many or a multiple of it.
inline constexpr std::size_t lanes_of_row = 8;
constexpr std::size_t rounded_to_row(std::size_t lanes) { return (lanes + lanes_of_row - 1) / lanes_of_row * lanes_of_row; }

/// Rows of coefficients 0, 1, … of some numbers, one row for each order.
struct Rows {
  std::vector<std::uint32_t> places;  // of the numbers in an array
  std::vector<double> numbers;
  std::size_t width = 0;  // of a row, a multiple of lanes_of_row

  void set(std::vector<std::uint32_t> numbered, int highest_order) {
    places = std::move(numbered);
    width = rounded_to_row(places.size());
    numbers.assign(static_cast<std::size_t>(highest_order + 1) * width, 0.0);
  }
};

/// The rows of a sweep: factors of products, the left ones from lane `first_weighted` on times their order, and what is squared.
struct SeriesRows {
  Rows left, right, squares;
  std::size_t first_weighted = 0;
};

// Interiors of one order, to[i] of lane i.
template <int lanes>
[[gnu::always_inline]] inline void add_interiors(const SeriesRows& rows, std::size_t k, double* to) {
#if defined(__clang__)
#pragma clang fp contract(off)
#endif
  using R = qdot::detail::Register<double, lanes>;
  const std::size_t width = rows.left.width;
  for (std::size_t lane = 0; lane < width; lane += lanes) {
    R odd{}, even{}, x, y;
    const double* left = rows.left.numbers.data() + width + lane;
    const double* right = rows.right.numbers.data() + (k - 1) * width + lane;
    const auto add = [&](R& sum) __attribute__((always_inline)) {
      __builtin_memcpy(&x, left, sizeof x);
      __builtin_memcpy(&y, right, sizeof y);
      sum = sum + x * y;
      left += width;
      right -= width;
    };
    std::size_t left_over = k - 1;
    for (; left_over > 1; left_over -= 2) {
      add(odd);
      add(even);
    }
    if (left_over > 0) add(odd);
    odd = odd + even;
    __builtin_memcpy(to + lane, &odd, sizeof odd);
  }
  const std::size_t square_width = rows.squares.width;
  for (std::size_t lane = 0; lane < square_width; lane += lanes) {
    const double* const row = rows.squares.numbers.data() + lane;
    R half{}, x, y;
    for (std::size_t j = 1; 2 * j < k; ++j) {
      __builtin_memcpy(&x, row + j * square_width, sizeof x);
      __builtin_memcpy(&y, row + (k - j) * square_width, sizeof y);
      half = half + x * y;
    }
    half = half + half;
    if (k % 2 == 0) {
      __builtin_memcpy(&x, row + k / 2 * square_width, sizeof x);
      half = half + x * x;
    }
    __builtin_memcpy(to + width + lane, &half, sizeof half);
  }
}

/// Row k of what stands in x.
inline void write_rows(SeriesRows& rows, std::size_t k, const double* x) {
  const std::uint32_t *const left_at = rows.left.places.data(), *const right_at = rows.right.places.data();
  double *const left = rows.left.numbers.data() + k * rows.left.width, *const right = rows.right.numbers.data() + k * rows.right.width;
  const std::size_t first_weighted = rows.first_weighted, count = rows.left.places.size();
  for (std::size_t i = 0; i < first_weighted; ++i) {
    left[i] = x[left_at[i]];
    right[i] = x[right_at[i]];
  }
  for (std::size_t i = first_weighted; i < count; ++i) {
    left[i] = static_cast<double>(k) * x[left_at[i]];
    right[i] = x[right_at[i]];
  }
  double* const square = rows.squares.numbers.data() + k * rows.squares.width;
  for (std::size_t i = 0; i < rows.squares.places.size(); ++i) square[i] = x[rows.squares.places[i]];
}

#if defined(__GNUC__) && !defined(__clang__)
[[gnu::noinline, gnu::optimize("fp-contract=off")]]
#else
[[gnu::noinline]]
#endif
inline void add_interiors_by_any(const SeriesRows& rows, std::size_t k, double* to) noexcept {
  add_interiors<2>(rows, k, to);
}
#if defined(__x86_64__)
#if defined(__GNUC__) && !defined(__clang__)
[[gnu::noinline, gnu::target("avx2"), gnu::optimize("fp-contract=off")]]
#else
[[gnu::noinline, gnu::target("avx2")]]
#endif
inline void add_interiors_by_avx2(const SeriesRows& rows, std::size_t k, double* to) noexcept {
  add_interiors<4>(rows, k, to);
  __builtin_ia32_vzeroupper();
}
#if defined(__GNUC__) && !defined(__clang__)
[[gnu::noinline, gnu::target("avx512f"), gnu::optimize("fp-contract=off")]]
#else
[[gnu::noinline, gnu::target("avx512f")]]
#endif
inline void add_interiors_by_avx512(const SeriesRows& rows, std::size_t k, double* to) noexcept {
  add_interiors<8>(rows, k, to);
  __builtin_ia32_vzeroupper();
}
#endif

/// The fastest of them on this processor: to[i] = Σ_{j=1…k−1} L_j R_{k−j} of lane i, squares behind them.
inline auto fastest_interiors() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") != 0) return add_interiors_by_avx512;
  if (__builtin_cpu_supports("avx2") != 0) return add_interiors_by_avx2;
#endif
  return add_interiors_by_any;
}

}  // namespace qdot::taylor
