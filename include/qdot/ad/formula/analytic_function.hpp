#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of <cmath> that have power series, by name.

#include <cmath>
#include <cstdint>

namespace qdot::formula {

/// Where a formula has a value.
enum class Domain : unsigned char { everything, nonzero, nonnegative, positive };

enum class Function : std::uint8_t {
  none, sin, cos, tan, asin, acos, atan, atan2, hypot, exp, expm1, log, log1p, sinh, cosh, tanh, asinh, acosh, atanh, cbrt, erf, erfc
};

/// f(a), or f(a, b), of numbers of any kind that has the function.
template <Function f, class A, class B>
[[gnu::always_inline]] inline auto applied(const A& a, [[maybe_unused]] const B& b) {
  using std::acos, std::acosh, std::asin, std::asinh, std::atan, std::atan2, std::atanh, std::cbrt, std::cos, std::cosh, std::erf,
      std::erfc, std::exp, std::expm1,
      std::hypot, std::log, std::log1p, std::sin, std::sinh, std::tan, std::tanh;
  if constexpr (f == Function::sin) return sin(a);
  else if constexpr (f == Function::cos) return cos(a);
  else if constexpr (f == Function::tan) return tan(a);
  else if constexpr (f == Function::asin) return asin(a);
  else if constexpr (f == Function::acos) return acos(a);
  else if constexpr (f == Function::atan) return atan(a);
  else if constexpr (f == Function::atan2) return atan2(a, b);
  else if constexpr (f == Function::hypot) return hypot(a, b);
  else if constexpr (f == Function::exp) return exp(a);
  else if constexpr (f == Function::expm1) return expm1(a);
  else if constexpr (f == Function::log) return log(a);
  else if constexpr (f == Function::log1p) return log1p(a);
  else if constexpr (f == Function::sinh) return sinh(a);
  else if constexpr (f == Function::cosh) return cosh(a);
  else if constexpr (f == Function::tanh) return tanh(a);
  else if constexpr (f == Function::asinh) return asinh(a);
  else if constexpr (f == Function::acosh) return acosh(a);
  else if constexpr (f == Function::atanh) return atanh(a);
  else if constexpr (f == Function::cbrt) return cbrt(a);
  else if constexpr (f == Function::erf) return erf(a);
  else if constexpr (f == Function::erfc) return erfc(a);
  else static_assert(f == Function::erfc, "a function without a meaning");
}

/// The value of a function, or its bounds over an interval; y is the second argument of atan2 and hypot.
template <class S>
S value_of(Function f, const S& x, const S& y = S(0.0)) {
  using std::acos, std::acosh, std::asin, std::asinh, std::atan, std::atan2, std::atanh, std::cbrt, std::cos, std::cosh, std::erf,
      std::erfc, std::exp, std::expm1,
      std::hypot, std::log, std::log1p, std::sin, std::sinh, std::tan, std::tanh;
  switch (f) {
    case Function::none: return x;
    case Function::sin: return sin(x);
    case Function::cos: return cos(x);
    case Function::tan: return tan(x);
    case Function::asin: return asin(x);
    case Function::acos: return acos(x);
    case Function::atan: return atan(x);
    case Function::atan2: return atan2(x, y);
    case Function::hypot: return hypot(x, y);
    case Function::exp: return exp(x);
    case Function::expm1: return expm1(x);
    case Function::log: return log(x);
    case Function::log1p: return log1p(x);
    case Function::sinh: return sinh(x);
    case Function::cosh: return cosh(x);
    case Function::tanh: return tanh(x);
    case Function::asinh: return asinh(x);
    case Function::acosh: return acosh(x);
    case Function::atanh: return atanh(x);
    case Function::cbrt: return cbrt(x);
    case Function::erf: return erf(x);
    case Function::erfc: return erfc(x);
  }
  return x;
}

}  // namespace qdot::formula
