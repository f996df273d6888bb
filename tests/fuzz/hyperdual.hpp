#pragma once
// SPDX-License-Identifier: MIT
//
// Hyperdual numbers in quadruple precision: an oracle that shares nothing with the library.
//
//     x = v + a ε₁ + b ε₂ + ab ε₁ε₂ ,      ε₁² = ε₂² = 0
//
// carries one first derivative along each of two directions and the second derivative along both (J. A. Fike, J. J. Alonso, AIAA
// 2011-886). The rule for every function is f(v) + f′ (a ε₁ + b ε₂) + (f′ ab + f″ a b) ε₁ε₂.
//
// How many digits double can have of an answer is asked of the same code: with `rounding` set, each operation errs by a random part of
// it, as double would, and what that does to the answer is the measure of what the library may be off by. Numbers that double cannot hold
// are noted in `out_of_range`, values outside a function's domain in `outside_domain`, a kink that is too near to be told in `at_kink`,
// a root of zero, steep where its argument stands still, in `infinite_slope`.

#include "formula.hpp"
#include "quad.hpp"

namespace fuzz {

/// What the computation met. One for each thread of tests, of which there is one.
struct Circumstances {
  double rounding = 0.0;
  Dice dice{1};
  bool out_of_range = false, outside_domain = false, at_kink = false, infinite_slope = false;
  void clear() { out_of_range = outside_domain = at_kink = infinite_slope = false; }
};
inline Circumstances circumstances;

inline bool is_finite(quad x) { return x - x == 0; }

inline quad rounded(quad x) {
  const quad size = magnitude(x);
  if (size > quad(1e290) || (size > 0 && size < quad(1e-290))) circumstances.out_of_range = true;
  if (circumstances.rounding == 0.0) return x;
  return x + x * quad(circumstances.dice.between(-circumstances.rounding, circumstances.rounding));
}

struct Hyper {
  quad v = 0, a = 0, b = 0, ab = 0;

