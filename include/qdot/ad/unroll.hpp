#pragma once
// SPDX-License-Identifier: MIT
//
// A loop that the compiler sees through.
//
// Code that is fast because of what is zero, or because everything stays in registers, must be straight-line code. Compilers unroll
// loops that are short already; this one is unrolled however long it is.

#include <type_traits>
#include <utility>

namespace qdot {

namespace detail {

template <int first, class F, int... Is>
[[gnu::always_inline]] inline constexpr void unroll_over(F& f, std::integer_sequence<int, Is...>) {
  (f(std::integral_constant<int, first + Is>{}), ...);
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

}  // namespace detail

/// Calls f(0), f(1), …, f(n − 1) with arguments known to the compiler: a loop that it sees through.
///
/// An energy that sums over its bodies with this instead of `for` is evaluated as straight-line code.
template <int n, class F>
[[gnu::always_inline]] inline constexpr void unroll(F&& f) {
  detail::unroll_between<0, n>(f);
}

}  // namespace qdot
