#pragma once
// SPDX-License-Identifier: MIT
//
// Which function has no value where a formula is NaN.
//
// The formula is computed once more with duals of a tag of their own. Their functions throw the first argument that is outside of
// their domain: acos(1 + 2.2e-16), from a cosine that was rounded.

#include <cmath>

#include "qdot/ad/forward/algebraic.hpp"
#include "qdot/ad/forward/transcendental.hpp"

namespace qdot {

namespace detail {

struct Asked {};  // the tag
using AskedNumber = Dual<double, 1, Asked>;

// What is thrown; it never leaves the library.
struct OutsideOfDomain {
  const char *function, *domain;
  double argument;
};

inline const AskedNumber& within(bool domain_holds_it, const AskedNumber& x, const char* function, const char* domain) {
  if (!domain_holds_it && x.value == x.value) throw OutsideOfDomain{function, domain, x.value};
  return x;
}

}  // namespace detail

inline detail::AskedNumber sqrt(const detail::AskedNumber& x) { return sqrt<>(detail::within(x.value >= 0.0, x, "sqrt", "x >= 0")); }
inline detail::AskedNumber log(const detail::AskedNumber& x) { return log<>(detail::within(x.value > 0.0, x, "log", "x > 0")); }
inline detail::AskedNumber log2(const detail::AskedNumber& x) { return log2<>(detail::within(x.value > 0.0, x, "log2", "x > 0")); }
inline detail::AskedNumber log10(const detail::AskedNumber& x) { return log10<>(detail::within(x.value > 0.0, x, "log10", "x > 0")); }
inline detail::AskedNumber log1p(const detail::AskedNumber& x) { return log1p<>(detail::within(x.value > -1.0, x, "log1p", "x > -1")); }
inline detail::AskedNumber asin(const detail::AskedNumber& x) { return asin<>(detail::within(std::abs(x.value) <= 1.0, x, "asin", "-1 <= x <= 1")); }
inline detail::AskedNumber acos(const detail::AskedNumber& x) { return acos<>(detail::within(std::abs(x.value) <= 1.0, x, "acos", "-1 <= x <= 1")); }
inline detail::AskedNumber acosh(const detail::AskedNumber& x) { return acosh<>(detail::within(x.value >= 1.0, x, "acosh", "x >= 1")); }
inline detail::AskedNumber atanh(const detail::AskedNumber& x) { return atanh<>(detail::within(std::abs(x.value) < 1.0, x, "atanh", "-1 < x < 1")); }
inline detail::AskedNumber pow(const detail::AskedNumber& x, double y) {
  return pow<>(detail::within(x.value > 0.0 || y == std::floor(y) || (x.value == 0.0 && y > 0.0), x, "pow with a broken exponent", "x >= 0"), y);
}

}  // namespace qdot
