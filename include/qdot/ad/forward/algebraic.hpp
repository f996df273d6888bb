#pragma once
// SPDX-License-Identifier: MIT
//
// The algebraic functions of dual numbers: roots, powers, magnitudes, the larger and the smaller.
//
//     f(a + bε) = f(a) + f′(a) b ε        the formula above each function is its f′
//
// They are found by argument-dependent lookup: a model that says `using std::sin;` and then `sin(x)` computes with
// plain numbers and with duals alike. Where f′ is infinite (√0, ∛0, the angle of the origin) or undefined (|x| at 0,
// max at a tie) the value is still right, and the derivative follows these rules:
// - An infinite slope is infinite, unless the tangent it multiplies is zero, which stays zero: a constant has no derivative.
// - |x| and max take the slope of the side that the comparison of values selects. |x| at 0 takes that of x, and max at a tie
//   with a constant that of the other: max(0, x) and max(x, 0) are the same.
// - pow(x, k) and pow(x, 2.0) are differentiable at x = 0, without a logarithm.
// - Where f has no value, it has no slope: ln x of a negative x is NaN, and so is its derivative, although 1/x would be a
//   number. So a force has no value where its potential energy has none.

#include <cmath>
#include <concepts>
#include <limits>
#include <type_traits>

#include "qdot/ad/dual.hpp"

namespace qdot {

namespace detail {

// f(x) + f′(x) x′.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> chain(const S& f, const S& df, const Dual<S, N, Tag>& x) {
  Dual<S, N, Tag> r;
  r.value = f;
  for (std::size_t i = 0; i < N; ++i) r.tangent[i] = df * x.tangent[i];
  return r;
}

// True for the number 0 with nothing behind it: a value of 0 may still have derivatives, as cos′ = −sin has at 0.
template <class S>
constexpr bool is_plain_zero(const S& x) {
  if constexpr (requires { x.is_constant(); }) {
    return x.is_constant() && x == S(0);
  } else if constexpr (DualNumber<S>) {
    bool zero = is_plain_zero(x.value);
    for (const auto& d : x.tangent) zero = zero && is_plain_zero(d);
    return zero;
  } else {
    return x == S(0);
  }
}

// A scalar of which one can ask whether it is 0, and branch.
template <class S>
concept HasEdges = requires(const S& x) {
  { x == x } -> std::same_as<bool>;
};

// One whose numbers are still to come, and which has no sign to be asked for (ad/formula/recording.hpp, hashed.hpp).
template <class S>
concept Symbolic = requires { requires innermost<S>::type::is_recorded; };

// slope · tangent, where a plain zero of the tangent makes nothing of an infinite slope. In duals that holds for each product.
template <class S>
constexpr S edge_product(const S& slope, const S& tangent) {
  if constexpr (DualNumber<S>) {
    S r;
    r.value = edge_product(slope.value, tangent.value);
    for (std::size_t i = 0; i < r.tangent.size(); ++i)
      r.tangent[i] = edge_product(slope.value, tangent.tangent[i]) + edge_product(slope.tangent[i], tangent.value);
    return r;
  } else {
    return is_plain_zero(tangent) ? S(S(0) * tangent) : S(slope * tangent);
  }
}

// chain() for an f whose slope may be infinite at x: 0 · ∞ = 0 for a plain zero.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> chain_at_edge(const S& f, const S& df, const Dual<S, N, Tag>& x) {
  Dual<S, N, Tag> r;
  r.value = f;
  for (std::size_t i = 0; i < N; ++i) r.tangent[i] = edge_product(df, x.tangent[i]);
  return r;
}
// chain() for an f whose slope may be infinite where f = 0.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> chain_from_zero(const S& f, const S& df, const Dual<S, N, Tag>& x) {
  if constexpr (Symbolic<S>) {  // an f that is not constant: the division in df has recorded that f must not be zero
    if (is_plain_zero(f)) return chain_at_edge(f, df, x);
  } else if constexpr (HasEdges<S>) {
    if (f == S(0)) return chain_at_edge(f, df, x);
  }
  return chain(f, df, x);
}
// chain() for an f whose slope may be infinite where `margin` is 0, and that has no value where it is negative.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> chain_within(const S& margin, const S& f, const S& df, const Dual<S, N, Tag>& x) {
  if constexpr (Symbolic<S>) {
    return chain(f, df, x);
  } else if constexpr (!HasEdges<S>) {  // packs
    return chain(f, S(df * select(margin < S(0), std::numeric_limits<double>::quiet_NaN(), 1.0)), x);
  } else {
    if constexpr (!requires { x.value.is_constant(); })
      if (margin == S(0)) return chain_at_edge(f, df, x);
    return chain(f, S(df * (margin < S(0) ? std::numeric_limits<double>::quiet_NaN() : 1.0)), x);
  }
}

