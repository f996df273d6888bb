#pragma once
// SPDX-License-Identifier: MIT
//
// What a functor may return.
//
// Eigen computes late: a sum of vectors is at first an object that refers to them,
//
//     [=](const auto& q) {
//       const auto tip = vector(q[0] - sin(q[2]), q[1] + cos(q[2]));
//       return tip - target;                                            // refers to tip, which ends here
//     }
//
// and no type tells whether what it refers to outlives the functor. So a functor returns numbers: a scalar, or a vector or matrix that
// holds its own. All of the library's calls of functors that may return vectors go through result_of(), whose error message
// explains this.

#include <type_traits>
#include <utility>

#include <Eigen/Core>

namespace qdot::detail {

// A hash of a formula, for which a derivative is a hash of what is differentiated (ad/formula/hashed.hpp).
template <class S>
inline constexpr bool is_hash = requires { requires S::is_hash; };

// Whether f(arguments…) compiles. The standard's is_invocable asks more, and is a dozen types for each question.
template <class F, class... Arguments>
inline constexpr bool is_callable = requires(F&& f, Arguments&&... arguments) { static_cast<F&&>(f)(static_cast<Arguments&&>(arguments)...); };

// No expression of Eigen: a number, a vector or matrix that holds its entries, or something of another library.
template <class Result>
concept HoldsItsNumbers = !std::is_base_of_v<Eigen::EigenBase<Result>, Result> || std::is_base_of_v<Eigen::PlainObjectBase<Result>, Result>;

template <class Result>
consteval bool require_numbers() {
  static_assert(HoldsItsNumbers<std::remove_cvref_t<Result>>,
                "qdot: a functor must return a number, or a vector or matrix that holds its numbers, but this one returns an expression of "
                "Eigen, which refers to vectors that end with the functor: write `return (…).eval();`, or say what it returns, "
                "`-> qdot::Vector<S, 2>`; for one number take `(…).value()` or `.dot()`");
  return true;
}

#if defined(__clang__) && defined(__OPTIMIZE__)
#pragma clang attribute push(__attribute__((always_inline, flatten)), apply_to = function)
#endif

// f(arguments…), which may return nothing.
template <class F, class... Arguments>
constexpr decltype(auto) called(F&& f, Arguments&&... arguments) {
  return f(std::forward<Arguments>(arguments)...);
}

// f(arguments…), which must be numbers.
template <class F, class... Arguments>
constexpr auto result_of(F&& f, Arguments&&... arguments) {
  static_assert(require_numbers<decltype(f(std::forward<Arguments>(arguments)...))>());
  return f(std::forward<Arguments>(arguments)...);
}

#if defined(__clang__) && defined(__OPTIMIZE__)
#pragma clang attribute pop
#endif

}  // namespace qdot::detail
