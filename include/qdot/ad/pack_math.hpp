#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of <cmath> for packs.
//
// sin, cos, exp, log and sqrt are computed in all lanes at once, each in two steps. The argument is reduced to a short interval,
// exactly enough, and a polynomial does the rest. For the sine (Cody and Waite, 1980)
//
//     x = k π/2 + r ,   |r| ≤ π/4 ,      π/2 = p₁ + p₂ + p₃ ,   p₁ and p₂ of 33 bits,
//
// so that k p₁ and k p₂ are exact and nothing is lost near the multiples of π/2. What r loses by rounding is added to the sine at last, so that
// the polynomials need not wait for it. The polynomials are those of fdlibm (Sun Microsystems, 1993), in pairs of terms, which a processor computes
// at the same time; e^r is Taylor's to r¹³. Errors stay below 1 unit in the last place (tan: 3).
//
// Each has a range: |x| ≤ 10⁵ for sine and cosine, |x| ≤ 700 for eˣ, normal positive numbers for the logarithm. Lanes outside are
// handed to <cmath> one by one. So are all lanes for functions that a mechanical energy rarely holds (atan2, sinh, …).

#include <cmath>
#include <limits>
#include <type_traits>

#include "qdot/ad/pack.hpp"

namespace qdot {

namespace detail {

inline constexpr double circular_range = 1e5;
inline constexpr double exponential_range = 700.0;

template <class P>
inline constexpr bool is_pack = false;
template <int lanes, int width>
inline constexpr bool is_pack<Pack<lanes, width>> = true;

template <class R>
inline constexpr int lanes_of = static_cast<int>(sizeof(R) / sizeof(double));
template <class R>
using BitsOf = Register<Bits, lanes_of<R>>;

// All bits, a NaN, in the lanes where |x| is above the limit or x is NaN; none in the others.
template <class R>
[[gnu::always_inline]] inline BitsOf<R> outside(const R& x, double limit) {
  const R magnitude = as_bits<R>(BitsOf<R>(as_bits<BitsOf<R>>(x) & 0x7fffffffffffffffLL));
  return ~as_bits<BitsOf<R>>(magnitude <= limit);
}
template <class R>
[[gnu::always_inline]] inline R poisoned(const R& x, const BitsOf<R>& bad) {
  return as_bits<R>(BitsOf<R>(as_bits<BitsOf<R>>(x) | bad));
}
// Adding this to |x| < 2⁵¹ rounds x to a whole number, which stands in the last bits of the sum.
inline constexpr double whole_number_shift = 0x1.8p52;

// Sine and cosine by registers; NaN outside of the range. By reference, since a register that is wider than the compiler was told of must not be returned.
template <class R>
[[gnu::always_inline]] inline void find_circular(const R& x, R& sine, R& cosine) {
#if defined(__clang__)
#pragma clang fp contract(off)  // as lines have it of g++ (ad/formula/circular_lines.hpp)
#endif
  using B = BitsOf<R>;
  const R shifted = x * 0x1.45f306dc9c883p-1 + whole_number_shift;  // 2/π
  const R k = shifted - whole_number_shift;
  const B quadrant = __builtin_bit_cast(B, shifted);
  const R above = x - k * 0x1.921fb544p+0;
  const R middle = k * 0x1.0b4611a6p-34;
  const R r = above - middle;
  const R tail = ((above - r) - middle) - k * 0x1.3198a2e037073p-69;  // the angle is r + tail
  const R z = r * r, w = z * z, ww = w * w, half = 0.5 * z, one_less = 1.0 - half;
  const R of_s = ((-1.66666666666666324348e-01 + z * 8.33333333332248946124e-03) +
                  w * (-1.98412698298579493134e-04 + z * 2.75573137070700676789e-06)) +
                 ww * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10);
  const R of_c = ((4.16666666666666019037e-02 + z * -1.38888888888741095749e-03) +
                  w * (2.48015872894767294178e-05 + z * -2.75573143513906633035e-07)) +
                 ww * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11);
  const R s = r + ((tail - half * tail) + (z * r) * of_s);
  const R c = one_less + ((((1.0 - one_less) - half) - r * tail) + w * of_c);
  const B swapped = -(quadrant & 1), S = __builtin_bit_cast(B, s), C = __builtin_bit_cast(B, c);
  const B magnitude = __builtin_bit_cast(B, x) & 0x7fffffffffffffffLL;
  const B bad = ~__builtin_bit_cast(B, __builtin_bit_cast(R, magnitude) <= circular_range);
  sine = __builtin_bit_cast(R, (((swapped & C) | (~swapped & S)) ^ ((quadrant & 2) << 62)) | bad);
  cosine = __builtin_bit_cast(R, (((swapped & S) | (~swapped & C)) ^ (((quadrant + 1) & 2) << 62)) | bad);
}