// f(x, y): the two partial derivatives.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> chain(const S& f, const S& fx, const Dual<S, N, Tag>& x, const S& fy,
                                const Dual<S, N, Tag>& y) {
  Dual<S, N, Tag> r;
  r.value = f;
  for (std::size_t i = 0; i < N; ++i) r.tangent[i] = fx * x.tangent[i] + fy * y.tangent[i];
  return r;
}

template <class Number, class D>
concept NumberBeside = !std::is_same_v<Number, D> && std::is_convertible_v<Number, D> &&
                       (std::is_arithmetic_v<Number> || DualNumber<Number> ||
                        std::is_same_v<Number, typename innermost<D>::type>);

// True for a number without derivatives, as a constant is.
template <class S>
constexpr bool is_flat(const S& x) {
  if constexpr (DualNumber<S>) {
    bool flat = is_flat(x.value);
    for (const auto& d : x.tangent) flat = flat && is_plain_zero(d);
    return flat;
  } else {
    return true;
  }
}
// Whether x is a constant that ties with y.
template <class D>
constexpr bool gives_way([[maybe_unused]] const D& x, [[maybe_unused]] const D& y) {
  if constexpr (HasEdges<D> && !Symbolic<D>) return x.value == y.value && is_flat(x);
  return false;
}

// xᵏ for an integer k by repeated squaring: no logarithm, right at 0 and for negative x.
template <class S, std::integral Integer>
constexpr S integer_power(S x, Integer k) {
  using U = std::make_unsigned_t<Integer>;
  U left = k < 0 ? static_cast<U>(U(0) - static_cast<U>(k)) : static_cast<U>(k);
  S r(1);
  if (k < 0) x = S(1) / x;  // not 1/xᵏ in the end, whose derivatives would be lost where xᵏ is infinite
  for (; left != 0; left = static_cast<U>(left >> 1)) {
    if (left & 1) r = r * x;
    if (left > 1) x = x * x;
  }
  return r;
}

}  // namespace detail

// ── roots and powers ───────────────────────────────────────────────────────────────────────────

/// √x;  f′ = 1/(2√x).
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> sqrt(const Dual<S, N, Tag>& x) {
  using std::sqrt;
  const S f = sqrt(x.value);
  return detail::chain_from_zero(f, S(S(0.5) / f), x);
}

/// ∛x;  f′ = 1/(3 ∛x²).
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> cbrt(const Dual<S, N, Tag>& x) {
  using std::cbrt;
  const S f = cbrt(x.value);
  return detail::chain_from_zero(f, S(S(1) / (S(3) * f * f)), x);
}

/// xᵏ for an integer k;  f′ = k xᵏ⁻¹, with x⁰ = 1 and 0 derivative everywhere.
template <class S, int N, class Tag, std::integral Integer>
constexpr Dual<S, N, Tag> pow(const Dual<S, N, Tag>& x, Integer k) {
  if (k == 0) return detail::chain(S(1), S(0), x);
  if (k == std::numeric_limits<Integer>::min()) return S(1) / (detail::integer_power(x, -(k + 1)) * x);
  if (k < 0) {  // not by xᵏ⁻¹, which leaves the range of S before xᵏ does
    const S f = detail::integer_power(x.value, k);
    return detail::chain(f, S(S(static_cast<double>(k)) * f / x.value), x);
  }
  const S below = detail::integer_power(x.value, static_cast<Integer>(k - 1));
  return detail::chain(S(below * x.value), S(S(static_cast<double>(k)) * below), x);
}

/// xʸ for a constant y;  f′ = y xʸ⁻¹. Exponents that are whole numbers go the exact way of pow(x, k).
template <class S, int N, class Tag, class Number>
  requires(!std::integral<Number> && detail::NumberBeside<Number, Dual<S, N, Tag>> &&
           std::is_convertible_v<Number, S>)
