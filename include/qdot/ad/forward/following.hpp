#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of <cmath>, and Eigen's traits, for scalars that follow the dual numbers.
//
// A scalar that is a value with some derivatives has all functions as soon as it has a chain rule,
//
//     through(x, f) ,   through(x, y, f) ,
//
// which takes as many derivatives of f as the scalar wants from duals (ad/dual_math.hpp). So every formula stands in one place only. What
// a scalar has a shorter way to, a sine or a root, it writes down itself, in an overload for that scalar or for a narrower concept.
//
// Functions with a kink or a step compare values. A scalar that must know of it, as a tape does, has a static member compared(x, y).

#include <Eigen/Core>

#include <cmath>
#include <limits>
#include <type_traits>

#include "qdot/ad/dual_math.hpp"

namespace qdot::detail {

// Such scalars specialize follows_duals with true.
template <class T>
inline constexpr bool follows_duals = false;
template <class T>
concept FollowsDuals = follows_duals<T>;

template <FollowsDuals E> E cbrt(const E& u) { return through(u, [](const auto& x) { return cbrt(x); }); }
template <FollowsDuals E> E exp(const E& u) { return through(u, [](const auto& x) { return exp(x); }); }
template <FollowsDuals E> E exp2(const E& u) { return through(u, [](const auto& x) { return exp2(x); }); }
template <FollowsDuals E> E expm1(const E& u) { return through(u, [](const auto& x) { return expm1(x); }); }
template <FollowsDuals E> E log(const E& u) { return through(u, [](const auto& x) { return log(x); }); }
template <FollowsDuals E> E log2(const E& u) { return through(u, [](const auto& x) { return log2(x); }); }
template <FollowsDuals E> E log10(const E& u) { return through(u, [](const auto& x) { return log10(x); }); }
template <FollowsDuals E> E log1p(const E& u) { return through(u, [](const auto& x) { return log1p(x); }); }
template <FollowsDuals E> E erf(const E& u) { return through(u, [](const auto& x) { return erf(x); }); }
template <FollowsDuals E> E erfc(const E& u) { return through(u, [](const auto& x) { return erfc(x); }); }
template <FollowsDuals E> E tan(const E& u) { return through(u, [](const auto& x) { return tan(x); }); }
template <FollowsDuals E> E asin(const E& u) { return through(u, [](const auto& x) { return asin(x); }); }
template <FollowsDuals E> E acos(const E& u) { return through(u, [](const auto& x) { return acos(x); }); }
template <FollowsDuals E> E atan(const E& u) { return through(u, [](const auto& x) { return atan(x); }); }
template <FollowsDuals E> E sinh(const E& u) { return through(u, [](const auto& x) { return sinh(x); }); }
template <FollowsDuals E> E cosh(const E& u) { return through(u, [](const auto& x) { return cosh(x); }); }
template <FollowsDuals E> E tanh(const E& u) { return through(u, [](const auto& x) { return tanh(x); }); }
template <FollowsDuals E> E asinh(const E& u) { return through(u, [](const auto& x) { return asinh(x); }); }
template <FollowsDuals E> E acosh(const E& u) { return through(u, [](const auto& x) { return acosh(x); }); }
template <FollowsDuals E> E atanh(const E& u) { return through(u, [](const auto& x) { return atanh(x); }); }

template <FollowsDuals E, class Number>
  requires std::is_arithmetic_v<Number>
E pow(const E& u, Number k) { return through(u, [k](const auto& x) { return pow(x, k); }); }
template <FollowsDuals E>
E pow(const E& u, const E& w) {
  if constexpr (requires { w.is_constant(); } && std::is_convertible_v<decltype(innermost_value(w.value)), double>)
    if (w.is_constant()) return pow(u, innermost_value(w.value));
  return through(u, w, [](const auto& x, const auto& y) { return pow(x, y); });
}
template <FollowsDuals E, class Number>
  requires std::is_arithmetic_v<Number>
E pow(Number base, const E& u) { return through(u, [base](const auto& x) { return pow(base, x); }); }

template <class A, class B>
using FollowerOf = std::conditional_t<FollowsDuals<A> && std::is_convertible_v<B, A>, A, B>;
// Two arguments of which one is such a scalar and the other one too, or becomes one, such as a number.
template <class A, class B>
concept FollowerBeside = FollowsDuals<FollowerOf<A, B>> && std::is_convertible_v<A, FollowerOf<A, B>>;

template <FollowsDuals A, FollowsDuals B>
  requires(!std::is_same_v<A, B> && FollowerBeside<A, B>)
auto pow(const A& u, const B& w) {
  using E = FollowerOf<A, B>;
  return pow(E(u), E(w));
}

template <class A, class B>
  requires FollowerBeside<A, B>
auto atan2(const A& y, const B& x) {
  using E = FollowerOf<A, B>;
  return through(E(y), E(x), [](const auto& a, const auto& b) { return atan2(a, b); });
}
template <class A, class B>
  requires FollowerBeside<A, B>
auto hypot(const A& x, const B& y) {
  using E = FollowerOf<A, B>;
  return through(E(x), E(y), [](const auto& a, const auto& b) { return hypot(a, b); });
}
// Three arguments of which at least one is such a scalar.
template <class A, class B, class C>
using FollowerAmong = FollowerOf<A, FollowerOf<B, C>>;
template <class A, class B, class C>
concept FollowerBesideTwo = FollowerBeside<FollowerAmong<A, B, C>, A> && FollowerBeside<FollowerAmong<A, B, C>, B> && FollowerBeside<FollowerAmong<A, B, C>, C>;
template <class A, class B, class C>
  requires FollowerBesideTwo<A, B, C>
auto hypot(const A& x, const B& y, const C& z) {
  using E = FollowerAmong<A, B, C>;
  return hypot(hypot(E(x), E(y)), E(z));
}
template <class A, class B, class C>
  requires FollowerBesideTwo<A, B, C>
auto fma(const A& x, const B& y, const C& z) {
  using E = FollowerAmong<A, B, C>;
  return E(E(x) * E(y) + E(z));
}

// The plain number in x, for a caller that compares it.
template <FollowsDuals E>
double looked_at(const E& x) {
  if constexpr (requires { E::compared(x, x); }) E::compared(x, x);
  return innermost_value(x.value);
}
template <FollowsDuals E>
bool isfinite(const E& x) {
  if constexpr (requires { x.rate; }) return std::isfinite(looked_at(x)) && std::isfinite(innermost_value(x.rate));
  else return std::isfinite(looked_at(x));
}
template <FollowsDuals E>
bool isnan(const E& x) { return std::isnan(looked_at(x)); }
template <FollowsDuals E>
bool isinf(const E& x) { return std::isinf(looked_at(x)); }
template <FollowsDuals E>
bool signbit(const E& x) { return std::signbit(looked_at(x)); }
template <FollowsDuals E>
E abs(const E& x) { return looked_at(x) < 0.0 ? -x : x; }
template <FollowsDuals E>
E fabs(const E& x) { return abs(x); }
template <FollowsDuals E>
E floor(const E& x) { return E(std::floor(looked_at(x))); }
template <FollowsDuals E>
E ceil(const E& x) { return E(std::ceil(looked_at(x))); }
template <class A, class B>
  requires FollowerBeside<A, B>
auto max(const A& x, const B& y) {
  if constexpr (std::is_arithmetic_v<A>) {  // at a tie the one that is no constant
    return max(y, x);
  } else {
    const FollowerOf<A, B> a(x), b(y);
    return a < b ? b : a;
  }
}
template <class A, class B>
  requires FollowerBeside<A, B>
auto min(const A& x, const B& y) {
  if constexpr (std::is_arithmetic_v<A>) {  // at a tie the one that is no constant
    return min(y, x);
  } else {
    const FollowerOf<A, B> a(x), b(y);
    return b < a ? b : a;
  }
}
template <class A, class B>
  requires FollowerBeside<A, B>
auto fmax(const A& x, const B& y) {
  const FollowerOf<A, B> a(x), b(y);
  return isnan(a) ? b : isnan(b) ? a : max(a, b);
}
template <class A, class B>
  requires FollowerBeside<A, B>
auto fmin(const A& x, const B& y) {
  const FollowerOf<A, B> a(x), b(y);
  return isnan(a) ? b : isnan(b) ? a : min(a, b);
}
template <class A, class B>
  requires FollowerBeside<A, B>
auto copysign(const A& x, const B& y) {
  const FollowerOf<A, B> a(x), b(y);
  return signbit(a) == signbit(b) ? a : -a;
}

template <FollowsDuals E>
[[gnu::always_inline]] inline const E& conj(const E& x) { return x; }
template <FollowsDuals E>
[[gnu::always_inline]] inline const E& real(const E& x) { return x; }
template <FollowsDuals E>
E imag(const E&) { return E(0.0); }
template <FollowsDuals E>
[[gnu::always_inline]] inline E abs2(const E& x) { return x * x; }

// Like a real number without SIMD packets; an operation costs as many of those of plain numbers.
template <class E, int read = 1, int addition = 2, int product = 4, bool initialized = true>
struct RealTraits : Eigen::NumTraits<double> {
  using Real = E;
  using NonInteger = E;
  using Nested = E;
  enum { IsInteger = 0, IsSigned = 1, IsComplex = 0, RequireInitialization = initialized, ReadCost = read, AddCost = addition, MulCost = product };
};

}  // namespace qdot::detail

template <qdot::detail::FollowsDuals E>
struct std::numeric_limits<E> : std::numeric_limits<double> {};

template <qdot::detail::FollowsDuals E>
struct Eigen::NumTraits<E> : qdot::detail::RealTraits<E> {};

template <class A, class B, class Operation>
  requires(!std::is_same_v<A, B>) && qdot::detail::FollowerBeside<A, B>
struct Eigen::ScalarBinaryOpTraits<A, B, Operation> {
  using ReturnType = qdot::detail::FollowerOf<A, B>;
};
