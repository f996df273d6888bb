#pragma once
// SPDX-License-Identifier: MIT
//
// Numbers of formulas that are multiplied out.
//
// Multiplying out asks whether two numbers are equal, for then terms can be added, put into brackets or dropped. Sums that were added up in another
// order differ in their last digits and are meant to be equal. So a Coefficient is a number that is compared up to rounding (are_alike).
//
// A graph of them keeps functions of numbers as functions: sin(1) is not 0.841….

#include "qdot/ad/formula/graph.hpp"

namespace qdot::formula {

struct Coefficient {
  double value = 0.0;

  constexpr Coefficient() = default;
  constexpr Coefficient(double number) : value(number) {}

  friend constexpr Coefficient operator+(const Coefficient& x, const Coefficient& y) { return x.value + y.value; }
  friend constexpr Coefficient operator-(const Coefficient& x, const Coefficient& y) { return x.value - y.value; }
  friend constexpr Coefficient operator*(const Coefficient& x, const Coefficient& y) { return x.value * y.value; }
  friend constexpr Coefficient operator/(const Coefficient& x, const Coefficient& y) { return x.value / y.value; }
  constexpr Coefficient operator-() const { return 0.0 - value; }
  constexpr Coefficient& operator+=(const Coefficient& y) { return *this = *this + y; }
};

/// Whether both are the same number; of coefficients up to rounding.
constexpr bool are_alike(double x, double y) { return x == y; }
constexpr bool are_alike(const Coefficient& x, const Coefficient& y) {
  const double difference = x.value - y.value, size = x.value < 0.0 ? -x.value : x.value;
  return (difference < 0.0 ? -difference : difference) <= 1e-14 * size;
}

// As a graph asks for them; see ad/formula/graph.hpp.
constexpr double decisive(const Coefficient& x) { return x.value; }
constexpr bool is_small_and_whole(double exponent) {
  return exponent >= -64.0 && exponent <= 64.0 && exponent == static_cast<double>(static_cast<int>(exponent));
}
constexpr Coefficient power_of(const Coefficient& x, double exponent) {
  if (!is_small_and_whole(exponent)) return power_of(x.value, exponent);
  double product = 1.0;
  for (int k = static_cast<int>(exponent < 0.0 ? -exponent : exponent); k > 0; --k) product *= x.value;
  return exponent < 0.0 ? 1.0 / product : product;
}
constexpr bool can_be_raised(const Coefficient& x, double exponent) {
  return is_small_and_whole(exponent) ? exponent > 0.0 || x.value != 0.0 : x.value > 0.0;
}
constexpr bool has_known_value(const Coefficient&) { return false; }
inline Coefficient value_of(Function, const Coefficient&, const Coefficient&) { return {}; }  // never asked for

}  // namespace qdot::formula
