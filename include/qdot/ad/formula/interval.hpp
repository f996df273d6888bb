#pragma once
// SPDX-License-Identifier: MIT
//
// Interval arithmetic: what a formula can be while its arguments go through a whole range.
//
//     x ∈ [a, b],  y ∈ [c, d]      x + y ∈ [a + c, b + d],     x y ∈ [min, max] of the products of the ends,     sin x ∈ …
//
// An interval is fed to a formula like any other scalar. The bounds hold for every choice of arguments inside, so they
// prove what no number of samples can: that a function has no zero within a step. Dual<Interval, 1> bounds a function
// and its derivative together. Bounds are too wide where an argument occurs more than once (x − x is [a − b, b − a]),
// by an amount that shrinks with the interval: halve it and ask again. Every result is widened by four rounding units
// and the smallest double, which covers arithmetic and the functions of a common <cmath> (errors of up to two units). A
// function with an edge is bounded over the part where it is defined: sqrt of [−1, 4] is [0, 2]. Where there is no such
// part, and around a pole, the bounds are infinite. A comparison that not every choice inside answers alike throws
// Undecided, for a formula with a branch is then not one formula.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>
#include <type_traits>

#include "qdot/error.hpp"

namespace qdot {

/// A comparison of intervals has no answer: some of the numbers inside say yes and some say no.
class Undecided : public Error {
 public:
  Undecided() : Error("a comparison of two intervals must have one answer, but they overlap; take smaller intervals") {}
};

/// All numbers from lower() to upper(), which may be infinite.
class Interval {
 public:
  constexpr Interval() = default;
  template <class Number>
    requires std::is_arithmetic_v<Number>
  constexpr Interval(Number x) : lower_(static_cast<double>(x)), upper_(static_cast<double>(x)) {}

  /// From a to b, in either order; everything when one of them is NaN.
  static constexpr Interval between(double a, double b) {
    Interval x;
    if (!(a == a && b == b)) return everything();
    x.lower_ = std::min(a, b);
    x.upper_ = std::max(a, b);
    return x;
  }
  static constexpr Interval everything() {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    return between(-infinity, infinity);
  }
  /// Between two computed numbers, widened by what their rounding may be.
  static constexpr Interval around(double a, double b) {
    const Interval x = between(a, b);
    return between(below(x.lower_), above(x.upper_));
  }

  constexpr double lower() const noexcept { return lower_; }
  constexpr double upper() const noexcept { return upper_; }
  constexpr double width() const noexcept { return upper_ - lower_; }
  constexpr bool contains(double x) const noexcept { return lower_ <= x && x <= upper_; }
  /// Largest and smallest absolute value.
  constexpr double largest() const noexcept { return std::max(-lower_, upper_); }
  constexpr double smallest() const noexcept { return std::max({0.0, lower_, -upper_}); }

  Interval& operator+=(const Interval& y) { return *this = *this + y; }
  Interval& operator-=(const Interval& y) { return *this = *this - y; }
  Interval& operator*=(const Interval& y) { return *this = *this * y; }
  Interval& operator/=(const Interval& y) { return *this = *this / y; }

  friend constexpr Interval operator+(const Interval& x) { return x; }
  friend constexpr Interval operator-(const Interval& x) { return between(-x.upper_, -x.lower_); }
  friend constexpr Interval operator+(const Interval& x, const Interval& y) { return around(x.lower_ + y.lower_, x.upper_ + y.upper_); }
  friend constexpr Interval operator-(const Interval& x, const Interval& y) { return around(x.lower_ - y.upper_, x.upper_ - y.lower_); }
  // x · x with the same x twice is a square, which is never negative.
  friend constexpr Interval operator*(const Interval& x, const Interval& y) {
    if (&x == &y) return around(x.smallest() * x.smallest(), x.largest() * x.largest());
    const double a = x.lower_ * y.lower_, b = x.lower_ * y.upper_, c = x.upper_ * y.lower_, d = x.upper_ * y.upper_;
    if (!(a == a && b == b && c == c && d == d)) return everything();  // 0 · ∞
    return around(std::min({a, b, c, d}), std::max({a, b, c, d}));
  }
  friend constexpr Interval operator/(const Interval& x, const Interval& y) {
    if (y.contains(0.0)) return everything();
    return x * around(1.0 / y.upper_, 1.0 / y.lower_);
  }

  friend bool operator==(const Interval& x, const Interval& y) {
    if (&x == &y || (x.width() == 0.0 && y.width() == 0.0 && x.lower_ == y.lower_)) return true;
    return x.upper_ < y.lower_ || y.upper_ < x.lower_ ? false : throw Undecided();
  }
  friend bool operator!=(const Interval& x, const Interval& y) { return !(x == y); }
  friend bool operator<(const Interval& x, const Interval& y) {
    if (x.upper_ < y.lower_) return true;
    return x.lower_ >= y.upper_ ? false : throw Undecided();
  }
  friend bool operator>(const Interval& x, const Interval& y) { return y < x; }
  friend bool operator<=(const Interval& x, const Interval& y) { return !(y < x); }
  friend bool operator>=(const Interval& x, const Interval& y) { return !(x < y); }