// eˣ by registers; NaN outside of the range.
template <class R>
[[gnu::always_inline]] inline R exponential(const R& x) {
  const R shifted = x * 0x1.71547652b82fep+0 + whole_number_shift;  // 1/ln 2
  const R k = shifted - whole_number_shift;
  const R r = (x - k * 6.93147180369123816490e-01) - k * 1.90821492927058770002e-10;
  const R end = 1.0 / 40320 + r * (1.0 / 362880 + r * (1.0 / 3628800 + r * (1.0 / 39916800 + r * (1.0 / 479001600 + r * (1.0 / 6227020800.0)))));
  const R q = 1.0 / 2 + r * (1.0 / 6 + r * (1.0 / 24 + r * (1.0 / 120 + r * (1.0 / 720 + r * (1.0 / 5040 + r * end)))));
  const R power = 1.0 + (r + r * r * q);
  using Unsigned = Register<unsigned long long, lanes_of<R>>;  // lanes outside of the range wrap around before they are poisoned
  const Unsigned scaled = as_bits<Unsigned>(power) + (as_bits<Unsigned>(shifted) << 52);
  return poisoned(as_bits<R>(scaled), outside(x, exponential_range));
}

// ln x by registers; NaN unless x is positive and normal.
template <class R>
[[gnu::always_inline]] inline R logarithm(const R& x) {
  using Unsigned = Register<unsigned long long, lanes_of<R>>;
  constexpr unsigned long long one = 0x3ff0000000000000ULL, root_of_half = 0x3fe6a09e00000000ULL;
  const Unsigned shifted = as_bits<Unsigned>(x) + (one - root_of_half);
  // x = 2^k m with √½ ≤ m < √2; a number of up to 52 bits becomes a double below the leading bit of 2⁵².
  const R k = as_bits<R>(Unsigned((shifted >> 52) | 0x4330000000000000ULL)) - (0x1p52 + 1023.0);
  const R m = as_bits<R>(Unsigned((shifted & 0x000fffffffffffffULL) + root_of_half));
  const R f = m - 1.0;
  const R half = 0.5 * f * f;
  const R s = f / (2.0 + f);
  const R z = s * s, w = z * z;
  const R even = w * (3.999999999940941908e-01 + w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01));
  const R odd = z * (6.666666666666735130e-01 + w * (2.857142874366239149e-01 + w * (1.818357216161805012e-01 + w * 1.479819860511658591e-01)));
  const R sum = k * 6.93147180369123816490e-01 - ((half - (s * (half + (even + odd)) + k * 1.90821492927058770002e-10)) - f);
  return poisoned(sum, BitsOf<R>(~(as_bits<BitsOf<R>>(x >= 0x1p-1022) & as_bits<BitsOf<R>>(x <= 0x1.fffffffffffffp1023))));
}

template <class R>
[[gnu::always_inline]] inline R square_root(const R& x) {
#if defined(__AVX512F__)
  if constexpr (lanes_of<R> == 8) {
#if defined(__clang__)
    return __builtin_ia32_sqrtpd512(x, 4);
#else
    return __builtin_ia32_sqrtpd512_mask(x, x, static_cast<char>(-1), 4);
#endif
  }
#endif
#if defined(__AVX__)
  if constexpr (lanes_of<R> == 4) return __builtin_ia32_sqrtpd256(x);
#endif
#if defined(__SSE2__)
  if constexpr (lanes_of<R> == 2) return __builtin_ia32_sqrtpd(x);
#endif
  R r = x;
  for (int i = 0; i < lanes_of<R>; ++i) r[i] = std::sqrt(x[i]);
  return r;
}

