#pragma once
// SPDX-License-Identifier: MIT
//
// What numbers have in common that write formulas down (ad/formula/recording.hpp) or hash them (ad/formula/hashed.hpp): functions of <cmath> by name, and
// what is made of others.

#include "qdot/ad/formula/analytic_function.hpp"

namespace qdot::formula {

/// Of a number S with arithmetic, max and min, and S::of(f, x), S::of(f, x, y).
template <class S>
struct FormulaNumber {
  friend constexpr S sin(const S& x) { return S::of(Function::sin, x); }
  friend constexpr S cos(const S& x) { return S::of(Function::cos, x); }
  friend constexpr S tan(const S& x) { return S::of(Function::tan, x); }
  friend constexpr S asin(const S& x) { return S::of(Function::asin, x); }
  friend constexpr S acos(const S& x) { return S::of(Function::acos, x); }
  friend constexpr S atan(const S& x) { return S::of(Function::atan, x); }
  friend constexpr S exp(const S& x) { return S::of(Function::exp, x); }
  friend constexpr S expm1(const S& x) { return S::of(Function::expm1, x); }
  friend constexpr S log(const S& x) { return S::of(Function::log, x); }
  friend constexpr S log1p(const S& x) { return S::of(Function::log1p, x); }
  friend constexpr S sinh(const S& x) { return S::of(Function::sinh, x); }
  friend constexpr S cosh(const S& x) { return S::of(Function::cosh, x); }
  friend constexpr S tanh(const S& x) { return S::of(Function::tanh, x); }
  friend constexpr S asinh(const S& x) { return S::of(Function::asinh, x); }
  friend constexpr S acosh(const S& x) { return S::of(Function::acosh, x); }
  friend constexpr S atanh(const S& x) { return S::of(Function::atanh, x); }
  friend constexpr S cbrt(const S& x) { return S::of(Function::cbrt, x); }
  friend constexpr S erf(const S& x) { return S::of(Function::erf, x); }
  friend constexpr S erfc(const S& x) { return S::of(Function::erfc, x); }
  friend constexpr S atan2(const S& y, const S& x) { return S::of(Function::atan2, y, x); }
  friend constexpr S hypot(const S& x, const S& y) { return S::of(Function::hypot, x, y); }
  friend constexpr S hypot(const S& x, const S& y, const S& z) { return hypot(hypot(x, y), z); }
  friend constexpr S fma(const S& x, const S& y, const S& z) { return x * y + z; }
  friend constexpr S fmax(const S& x, const S& y) { return max(x, y); }
  friend constexpr S fmin(const S& x, const S& y) { return min(x, y); }
  friend constexpr S abs2(const S& x) { return x * x; }
  friend constexpr S conj(const S& x) { return x; }
  friend constexpr S real(const S& x) { return x; }
  friend constexpr S imag(const S&) { return 0.0; }

  friend constexpr S operator+(const S& x) { return x; }
  friend constexpr S& operator+=(S& x, const S& y) { return x = x + y; }
  friend constexpr S& operator-=(S& x, const S& y) { return x = x - y; }
  friend constexpr S& operator*=(S& x, const S& y) { return x = x * y; }
  friend constexpr S& operator/=(S& x, const S& y) { return x = x / y; }
};

}  // namespace qdot::formula
