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

/// The value of a function at a plain number; y is the second argument of atan2 and hypot.
inline double value_of(Function f, double x, double y = 0.0) {
  switch (f) {
    case Function::none: return x;
    case Function::sin: return std::sin(x);
    case Function::cos: return std::cos(x);
    case Function::tan: return std::tan(x);
    case Function::asin: return std::asin(x);
    case Function::acos: return std::acos(x);
    case Function::atan: return std::atan(x);
    case Function::atan2: return std::atan2(x, y);
    case Function::hypot: return std::hypot(x, y);
    case Function::exp: return std::exp(x);
    case Function::expm1: return std::expm1(x);
    case Function::log: return std::log(x);
    case Function::log1p: return std::log1p(x);
    case Function::sinh: return std::sinh(x);
    case Function::cosh: return std::cosh(x);
    case Function::tanh: return std::tanh(x);
    case Function::asinh: return std::asinh(x);
    case Function::acosh: return std::acosh(x);
    case Function::atanh: return std::atanh(x);
    case Function::cbrt: return std::cbrt(x);
    case Function::erf: return std::erf(x);
    case Function::erfc: return std::erfc(x);
  }
  return x;
}

}  // namespace qdot::formula