// f of every lane, one after the other.
template <class P, class F, class... More>
[[gnu::noinline]] P lane_by_lane(const F& f, const P& x, const More&... more) {
  return P::of([&](int i) { return f(x[i], more[i]...); });
}
// `fast`, with the lanes that are NaN computed by f.
template <class P, class F>
[[gnu::always_inline]] inline P completed(const P& fast, const P& x, const F& f) {
  if (__builtin_expect(!(fast == fast).all(), 0)) {
    const P copy = x;  // x itself need not be in memory
    return select(fast == fast, fast, lane_by_lane(f, copy));
  }
  return fast;
}

}  // namespace detail

template <int lanes, int width>
[[gnu::always_inline]] inline Pack<lanes, width> sqrt(const Pack<lanes, width>& x) {
  return detail::by_register<Pack<lanes, width>>([](const auto& r) { return detail::square_root(r); }, x);
}

namespace detail {

// The fast functions, for callers that check the results: NaN where <cmath> is needed.
template <int lanes, int width>
[[gnu::always_inline]] inline Pack<lanes, width> fast_sin(const Pack<lanes, width>& x) {
  return by_register<Pack<lanes, width>>(
      [](const auto& r) {
        std::remove_cvref_t<decltype(r)> sine, cosine;
        find_circular(r, sine, cosine);
        return sine;
      },
      x);
}
template <int lanes, int width>
[[gnu::always_inline]] inline Pack<lanes, width> fast_cos(const Pack<lanes, width>& x) {
  return by_register<Pack<lanes, width>>(
      [](const auto& r) {
        std::remove_cvref_t<decltype(r)> sine, cosine;
        find_circular(r, sine, cosine);
        return cosine;
      },
      x);
}
template <int lanes, int width>
[[gnu::always_inline]] inline Pack<lanes, width> fast_exp(const Pack<lanes, width>& x) {
  return by_register<Pack<lanes, width>>([](const auto& r) { return exponential(r); }, x);
}
template <int lanes, int width>
[[gnu::always_inline]] inline Pack<lanes, width> fast_log(const Pack<lanes, width>& x) {
  return by_register<Pack<lanes, width>>([](const auto& r) { return logarithm(r); }, x);
}

// xᵏ for small whole k by repeated squaring.
template <class S>
[[gnu::always_inline]] inline S whole_power(const S& x, int k) {
  S result(1.0), square = x;
  for (int left = k < 0 ? -k : k; left > 0; left /= 2) {
    if (left % 2 == 1) result = result * square;
    square = square * square;
  }
  return k < 0 ? S(1.0 / result) : result;
}
// Exponents up to 64 that are whole, or whole and a half, need no logarithm.
[[gnu::always_inline]] inline bool is_multiple_of_half(double k) {
  return -64.0 <= k && k <= 64.0 && 2.0 * k == static_cast<double>(static_cast<int>(2.0 * k));
}

}  // namespace detail

template <int lanes, int width>
inline Pack<lanes, width> sin(const Pack<lanes, width>& x) {
  return detail::completed(detail::fast_sin(x), x, [](double a) { return std::sin(a); });
}
template <int lanes, int width>
inline Pack<lanes, width> cos(const Pack<lanes, width>& x) {
  return detail::completed(detail::fast_cos(x), x, [](double a) { return std::cos(a); });
}
template <int lanes, int width>
inline Pack<lanes, width> tan(const Pack<lanes, width>& x) {
  return detail::completed(Pack<lanes, width>(detail::fast_sin(x) / detail::fast_cos(x)), x, [](double a) { return std::tan(a); });
}
template <int lanes, int width>
inline Pack<lanes, width> exp(const Pack<lanes, width>& x) {
  return detail::completed(detail::fast_exp(x), x, [](double a) { return std::exp(a); });
}
template <int lanes, int width>
inline Pack<lanes, width> log(const Pack<lanes, width>& x) {
  return detail::completed(detail::fast_log(x), x, [](double a) { return std::log(a); });
}

/// xᵏ. Without a logarithm for whole k and multiples of ½ up to 64, otherwise lane by lane.
template <int lanes, int width, class Number>
  requires std::is_arithmetic_v<Number>
