#pragma once
// SPDX-License-Identifier: MIT
//
// Sines and cosines of lines, several at once.
//
// The angles of a formula mostly stand on one level, and the polynomials for a sine (ad/pack_math.hpp) take four angles at a time in the time
// of one. They are the same operations in each lane, and products are not fused with sums. So a result does not depend on its neighbours, on
// how many there are, or on the processor. Errors stay below 1 unit in the last place. Angles beyond 10⁵ and NaN are the C library's.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "qdot/ad/pack_math.hpp"

namespace qdot::formula {

/// Where an angle is, and where its sine and cosine go.
struct CircularPlaces {
  std::uint32_t angle, sine, cosine;
};

// Each by itself, where some may be outside of the range of the polynomials.
#if defined(__GNUC__) && !defined(__clang__)
[[gnu::noinline, gnu::cold, gnu::optimize("fp-contract=off")]]
#else
[[gnu::noinline, gnu::cold]]
#endif
inline void write_circular_one_by_one(double* x, const CircularPlaces* at, std::size_t count) noexcept {
  for (const CircularPlaces* each = at; each != at + count; ++each) {
    const double angle = x[each->angle];
    if (std::abs(angle) <= qdot::detail::circular_range) {
      const qdot::detail::Register<double, 2> angles{angle, angle};
      qdot::detail::Register<double, 2> sine, cosine;
      qdot::detail::find_circular(angles, sine, cosine);
      x[each->sine] = sine[0];
      x[each->cosine] = cosine[0];
    } else {
      x[each->sine] = std::sin(angle);
      x[each->cosine] = std::cos(angle);
    }
  }
}

// By the polynomials, where the sum of the angles' sizes says that each is in their range.
template <std::size_t... lane>
[[gnu::always_inline]] inline void write_circular_block(double* x, const CircularPlaces* at, std::size_t count, std::index_sequence<lane...>) {
  using R = qdot::detail::Register<double, sizeof...(lane)>;
  const double angle[] = {x[at[lane < count ? lane : 0].angle]...};
  if (__builtin_expect(!((std::abs(angle[lane]) + ...) <= qdot::detail::circular_range), 0)) return write_circular_one_by_one(x, at, count);
  const R angles{angle[lane]...};
  R sine, cosine;
  qdot::detail::find_circular(angles, sine, cosine);
  ((lane < count ? void((x[at[lane].sine] = sine[lane], x[at[lane].cosine] = cosine[lane])) : void()), ...);
}

template <std::size_t most_lanes>
[[gnu::always_inline]] inline void write_all_circular(double* x, const CircularPlaces* at, std::size_t count) {
  while (count > 0) {
    const std::size_t taken = count < most_lanes ? count : most_lanes;
    if (most_lanes == 2 || count <= 2) write_circular_block(x, at, taken, std::make_index_sequence<2>());
    else write_circular_block(x, at, taken, std::make_index_sequence<most_lanes>());
    at += taken;
    count -= taken;
  }
}

// As machine code calls them. They do not throw. The upper halves of registers are cleared at the end, which compilers leave out below -O2. Otherwise
// all code of SSE in the program becomes several times slower.
#if defined(__GNUC__) && !defined(__clang__)
[[gnu::noinline, gnu::optimize("fp-contract=off")]]
#else
[[gnu::noinline]]
#endif
inline void write_circular_by_any(double* x, const CircularPlaces* at, std::size_t count) noexcept {
  write_all_circular<2>(x, at, count);
}
#if defined(__x86_64__)
#if defined(__GNUC__) && !defined(__clang__)
[[gnu::noinline, gnu::target("avx2"), gnu::optimize("fp-contract=off")]]
#else
[[gnu::noinline, gnu::target("avx2")]]
#endif
inline void write_circular_by_avx2(double* x, const CircularPlaces* at, std::size_t count) noexcept {
  write_all_circular<4>(x, at, count);
  __builtin_ia32_vzeroupper();
}
#endif

/// The fastest of them on this processor.
inline auto fastest_circular() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") != 0) return write_circular_by_avx2;
#endif
  return write_circular_by_any;
}

// Of the lanes of numbers, some at a time: where an angle is and its sine and cosine go, as many follow.
template <int lanes>
[[gnu::always_inline]] inline void write_circular_of_lanes(double* x, const CircularPlaces* at, std::size_t count) {
  using R = qdot::detail::Register<double, lanes>;
  for (const CircularPlaces* each = at; each != at + count; ++each) {
    R angles, sine, cosine;
    __builtin_memcpy(&angles, x + each->angle, sizeof angles);
    qdot::detail::find_circular(angles, sine, cosine);
    __builtin_memcpy(x + each->sine, &sine, sizeof sine);
    __builtin_memcpy(x + each->cosine, &cosine, sizeof cosine);
    bool within = true;
    for (int lane = 0; lane < lanes; ++lane) within &= std::abs(angles[lane]) <= qdot::detail::circular_range;
    for (std::uint32_t lane = 0; __builtin_expect(!within, 0) && lane < lanes; ++lane) {
      const CircularPlaces one{each->angle + lane, each->sine + lane, each->cosine + lane};
      write_circular_one_by_one(x, &one, 1);
    }
  }
}

// As machine code calls them. They do not throw.
#if defined(__GNUC__) && !defined(__clang__)
[[gnu::noinline, gnu::optimize("fp-contract=off")]]
#else
[[gnu::noinline]]
#endif
inline void write_eight_lanes_by_any(double* x, const CircularPlaces* at, std::size_t count) noexcept {
  for (double* some = x; some != x + 8; some += 2) write_circular_of_lanes<2>(some, at, count);
}
#if defined(__x86_64__)
#if defined(__GNUC__) && !defined(__clang__)
[[gnu::noinline, gnu::target("avx2"), gnu::optimize("fp-contract=off")]]
#else
[[gnu::noinline, gnu::target("avx2")]]
#endif
inline void write_four_lanes_by_avx2(double* x, const CircularPlaces* at, std::size_t count) noexcept {
  write_circular_of_lanes<4>(x, at, count);
  __builtin_ia32_vzeroupper();
}
inline void write_eight_lanes_by_avx2(double* x, const CircularPlaces* at, std::size_t count) noexcept {
  write_four_lanes_by_avx2(x, at, count);
  write_four_lanes_by_avx2(x + 4, at, count);
}
#if defined(__GNUC__) && !defined(__clang__)
[[gnu::noinline, gnu::target("avx512f"), gnu::optimize("fp-contract=off")]]
#else
[[gnu::noinline, gnu::target("avx512f")]]
#endif
inline void write_eight_lanes_by_avx512(double* x, const CircularPlaces* at, std::size_t count) noexcept {
  write_circular_of_lanes<8>(x, at, count);
  __builtin_ia32_vzeroupper();
}
#endif

/// The function for this many lanes, 4 or 8, at a time; four need AVX2, eight AVX-512.
inline auto circular_of_lanes([[maybe_unused]] int lanes) {
#if defined(__x86_64__)
  return lanes == 4 ? write_four_lanes_by_avx2 : write_eight_lanes_by_avx512;
#else
  return write_eight_lanes_by_any;
#endif
}
/// The fastest of them for eight lanes on this processor.
inline auto fastest_circular_of_eight() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") != 0) return write_eight_lanes_by_avx512;
  if (__builtin_cpu_supports("avx2") != 0) return write_eight_lanes_by_avx2;
#endif
  return write_eight_lanes_by_any;
}

}  // namespace qdot::formula