 private:
  static constexpr double margin = 4 * std::numeric_limits<double>::epsilon();
  static constexpr double largest_double = std::numeric_limits<double>::max(), smallest_double = std::numeric_limits<double>::denorm_min();
  static constexpr double below(double x) {
    if (x > largest_double) return largest_double;
    return x < -largest_double ? x : x - (margin * (x < 0 ? -x : x) + smallest_double);
  }
  static constexpr double above(double x) { return -below(-x); }

  double lower_ = 0.0, upper_ = 0.0;
};

namespace detail {

// f over x for an f that rises on [from, to] and is defined there only.
template <class F>
Interval of_rising(const Interval& x, const F& f, double from = -std::numeric_limits<double>::infinity(),
                   double to = std::numeric_limits<double>::infinity()) {
  if (x.upper() < from || x.lower() > to) return Interval::everything();
  return Interval::around(f(std::max(x.lower(), from)), f(std::min(x.upper(), to)));
}

// True where x may contain one of the points first + k · period.
inline bool meets(const Interval& x, double first, double period) {
  const double a = (x.lower() - first) / period, b = (x.upper() - first) / period;
  const double rounding = 8 * std::numeric_limits<double>::epsilon() * (1.0 + std::max(std::abs(a), std::abs(b)));
  return !(std::ceil(a - rounding) > std::floor(b + rounding));
}

// A function with extrema −1 and 1 at the given points and no others, of period 2π.
template <class F>
Interval of_wave(const Interval& x, const F& f, double lowest, double highest) {
  constexpr double period = 6.283185307179586;
  if (!(x.width() < period)) return Interval::between(-1.0, 1.0);
  const Interval ends = Interval::around(f(x.lower()), f(x.upper()));
  return Interval::between(meets(x, lowest, period) ? -1.0 : std::max(-1.0, ends.lower()), meets(x, highest, period) ? 1.0 : std::min(1.0, ends.upper()));
}

}  // namespace detail

inline Interval sqrt(const Interval& x) { return detail::of_rising(x, [](double a) { return std::sqrt(a); }, 0.0); }
inline Interval cbrt(const Interval& x) { return detail::of_rising(x, [](double a) { return std::cbrt(a); }); }
inline Interval exp(const Interval& x) { return detail::of_rising(x, [](double a) { return std::exp(a); }); }
inline Interval exp2(const Interval& x) { return detail::of_rising(x, [](double a) { return std::exp2(a); }); }
inline Interval expm1(const Interval& x) { return detail::of_rising(x, [](double a) { return std::expm1(a); }); }
inline Interval log(const Interval& x) { return detail::of_rising(x, [](double a) { return std::log(a); }, 0.0); }
inline Interval log2(const Interval& x) { return detail::of_rising(x, [](double a) { return std::log2(a); }, 0.0); }
inline Interval log10(const Interval& x) { return detail::of_rising(x, [](double a) { return std::log10(a); }, 0.0); }
inline Interval log1p(const Interval& x) { return detail::of_rising(x, [](double a) { return std::log1p(a); }, -1.0); }
inline Interval erf(const Interval& x) { return detail::of_rising(x, [](double a) { return std::erf(a); }); }
inline Interval erfc(const Interval& x) { return -detail::of_rising(x, [](double a) { return -std::erfc(a); }); }
inline Interval asin(const Interval& x) { return detail::of_rising(x, [](double a) { return std::asin(a); }, -1.0, 1.0); }
inline Interval acos(const Interval& x) { return -detail::of_rising(x, [](double a) { return -std::acos(a); }, -1.0, 1.0); }
inline Interval atan(const Interval& x) { return detail::of_rising(x, [](double a) { return std::atan(a); }); }
inline Interval sinh(const Interval& x) { return detail::of_rising(x, [](double a) { return std::sinh(a); }); }
inline Interval tanh(const Interval& x) { return detail::of_rising(x, [](double a) { return std::tanh(a); }); }
inline Interval asinh(const Interval& x) { return detail::of_rising(x, [](double a) { return std::asinh(a); }); }
inline Interval acosh(const Interval& x) { return detail::of_rising(x, [](double a) { return std::acosh(a); }, 1.0); }
inline Interval atanh(const Interval& x) { return detail::of_rising(x, [](double a) { return std::atanh(a); }, -1.0, 1.0); }
inline Interval cosh(const Interval& x) { return Interval::around(std::cosh(x.smallest()), std::cosh(x.largest())); }
inline Interval floor(const Interval& x) { return Interval::between(std::floor(x.lower()), std::floor(x.upper())); }
inline Interval ceil(const Interval& x) { return Interval::between(std::ceil(x.lower()), std::ceil(x.upper())); }
inline Interval abs(const Interval& x) { return Interval::between(x.smallest(), x.largest()); }
inline Interval fabs(const Interval& x) { return abs(x); }

inline Interval sin(const Interval& x) {
  constexpr double quarter = 1.5707963267948966;
  return detail::of_wave(x, [](double a) { return std::sin(a); }, -quarter, quarter);
}
inline Interval cos(const Interval& x) {
  constexpr double half = 3.141592653589793;
  return detail::of_wave(x, [](double a) { return std::cos(a); }, half, 0.0);
}
inline Interval tan(const Interval& x) {
  constexpr double half = 3.141592653589793;
  if (!(x.width() < half) || detail::meets(x, 0.5 * half, half)) return Interval::everything();
  return detail::of_rising(x, [](double a) { return std::tan(a); });
}

/// xᵉ; over x ≥ 0 where e is not a whole number.
inline Interval pow(const Interval& x, double e) {
  const auto power = [e](double a) { return std::pow(a, e); };
  if (e == 0.0) return 1.0;
  const bool whole = e == std::floor(e);
  const Interval base = whole ? x : Interval::between(std::max(0.0, x.lower()), std::max(0.0, x.upper()));
  if (!whole && x.upper() < 0.0) return Interval::everything();
  if (e < 0.0 && whole && base.contains(0.0)) return Interval::everything();
  if (whole && std::fmod(e, 2.0) == 0.0) return Interval::around(power(base.smallest()), power(base.largest()));
  return Interval::around(power(base.lower()), power(base.upper()));
}
// Of intervals alone: a number that could become one is not asked here, pow(0.5, 3) is the C library's.
template <std::same_as<Interval> X, std::integral Integer>
Interval pow(const X& x, Integer k) {
  return pow(x, static_cast<double>(k));
}
inline Interval pow(const Interval& x, const Interval& y) { return y.width() == 0.0 ? pow(x, y.lower()) : exp(y * log(x)); }
template <class Number, std::same_as<Interval> Y>
  requires std::is_arithmetic_v<Number>
Interval pow(Number x, const Y& y) {
  return pow(Interval(x), y);
}

inline Interval hypot(const Interval& x, const Interval& y) {
  return Interval::around(std::hypot(x.smallest(), y.smallest()), std::hypot(x.largest(), y.largest()));
}
inline Interval hypot(const Interval& x, const Interval& y, const Interval& z) { return hypot(hypot(x, y), z); }
inline Interval fma(const Interval& x, const Interval& y, const Interval& z) { return x * y + z; }

/// The angle of the points (x, y) of a rectangle: between those of its corners, unless it meets the cut along x ≤ 0.
inline Interval atan2(const Interval& y, const Interval& x) {
  constexpr double half = 3.141592653589794;
  if (y.contains(0.0) && x.lower() <= 0.0) return Interval::between(-half, half);
  const double a = std::atan2(y.lower(), x.lower()), b = std::atan2(y.lower(), x.upper());
  const double c = std::atan2(y.upper(), x.lower()), d = std::atan2(y.upper(), x.upper());
  return Interval::around(std::min({a, b, c, d}), std::max({a, b, c, d}));
}

inline Interval max(const Interval& x, const Interval& y) {
  return Interval::between(std::max(x.lower(), y.lower()), std::max(x.upper(), y.upper()));
}
inline Interval min(const Interval& x, const Interval& y) {
  return Interval::between(std::min(x.lower(), y.lower()), std::min(x.upper(), y.upper()));
}
inline Interval fmax(const Interval& x, const Interval& y) { return max(x, y); }
inline Interval fmin(const Interval& x, const Interval& y) { return min(x, y); }
inline Interval copysign(const Interval& x, const Interval& y) {
  const Interval size = abs(x);
  if (y.lower() > 0.0) return size;
  return y.upper() < 0.0 ? -size : Interval::between(-size.upper(), size.upper());
}

inline bool isfinite(const Interval& x) { return std::isfinite(x.lower()) && std::isfinite(x.upper()); }
inline bool isnan(const Interval&) { return false; }
inline bool isinf(const Interval& x) { return !isfinite(x); }

inline Interval conj(const Interval& x) { return x; }
inline Interval real(const Interval& x) { return x; }
inline Interval imag(const Interval&) { return 0.0; }
inline Interval abs2(const Interval& x) { return x * x; }

}  // namespace qdot

template <>
struct std::numeric_limits<qdot::Interval> : std::numeric_limits<double> {};

template <>
struct Eigen::NumTraits<qdot::Interval> : Eigen::NumTraits<double> {
  using Real = qdot::Interval;
  using NonInteger = Real;
  using Nested = Real;
  enum { IsInteger = 0, IsSigned = 1, IsComplex = 0, RequireInitialization = 1, ReadCost = 2, AddCost = 4, MulCost = 12 };
};

template <class Operation>
struct Eigen::ScalarBinaryOpTraits<qdot::Interval, double, Operation> {
  using ReturnType = qdot::Interval;
};
template <class Operation>
struct Eigen::ScalarBinaryOpTraits<double, qdot::Interval, Operation> {
  using ReturnType = qdot::Interval;
};
