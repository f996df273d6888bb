#pragma once
// SPDX-License-Identifier: MIT
//
// The transcendental functions of dual numbers: exponential, circular, hyperbolic, and their
// inverses. One chain rule, f(a + bε) = f(a) + f′(a) b ε, with f′ written above each function in
// the form that loses no digits. Outside of the domain of f there is no f′ either (ad/forward/algebraic.hpp).

#include <cmath>

#include "qdot/ad/forward/algebraic.hpp"

namespace qdot {

// ── exponential and logarithm ──────────────────────────────────────────────────────────────────

/// eˣ;  f′ = eˣ.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> exp(const Dual<S, N, Tag>& x) {
  using std::exp;
  const S f = exp(x.value);
  return detail::chain(f, f, x);
}

/// 2ˣ;  f′ = 2ˣ ln 2.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> exp2(const Dual<S, N, Tag>& x) {
  using std::exp2;
  using std::log;
  const S f = exp2(x.value);
  return detail::chain(f, S(f * log(S(2))), x);
}

/// eˣ − 1, accurate for small x;  f′ = eˣ.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> expm1(const Dual<S, N, Tag>& x) {
  using std::exp;
  using std::expm1;
  return detail::chain(S(expm1(x.value)), S(exp(x.value)), x);
}

/// ln x;  f′ = 1/x.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> log(const Dual<S, N, Tag>& x) {
  using std::log;
  return detail::chain_within(x.value, S(log(x.value)), S(S(1) / x.value), x);
}

/// log₂ x;  f′ = 1/(x ln 2).
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> log2(const Dual<S, N, Tag>& x) {
  using std::log;
  using std::log2;
  return detail::chain_within(x.value, S(log2(x.value)), S(S(1) / (x.value * log(S(2)))), x);
}

/// log₁₀ x;  f′ = 1/(x ln 10).
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> log10(const Dual<S, N, Tag>& x) {
  using std::log;
  using std::log10;
  return detail::chain_within(x.value, S(log10(x.value)), S(S(1) / (x.value * log(S(10)))), x);
}

/// ln(1 + x), accurate for small x;  f′ = 1/(1 + x).
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> log1p(const Dual<S, N, Tag>& x) {
  using std::log1p;
  const S margin = S(1) + x.value;
  return detail::chain_within(margin, S(log1p(x.value)), S(S(1) / margin), x);
}

/// The error function;  f′ = 2/√π e^(−x²).
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> erf(const Dual<S, N, Tag>& x) {
  using std::atan;
  using std::erf;
  using std::exp;
  using std::sqrt;
  const S slope = S(1) / sqrt(atan(S(1)));  // 2/√π = 1/√(atan 1)
  return detail::chain(S(erf(x.value)), S(slope * exp(-x.value * x.value)), x);
}

/// 1 − erf x, accurate for large x;  f′ = −2/√π e^(−x²).
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> erfc(const Dual<S, N, Tag>& x) {
  using std::atan;
  using std::erfc;
  using std::exp;
  using std::sqrt;
  const S slope = S(1) / sqrt(atan(S(1)));
  return detail::chain(S(erfc(x.value)), S(-slope * exp(-x.value * x.value)), x);
}

// ── circular functions ─────────────────────────────────────────────────────────────────────────

/// sin x;  f′ = cos x.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> sin(const Dual<S, N, Tag>& x) {
  using std::cos;
  using std::sin;
  return detail::chain(S(sin(x.value)), S(cos(x.value)), x);
}

/// cos x;  f′ = −sin x.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> cos(const Dual<S, N, Tag>& x) {
  using std::cos;
  using std::sin;
  return detail::chain(S(cos(x.value)), S(-sin(x.value)), x);
}

/// tan x;  f′ = 1 + tan² x.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> tan(const Dual<S, N, Tag>& x) {
  using std::tan;
  const S f = tan(x.value);
  return detail::chain(f, S(S(1) + f * f), x);
}

/// arcsin x;  f′ = 1/√(1 − x²), as (1 − x)(1 + x) to stay accurate near ±1.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> asin(const Dual<S, N, Tag>& x) {
  using std::asin;
  using std::sqrt;
  const S margin = (S(1) - x.value) * (S(1) + x.value);
  return detail::chain_within(margin, S(asin(x.value)), S(S(1) / sqrt(margin)), x);
}

/// arccos x;  f′ = −1/√(1 − x²).
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> acos(const Dual<S, N, Tag>& x) {
  using std::acos;
  using std::sqrt;
  const S margin = (S(1) - x.value) * (S(1) + x.value);
  return detail::chain_within(margin, S(acos(x.value)), S(S(-1) / sqrt(margin)), x);
}