constexpr Dual<S, N, Tag> pow(const Dual<S, N, Tag>& x, const Number& y) {
  using std::pow;
  if constexpr (std::is_arithmetic_v<Number>) {
    if (y > Number(-1e6) && y < Number(1e6) && y == static_cast<Number>(static_cast<long>(y))) {
      return pow(x, static_cast<long>(y));
    }
    return detail::chain_from_zero(S(pow(x.value, y)), S(y * pow(x.value, y - Number(1))), x);
  } else {
    const S e(y);
    return pow(x, Dual<S, N, Tag>(e));
  }
}

/// xʸ for both variable;  ∂/∂x = y xʸ⁻¹, ∂/∂y = xʸ ln x (taken as 0 where xʸ = 0 and y > 0).
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> pow(const Dual<S, N, Tag>& x, const Dual<S, N, Tag>& y) {
  using std::log;
  using std::pow;
  const S f = pow(x.value, y.value);
  const S fx = detail::is_plain_zero(y.value) ? S(0) : S(y.value * pow(x.value, y.value - S(1)));
  Dual<S, N, Tag> r = detail::chain_from_zero(f, fx, x);
  bool exponent_varies = false;
  for (const S& d : y.tangent) exponent_varies = exponent_varies || !detail::is_plain_zero(d);
  if (exponent_varies) {
    const S fy = x.value == S(0) && y.value > S(0) ? S(0) : S(f * log(x.value));
    for (std::size_t i = 0; i < N; ++i) r.tangent[i] += fy * y.tangent[i];
  }
  return r;
}

/// aˣ for a constant base;  f′ = aˣ ln a.
template <class Number, class S, int N, class Tag>
  requires(detail::NumberBeside<Number, Dual<S, N, Tag>> && std::is_convertible_v<Number, S>)
constexpr Dual<S, N, Tag> pow(const Number& base, const Dual<S, N, Tag>& x) {
  return pow(Dual<S, N, Tag>(S(base)), x);
}

/// √(x² + y²) without overflow;  ∂/∂x = x/r, ∂/∂y = y/r, at the origin 0, where the derivatives of these are infinite.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> hypot(const Dual<S, N, Tag>& x, const Dual<S, N, Tag>& y) {
  using std::hypot;
  const S r = hypot(x.value, y.value);
  if constexpr (detail::HasEdges<S>)
    if (r == S(0)) return sqrt(x * x + y * y);
  return detail::chain(r, S(x.value / r), x, S(y.value / r), y);
}

/// √(x² + y² + z²) without overflow.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> hypot(const Dual<S, N, Tag>& x, const Dual<S, N, Tag>& y, const Dual<S, N, Tag>& z) {
  return hypot(hypot(x, y), z);
}

// ── a x + y, magnitude, larger and smaller ─────────────────────────────────────────────────────

/// x y + z with one rounding of the value.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> fma(const Dual<S, N, Tag>& x, const Dual<S, N, Tag>& y, const Dual<S, N, Tag>& z) {
  using std::fma;
  Dual<S, N, Tag> r = detail::chain(S(fma(x.value, y.value, z.value)), y.value, x, x.value, y);
  for (std::size_t i = 0; i < N; ++i) r.tangent[i] += z.tangent[i];
  return r;
}

/// |x|;  f′ = ±1 as the value's sign, +1 at 0.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> abs(const Dual<S, N, Tag>& x) {
  return x.value < S(0) ? -x : x;
}

/// |x|, the same as abs.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> fabs(const Dual<S, N, Tag>& x) {
  return abs(x);
}

/// |x| with the sign of y; piecewise linear in x, constant in y.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> copysign(const Dual<S, N, Tag>& x, const Dual<S, N, Tag>& y) {
  using std::signbit;
  return signbit(innermost_value(x)) == signbit(innermost_value(y)) ? x : -x;
}

/// The larger of two by value; where they are equal the one that is no constant, or else x.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> max(const Dual<S, N, Tag>& x, const Dual<S, N, Tag>& y) {
  return x.value < y.value || detail::gives_way(x, y) ? y : x;
}

/// The smaller of two by value; where they are equal the one that is no constant, or else x.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> min(const Dual<S, N, Tag>& x, const Dual<S, N, Tag>& y) {
  return y.value < x.value || detail::gives_way(x, y) ? y : x;
}

/// The larger of two, ignoring NaN as <cmath> does.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> fmax(const Dual<S, N, Tag>& x, const Dual<S, N, Tag>& y) {
  return x.value != x.value ? y : y.value != y.value ? x : max(x, y);
}