inline Pack<lanes, width> pow(const Pack<lanes, width>& x, Number k) {
  const double exponent = static_cast<double>(k);
  if (!detail::is_multiple_of_half(exponent)) return detail::lane_by_lane([exponent](double a) { return std::pow(a, exponent); }, x);
  const int whole = static_cast<int>(std::floor(exponent));
  const Pack<lanes, width> power = detail::whole_power(x, whole);
  return exponent == whole ? power : power * sqrt(x);
}
template <int lanes, int width>
Pack<lanes, width> pow(const Pack<lanes, width>& x, const Pack<lanes, width>& y) {
  return detail::lane_by_lane([](double a, double b) { return std::pow(a, b); }, x, y);
}
template <int lanes, int width>
Pack<lanes, width> pow(double x, const Pack<lanes, width>& y) { return pow(Pack<lanes, width>(x), y); }

template <int lanes, int width>
[[gnu::always_inline]] inline Pack<lanes, width> abs(const Pack<lanes, width>& x) { return select(x < 0.0, -x, x); }
template <int lanes, int width>
[[gnu::always_inline]] inline Pack<lanes, width> max(const Pack<lanes, width>& x, const Pack<lanes, width>& y) {
  return select(x < y, y, x);
}
template <int lanes, int width>
[[gnu::always_inline]] inline Pack<lanes, width> max(const Pack<lanes, width>& x, double y) { return max(x, Pack<lanes, width>(y)); }
template <int lanes, int width>
[[gnu::always_inline]] inline Pack<lanes, width> max(double x, const Pack<lanes, width>& y) { return max(Pack<lanes, width>(x), y); }
template <int lanes, int width>
[[gnu::always_inline]] inline Pack<lanes, width> min(const Pack<lanes, width>& x, const Pack<lanes, width>& y) {
  return select(y < x, y, x);
}
template <int lanes, int width>
[[gnu::always_inline]] inline Pack<lanes, width> min(const Pack<lanes, width>& x, double y) { return min(x, Pack<lanes, width>(y)); }
template <int lanes, int width>
[[gnu::always_inline]] inline Pack<lanes, width> min(double x, const Pack<lanes, width>& y) { return min(Pack<lanes, width>(x), y); }

template <int lanes, int width>
Pack<lanes, width> floor(const Pack<lanes, width>& x) { return detail::lane_by_lane([](double a) { return std::floor(a); }, x); }
template <int lanes, int width>
Pack<lanes, width> ceil(const Pack<lanes, width>& x) { return detail::lane_by_lane([](double a) { return std::ceil(a); }, x); }
template <int lanes, int width>
Pack<lanes, width> cbrt(const Pack<lanes, width>& x) { return detail::lane_by_lane([](double a) { return std::cbrt(a); }, x); }
template <int lanes, int width>
Pack<lanes, width> exp2(const Pack<lanes, width>& x) { return detail::lane_by_lane([](double a) { return std::exp2(a); }, x); }
template <int lanes, int width>
Pack<lanes, width> expm1(const Pack<lanes, width>& x) { return detail::lane_by_lane([](double a) { return std::expm1(a); }, x); }
template <int lanes, int width>
Pack<lanes, width> log2(const Pack<lanes, width>& x) { return detail::lane_by_lane([](double a) { return std::log2(a); }, x); }
template <int lanes, int width>
Pack<lanes, width> log10(const Pack<lanes, width>& x) { return detail::lane_by_lane([](double a) { return std::log10(a); }, x); }
template <int lanes, int width>
Pack<lanes, width> log1p(const Pack<lanes, width>& x) { return detail::lane_by_lane([](double a) { return std::log1p(a); }, x); }
template <int lanes, int width>
Pack<lanes, width> erf(const Pack<lanes, width>& x) { return detail::lane_by_lane([](double a) { return std::erf(a); }, x); }
template <int lanes, int width>
Pack<lanes, width> erfc(const Pack<lanes, width>& x) { return detail::lane_by_lane([](double a) { return std::erfc(a); }, x); }
template <int lanes, int width>
Pack<lanes, width> asin(const Pack<lanes, width>& x) { return detail::lane_by_lane([](double a) { return std::asin(a); }, x); }
template <int lanes, int width>
Pack<lanes, width> acos(const Pack<lanes, width>& x) { return detail::lane_by_lane([](double a) { return std::acos(a); }, x); }
template <int lanes, int width>
Pack<lanes, width> atan(const Pack<lanes, width>& x) { return detail::lane_by_lane([](double a) { return std::atan(a); }, x); }
template <int lanes, int width>
Pack<lanes, width> sinh(const Pack<lanes, width>& x) { return detail::lane_by_lane([](double a) { return std::sinh(a); }, x); }
template <int lanes, int width>
Pack<lanes, width> cosh(const Pack<lanes, width>& x) { return detail::lane_by_lane([](double a) { return std::cosh(a); }, x); }
template <int lanes, int width>
Pack<lanes, width> tanh(const Pack<lanes, width>& x) { return detail::lane_by_lane([](double a) { return std::tanh(a); }, x); }
template <int lanes, int width>
Pack<lanes, width> asinh(const Pack<lanes, width>& x) { return detail::lane_by_lane([](double a) { return std::asinh(a); }, x); }
template <int lanes, int width>
Pack<lanes, width> acosh(const Pack<lanes, width>& x) { return detail::lane_by_lane([](double a) { return std::acosh(a); }, x); }
template <int lanes, int width>
Pack<lanes, width> atanh(const Pack<lanes, width>& x) { return detail::lane_by_lane([](double a) { return std::atanh(a); }, x); }
template <int lanes, int width>
[[gnu::always_inline]] inline Pack<lanes, width> fabs(const Pack<lanes, width>& x) { return abs(x); }