  Hyper() = default;
  Hyper(double x) : v(x) {}
  Hyper(quad x, quad along_a = 0, quad along_b = 0, quad along_both = 0) : v(x), a(along_a), b(along_b), ab(along_both) {}
};

inline Hyper operator-(const Hyper& x) { return {-x.v, -x.a, -x.b, -x.ab}; }
inline Hyper operator+(const Hyper& x, const Hyper& y) { return {rounded(x.v + y.v), rounded(x.a + y.a), rounded(x.b + y.b), rounded(x.ab + y.ab)}; }
inline Hyper operator-(const Hyper& x, const Hyper& y) { return x + (-y); }
/// A derivative that is zero asks for no factor: what does not depend on a direction stays so where a function has no value.
inline quad times(quad part, quad factor) {
  if (part == 0 && !is_finite(factor)) circumstances.infinite_slope = true;
  return part == 0 ? quad(0) : rounded(part * factor);
}
inline Hyper operator*(const Hyper& x, const Hyper& y) {
  return {rounded(x.v * y.v), times(x.a, y.v) + times(y.a, x.v), times(x.b, y.v) + times(y.b, x.v),
          times(x.ab, y.v) + times(x.a, y.b) + times(x.b, y.a) + times(y.ab, x.v)};
}

/// f(x) from the numbers f, f′ and f″ at x.v.
inline Hyper chain(const Hyper& x, quad f, quad f1, quad f2) {
  if (!is_finite(f)) {  // where a function has no value it has no slope either, whatever the formula of its slope says
    circumstances.outside_domain = true;
    f1 = f2 = f - f;
  }
  f = rounded(f);
  f1 = rounded(f1);
  f2 = rounded(f2);
  return {f, times(x.a, f1), times(x.b, f1), times(x.ab, f1) + times(x.a * x.b, f2)};
}

inline Hyper operator/(const Hyper& x, const Hyper& y) { return x * chain(y, 1 / y.v, -1 / (y.v * y.v), 2 / (y.v * y.v * y.v)); }

inline Hyper sqrt(const Hyper& x) { const quad r = sqrtq(x.v); return chain(x, r, 1 / (2 * r), -1 / (4 * r * x.v)); }
inline Hyper cbrt(const Hyper& x) { const quad r = cbrtq(x.v); return chain(x, r, r / (3 * x.v), -2 * r / (9 * x.v * x.v)); }
inline Hyper exp(const Hyper& x) { const quad e = expq(x.v); return chain(x, e, e, e); }
inline Hyper exp2(const Hyper& x) { const quad e = powq(2, x.v), l = logq(2); return chain(x, e, l * e, l * l * e); }
inline Hyper expm1(const Hyper& x) { const quad e = expq(x.v); return chain(x, expm1q(x.v), e, e); }
inline Hyper log_to_base(const Hyper& x, quad l) { return chain(x, logq(x.v) / l, 1 / (l * x.v), -1 / (l * x.v * x.v)); }
inline Hyper log(const Hyper& x) { return log_to_base(x, 1); }
inline Hyper log2(const Hyper& x) { return log_to_base(x, logq(2)); }
inline Hyper log10(const Hyper& x) { return log_to_base(x, logq(10)); }
inline Hyper log1p(const Hyper& x) { const quad y = 1 + x.v; return chain(x, log1pq(x.v), 1 / y, -1 / (y * y)); }
inline Hyper sin(const Hyper& x) { const quad s = sinq(x.v), c = cosq(x.v); return chain(x, s, c, -s); }
inline Hyper cos(const Hyper& x) { const quad s = sinq(x.v), c = cosq(x.v); return chain(x, c, -s, -c); }
inline Hyper tan(const Hyper& x) { const quad t = tanq(x.v), s = 1 + t * t; return chain(x, t, s, 2 * t * s); }
inline Hyper asin(const Hyper& x) { const quad c = (1 - x.v) * (1 + x.v), r = sqrtq(c); return chain(x, asinq(x.v), 1 / r, x.v / (r * c)); }
inline Hyper acos(const Hyper& x) { const quad c = (1 - x.v) * (1 + x.v), r = sqrtq(c); return chain(x, acosq(x.v), -1 / r, -x.v / (r * c)); }
inline Hyper atan(const Hyper& x) { const quad c = 1 + x.v * x.v; return chain(x, atanq(x.v), 1 / c, -2 * x.v / (c * c)); }
inline Hyper sinh(const Hyper& x) { const quad s = sinhq(x.v), c = coshq(x.v); return chain(x, s, c, s); }
inline Hyper cosh(const Hyper& x) { const quad s = sinhq(x.v), c = coshq(x.v); return chain(x, c, s, c); }
inline Hyper tanh(const Hyper& x) { const quad t = tanhq(x.v), c = coshq(x.v); return chain(x, t, 1 / (c * c), -2 * t / (c * c)); }
inline Hyper asinh(const Hyper& x) { const quad c = 1 + x.v * x.v, r = sqrtq(c); return chain(x, asinhq(x.v), 1 / r, -x.v / (r * c)); }
inline Hyper acosh(const Hyper& x) { const quad c = (x.v - 1) * (x.v + 1), r = sqrtq(c); return chain(x, acoshq(x.v), 1 / r, -x.v / (r * c)); }
inline Hyper atanh(const Hyper& x) { const quad c = (1 - x.v) * (1 + x.v); return chain(x, atanhq(x.v), 1 / c, 2 * x.v / (c * c)); }
inline Hyper erf(const Hyper& x) { const quad d = 2 / sqrtq(acosq(-1)) * expq(-x.v * x.v); return chain(x, erfq(x.v), d, -2 * x.v * d); }
inline Hyper erfc(const Hyper& x) { const quad d = 2 / sqrtq(acosq(-1)) * expq(-x.v * x.v); return chain(x, erfcq(x.v), -d, 2 * x.v * d); }

inline bool cannot_tell(quad x, quad y) { return magnitude(x - y) <= quad(1e-9) * (magnitude(x) + magnitude(y)); }
inline Hyper abs(const Hyper& x) {
  if (magnitude(x.v) < quad(1e-9)) circumstances.at_kink = true;
  return x.v < 0 ? -x : x;
}
inline Hyper fmax(const Hyper& x, const Hyper& y) {
  if (cannot_tell(x.v, y.v)) circumstances.at_kink = true;
  if (!is_finite(x.v) || !is_finite(y.v)) circumstances.at_kink = true;  // which of the two is a matter of taste
  return x.v < y.v ? y : x;
}
inline Hyper fmin(const Hyper& x, const Hyper& y) {
  if (cannot_tell(x.v, y.v)) circumstances.at_kink = true;
  if (!is_finite(x.v) || !is_finite(y.v)) circumstances.at_kink = true;  // which of the two is a matter of taste
  return y.v < x.v ? y : x;
}

inline Hyper pow(const Hyper& x, int k) {
  if (k == 2) return x * x;
  if (k == 3) return x * x * x;
  return chain(x, powq(x.v, k), k * powq(x.v, k - 1), quad(k) * (k - 1) * powq(x.v, k - 2));
}
inline Hyper pow(const Hyper& x, const Hyper& y) {
  if (y.a == 0 && y.b == 0 && y.ab == 0) {
    const quad k = y.v;
    return chain(x, powq(x.v, k), k == 0 ? quad(0) : k * powq(x.v, k - 1), k == 0 || k == 1 ? quad(0) : k * (k - 1) * powq(x.v, k - 2));
  }
  if (!is_finite(powq(x.v, y.v))) circumstances.outside_domain = true;
  return exp(y * log(x));
}
inline Hyper hypot(const Hyper& x, const Hyper& y) {
  // Near the point of the cone its curvatures are differences of numbers of size 1/r.
  if (magnitude(x.v) + magnitude(y.v) < quad(1e-6)) circumstances.at_kink = true;
  return sqrt(x * x + y * y);
}
inline Hyper atan2(const Hyper& y, const Hyper& x) {
  // The angle itself by atan2, its derivatives by those of a quotient.
  Hyper angle = magnitude(x.v) > magnitude(y.v) ? atan(y / x) : -atan(x / y);
  angle.v = rounded(atan2q(y.v, x.v));
  if (magnitude(x.v) + magnitude(y.v) < quad(1e-6)) circumstances.at_kink = true;  // as hypot
  if (x.v < 0 && magnitude(y.v) <= quad(1e-9) * magnitude(x.v)) circumstances.at_kink = true;
  return angle;
}

}  // namespace fuzz