/// The smaller of two, ignoring NaN as <cmath> does.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> fmin(const Dual<S, N, Tag>& x, const Dual<S, N, Tag>& y) {
  return x.value != x.value ? y : y.value != y.value ? x : min(x, y);
}

/// The largest whole number not above x: piecewise constant, derivative 0.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> floor(const Dual<S, N, Tag>& x) {
  using std::floor;
  return Dual<S, N, Tag>(S(floor(x.value)));
}

/// The smallest whole number not below x: piecewise constant, derivative 0.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> ceil(const Dual<S, N, Tag>& x) {
  using std::ceil;
  return Dual<S, N, Tag>(S(ceil(x.value)));
}

/// True when the value and every derivative are finite.
template <class S, int N, class Tag>
constexpr bool isfinite(const Dual<S, N, Tag>& x) {
  using std::isfinite;
  bool finite = isfinite(x.value);
  for (const S& d : x.tangent) finite = finite && isfinite(d);
  return finite;
}

/// True when the value is NaN.
template <class S, int N, class Tag>
constexpr bool isnan(const Dual<S, N, Tag>& x) {
  using std::isnan;
  return isnan(x.value);
}

/// True when the value is infinite.
template <class S, int N, class Tag>
constexpr bool isinf(const Dual<S, N, Tag>& x) {
  using std::isinf;
  return isinf(x.value);
}

/// True when the value is negative, or −0.
template <class S, int N, class Tag>
constexpr bool signbit(const Dual<S, N, Tag>& x) {
  using std::signbit;
  return signbit(x.value);
}

// ── a plain number among the arguments is a constant ───────────────────────────────────────────

namespace detail {

// A dual and a number beside it; which of them is the dual.
template <class A, class B>
concept DualAndNumber = (DualNumber<A> && NumberBeside<B, A>) || (DualNumber<B> && NumberBeside<A, B>);
template <class A, class B>
using DualOf = std::conditional_t<std::is_same_v<A, B> || NumberBeside<B, A>, A, B>;
// The dual among three arguments.
template <class A, class B, class C>
using DualAmong = DualOf<DualOf<A, B>, C>;
template <class A, class B, class C>
concept DualAndNumbers = !(std::is_same_v<A, B> && std::is_same_v<B, C>) && DualNumber<DualAmong<A, B, C>> &&
                         std::is_convertible_v<A, DualAmong<A, B, C>> && std::is_convertible_v<B, DualAmong<A, B, C>> &&
                         std::is_convertible_v<C, DualAmong<A, B, C>>;

}  // namespace detail

template <class A, class B>
  requires detail::DualAndNumber<A, B>
constexpr auto hypot(const A& x, const B& y) { return hypot(detail::DualOf<A, B>(x), detail::DualOf<A, B>(y)); }
template <class A, class B>
  requires detail::DualAndNumber<A, B>
constexpr auto max(const A& x, const B& y) { return max(detail::DualOf<A, B>(x), detail::DualOf<A, B>(y)); }
template <class A, class B>
  requires detail::DualAndNumber<A, B>
constexpr auto min(const A& x, const B& y) { return min(detail::DualOf<A, B>(x), detail::DualOf<A, B>(y)); }
template <class A, class B>
  requires detail::DualAndNumber<A, B>
constexpr auto fmax(const A& x, const B& y) { return fmax(detail::DualOf<A, B>(x), detail::DualOf<A, B>(y)); }
template <class A, class B>
  requires detail::DualAndNumber<A, B>
constexpr auto fmin(const A& x, const B& y) { return fmin(detail::DualOf<A, B>(x), detail::DualOf<A, B>(y)); }
template <class A, class B>
  requires detail::DualAndNumber<A, B>
constexpr auto copysign(const A& x, const B& y) { return copysign(detail::DualOf<A, B>(x), detail::DualOf<A, B>(y)); }
template <class A, class B, class C>
  requires detail::DualAndNumbers<A, B, C>
constexpr auto hypot(const A& x, const B& y, const C& z) {
  using D = detail::DualAmong<A, B, C>;
  return hypot(D(x), D(y), D(z));
}
template <class A, class B, class C>
  requires detail::DualAndNumbers<A, B, C>
constexpr auto fma(const A& x, const B& y, const C& z) {
  using D = detail::DualAmong<A, B, C>;
  return fma(D(x), D(y), D(z));
}

}  // namespace qdot