template <int lanes, int width>
PackMask<lanes, width> isnan(const Pack<lanes, width>& x) { return x != x; }
template <int lanes, int width>
PackMask<lanes, width> isfinite(const Pack<lanes, width>& x) { return x - x == 0.0; }
template <int lanes, int width>
PackMask<lanes, width> isinf(const Pack<lanes, width>& x) { return abs(x) == std::numeric_limits<double>::infinity(); }
template <int lanes, int width>
PackMask<lanes, width> signbit(const Pack<lanes, width>& x) {
  return detail::lane_by_lane([](double a) { return std::signbit(a) ? 1.0 : 0.0; }, x) != 0.0;
}

namespace detail {

// A pack among the arguments, of which the others may be plain numbers.
template <class A, class B>
using PackOf = std::conditional_t<is_pack<A>, A, B>;
template <class A, class P>
concept PackOrNumber = std::is_same_v<A, P> || std::is_arithmetic_v<A>;
template <class A, class B, class C = double>
concept PackBeside = is_pack<PackOf<A, PackOf<B, C>>> && PackOrNumber<A, PackOf<A, PackOf<B, C>>> && PackOrNumber<B, PackOf<A, PackOf<B, C>>> &&
                     PackOrNumber<C, PackOf<A, PackOf<B, C>>>;

}  // namespace detail

template <class A, class B>
  requires detail::PackBeside<A, B>
auto atan2(const A& x, const B& y) {
  using P = detail::PackOf<A, B>;
  return detail::lane_by_lane([](double a, double b) { return std::atan2(a, b); }, P(x), P(y));
}
template <class A, class B>
  requires detail::PackBeside<A, B>
auto hypot(const A& x, const B& y) {
  using P = detail::PackOf<A, B>;
  return detail::lane_by_lane([](double a, double b) { return std::hypot(a, b); }, P(x), P(y));
}
template <class A, class B>
  requires detail::PackBeside<A, B>
auto copysign(const A& x, const B& y) {
  using P = detail::PackOf<A, B>;
  return detail::lane_by_lane([](double a, double b) { return std::copysign(a, b); }, P(x), P(y));
}
template <class A, class B>
  requires detail::PackBeside<A, B>
auto fmax(const A& x, const B& y) {
  using P = detail::PackOf<A, B>;
  return detail::lane_by_lane([](double a, double b) { return std::fmax(a, b); }, P(x), P(y));
}
template <class A, class B>
  requires detail::PackBeside<A, B>
auto fmin(const A& x, const B& y) {
  using P = detail::PackOf<A, B>;
  return detail::lane_by_lane([](double a, double b) { return std::fmin(a, b); }, P(x), P(y));
}
template <class A, class B, class C>
  requires detail::PackBeside<A, B, C>
auto hypot(const A& x, const B& y, const C& z) {
  using P = detail::PackOf<A, detail::PackOf<B, C>>;
  return hypot(hypot(P(x), P(y)), P(z));
}
template <class A, class B, class C>
  requires detail::PackBeside<A, B, C>
auto fma(const A& x, const B& y, const C& z) {
  using P = detail::PackOf<A, detail::PackOf<B, C>>;
  return detail::lane_by_lane([](double a, double b, double c) { return std::fma(a, b, c); }, P(x), P(y), P(z));
}

}  // namespace qdot
