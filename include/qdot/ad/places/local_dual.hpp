#pragma once
// SPDX-License-Identifier: MIT
//
// Numbers of a function of one variable, or of two: what a value knows of itself on its way through <cmath>, while derivatives along coordinates are carried beside it
// (ad/places/curved_jet.hpp).

#include <type_traits>

#include "qdot/ad/dual.hpp"

namespace qdot::detail {

// A dual number with derivatives along two variables. Like a double it is not initialized.
struct LocalDual {
  using Self = LocalDual;

  double value;
  double along[2];

  LocalDual() = default;
  template <class Constant>
    requires std::is_arithmetic_v<Constant>
  LocalDual(Constant constant) : value(static_cast<double>(constant)), along{0.0, 0.0} {}
  LocalDual(double value_, double first, double second) : value(value_), along{first, second} {}

  // f(x) from f and f′ at x.
  Self through(double f, double slope) const { return Self(f, slope * along[0], slope * along[1]); }

  friend Self operator-(const Self& x) { return x.through(-x.value, -1.0); }
  friend Self operator+(const Self& x, const Self& y) { return Self(x.value + y.value, x.along[0] + y.along[0], x.along[1] + y.along[1]); }
  friend Self operator-(const Self& x, const Self& y) { return Self(x.value - y.value, x.along[0] - y.along[0], x.along[1] - y.along[1]); }
  friend Self operator*(const Self& x, const Self& y) {
    return Self(x.value * y.value, x.along[0] * y.value + y.along[0] * x.value, x.along[1] * y.value + y.along[1] * x.value);
  }
  friend Self operator*(double c, const Self& x) { return x.through(c * x.value, c); }
  friend Self operator/(const Self& x, const Self& y) {
    const double quotient = x.value / y.value, inverse = 1.0 / y.value;
    return Self(quotient, (x.along[0] - quotient * y.along[0]) * inverse, (x.along[1] - quotient * y.along[1]) * inverse);
  }
  friend Self operator/(double c, const Self& y) {
    const double quotient = c / y.value;
    return y.through(quotient, -quotient / y.value);
  }

  friend bool operator==(const Self& x, const Self& y) { return x.value == y.value; }
  friend bool operator!=(const Self& x, const Self& y) { return x.value != y.value; }
  friend bool operator<(const Self& x, const Self& y) { return x.value < y.value; }
  friend bool operator<=(const Self& x, const Self& y) { return x.value <= y.value; }
  friend bool operator>(const Self& x, const Self& y) { return x.value > y.value; }
  friend bool operator>=(const Self& x, const Self& y) { return x.value >= y.value; }
};

// The plain number in it, beside those of duals.
using qdot::innermost_value;
inline const double& innermost_value(const LocalDual& x) { return x.value; }

// f(x) from f and f′, and f(x, y) from f, ∂f/∂x, ∂f/∂y.
inline LocalDual lifted(const LocalDual& x, double f, double slope) { return x.through(f, slope); }
inline LocalDual lifted(const LocalDual& x, const LocalDual& y, double f, double f_x, double f_y) {
  return LocalDual(f, f_x * x.along[0] + f_y * y.along[0], f_x * x.along[1] + f_y * y.along[1]);
}

// The derivatives of F(u, v) by u: once, twice, three times, and those in which v takes part.
struct LocalSlopes {
  double f_u, f_uu, f_uv, f_uuu, f_uuv, f_uvv;
};

}  // namespace qdot::detail
