#pragma once
// SPDX-License-Identifier: MIT
//
// A loop that the compiler sees through.
//
// Code that is fast because everything stays in registers, or because the compiler carries it out while it compiles, has no loops. Compilers unroll
// loops that are short already; this one is unrolled however long it is.
//
// The library's own is inlined always. The loop for users is not, because of GCC, which prepares functions in the order of their calls. It does not
// count calls from functions that are inlined always. So it would not know in time what a user's functor calls, and would find no hash of it
// (mechanics/derive/fingerprint.hpp).

#include <type_traits>
#include <utility>

namespace qdot {

namespace detail {

// f(i), inlined whatever its size.
template <class F, class Index>
[[gnu::always_inline]] inline constexpr void call_inlined(F& f, Index i) {
#if defined(__clang__) && defined(__OPTIMIZE__) && __clang_major__ >= 15
  [[clang::always_inline]] f(i);
#else
  f(i);
#endif
}

template <int first, class F, int... Is>
[[gnu::always_inline]] inline constexpr void unroll_over(F& f, std::integer_sequence<int, Is...>) {
  (call_inlined(f, std::integral_constant<int, first + Is>{}), ...);
}

// Halves of a long loop, because compilers nest expressions only so deep (clang: 256).
template <int first, int last, class F>
[[gnu::always_inline]] inline constexpr void unroll_between(F& f) {
  if constexpr (last - first <= 128) {
    unroll_over<first>(f, std::make_integer_sequence<int, last - first>{});
  } else {
    unroll_between<first, (first + last) / 2>(f);
    unroll_between<(first + last) / 2, last>(f);
  }
}

// For the library's own loops.
template <int n, class F>
[[gnu::always_inline]] inline constexpr void unroll(F&& f) {
  unroll_between<0, n>(f);
}

template <class F, int... Is>
constexpr void unroll_for_users(F& f, std::integer_sequence<int, Is...>) {
  (f(std::integral_constant<int, Is>{}), ...);
}

}  // namespace detail

/// Calls f(0), f(1), …, f(n − 1) with arguments known to the compiler: a loop that it sees through.
///
/// In a run an energy with a `for` in its place is as fast. A call of acceleration() hashes T and V, and without a loop g++ finds most of the hash while
/// it compiles.
template <int n, class F>
#ifdef __clang__
[[gnu::always_inline]]
#endif
constexpr void unroll(F&& f) {
#ifdef __clang__
  detail::unroll_between<0, n>(f);
#else
  detail::unroll_for_users(f, std::make_integer_sequence<int, n>{});
#endif
}

}  // namespace qdot