/// arctan x;  f′ = 1/(1 + x²).
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> atan(const Dual<S, N, Tag>& x) {
  using std::atan;
  return detail::chain(S(atan(x.value)), S(S(1) / (S(1) + x.value * x.value)), x);
}

/// The angle of the point (x, y);  ∂/∂y = x/r², ∂/∂x = −y/r², infinite at the origin.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> atan2(const Dual<S, N, Tag>& y, const Dual<S, N, Tag>& x) {
  using std::atan2;
  using std::hypot;
  const S f = atan2(y.value, x.value);
  const S r = hypot(x.value, y.value);
  if constexpr (detail::HasEdges<S>)
    if (r == S(0)) {
      Dual<S, N, Tag> of_y = detail::chain_at_edge(f, S(S(1) / r), y);
      const Dual<S, N, Tag> of_x = detail::chain_at_edge(f, S(S(1) / r), x);
      for (std::size_t i = 0; i < N; ++i) of_y.tangent[i] += of_x.tangent[i];
      return of_y;
    }
  return detail::chain(f, S(x.value / r / r), y, S(-y.value / r / r), x);
}
template <class A, class B>
  requires detail::DualAndNumber<A, B>
constexpr auto atan2(const A& y, const B& x) { return atan2(detail::DualOf<A, B>(y), detail::DualOf<A, B>(x)); }

/// Sine and cosine of one argument, sharing the work.
template <class S>
struct SinCos {
  S sin;
  S cos;
};

/// {sin x, cos x} of a plain number; the compiler merges the two calls.
template <class S>
SinCos<S> sincos(const S& x) {
  using std::cos;
  using std::sin;
  return {S(sin(x)), S(cos(x))};
}

/// {sin x, cos x} of a dual: one sine and one cosine of the value for both derivatives.
template <class S, int N, class Tag>
SinCos<Dual<S, N, Tag>> sincos(const Dual<S, N, Tag>& x) {
  const SinCos<S> at = sincos(x.value);
  return {detail::chain(at.sin, at.cos, x), detail::chain(at.cos, S(-at.sin), x)};
}

// ── hyperbolic functions ───────────────────────────────────────────────────────────────────────

/// sinh x;  f′ = cosh x.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> sinh(const Dual<S, N, Tag>& x) {
  using std::cosh;
  using std::sinh;
  return detail::chain(S(sinh(x.value)), S(cosh(x.value)), x);
}

/// cosh x;  f′ = sinh x.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> cosh(const Dual<S, N, Tag>& x) {
  using std::cosh;
  using std::sinh;
  return detail::chain(S(cosh(x.value)), S(sinh(x.value)), x);
}

namespace detail {

// 1/cosh² x = 4e/(1 + e)² with e = e^(−2|x|): free of the cancellation in 1 − tanh² x and of the overflow in cosh x.
template <class S>
constexpr S sech_squared(const S& x) {
  using std::abs;
  using std::exp;
  const S e = exp(S(S(-2) * abs(x)));
  return S(4) * e / ((S(1) + e) * (S(1) + e));
}
// f′ = −2 tanh x / cosh² x, which keeps its digits near 0.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> sech_squared(const Dual<S, N, Tag>& x) {
  using std::tanh;
  const S f = sech_squared(x.value);
  return chain(f, S(S(-2) * tanh(x.value) * f), x);
}

}  // namespace detail

/// tanh x;  f′ = 1/cosh² x.
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> tanh(const Dual<S, N, Tag>& x) {
  using detail::sech_squared;
  using std::tanh;
  return detail::chain(S(tanh(x.value)), sech_squared(x.value), x);
}

/// arsinh x;  f′ = 1/√(1 + x²).
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> asinh(const Dual<S, N, Tag>& x) {
  using std::asinh;
  using std::hypot;
  return detail::chain(S(asinh(x.value)), S(S(1) / hypot(S(1), x.value)), x);
}

/// arcosh x, x ≥ 1;  f′ = 1/√(x² − 1).
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> acosh(const Dual<S, N, Tag>& x) {
  using std::acosh;
  using std::sqrt;
  const S margin = x.value - S(1);
  return detail::chain_within(margin, S(acosh(x.value)), S(S(1) / sqrt(margin * (x.value + S(1)))), x);
}

/// artanh x, |x| < 1;  f′ = 1/(1 − x²).
template <class S, int N, class Tag>
constexpr Dual<S, N, Tag> atanh(const Dual<S, N, Tag>& x) {
  using std::atanh;
  const S margin = (S(1) - x.value) * (S(1) + x.value);
  return detail::chain_within(margin, S(atanh(x.value)), S(S(1) / margin), x);
}

}  // namespace qdot
