#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of <cmath> for the scalars of Lagrange's equations.
//
// A function of one argument needs f, f′ and f″. Sine, cosine, root and the like write them out; all others take them
// from the dual numbers, nested once (ad/forward/following.hpp). A function of two arguments is its second-order Taylor polynomial,
//
//     F(a, b) = [F + F_a δa + ½ F_aa δa²] + [F_b δb + ½ F_bb δb²] + F_ab δa δb ,
//
// two chain rules and one product of values zero.

#include <cmath>
#include <cstddef>
#include <limits>
#include <type_traits>

#include "qdot/ad/dual_math.hpp"
#include "qdot/ad/forward/following.hpp"
#include "qdot/ad/lagrange/euler_lagrange.hpp"

namespace qdot::detail {

// Clang takes sin and cos for functions with a side effect (errno) and never merges two of the same argument.
#if defined(__clang__) && defined(__GLIBC__)
extern "C" [[gnu::const]] double shared_sine(double) __asm__("sin");
extern "C" [[gnu::const]] double shared_cosine(double) __asm__("cos");
#else
[[gnu::always_inline]] inline double shared_sine(double x) { return std::sin(x); }
[[gnu::always_inline]] inline double shared_cosine(double x) { return std::cos(x); }
#endif

#ifdef __GLIBC__
extern "C" void sine_and_cosine(double x, double* sine, double* cosine) __asm__("sincos");
#else
inline void sine_and_cosine(double x, double* sine, double* cosine) {
  *sine = std::sin(x);
  *cosine = std::cos(x);
}
#endif

template <int n, class Is, class K>
struct is_euler_lagrange<EulerLagrange<n, Is, K>> : std::true_type {};

// f(u), the derivatives of f from duals.
template <EulerLagrangeNumber E, class F>
[[gnu::always_inline]] inline E through(const E& u, const F& f) {
  using Once = Dual<double, 1>;
  using Twice = Dual<Once, 1>;
  const Twice y = f(Twice::variable(Once::variable(u.value, 0), 0));
  return u.chain(y.value.value, y.tangent[0].value, y.tangent[0].tangent[0]);
}

// f(a, b), the derivatives of f from duals.
template <EulerLagrangeNumber E, class F>
[[gnu::always_inline]] inline E through(const E& a, const E& b, const F& f) {
  using Once = Dual<double, 2>;
  using Twice = Dual<Once, 2>;
  E from_a = a.whole();
  E from_b = b.whole();
  from_a.value = 0.0;
  from_b.value = 0.0;
  const Twice y = f(Twice::variable(Once::variable(a.value, 0), 0), Twice::variable(Once::variable(b.value, 1), 1));
  return a.chain(y.value.value, y.tangent[0].value, y.tangent[0].tangent[0]) +
         b.chain(0.0, y.tangent[1].value, y.tangent[1].tangent[1]) + E(y.tangent[0].tangent[1]) * (from_a * from_b);
}

// Straight-line code leaves it to the compiler to merge equal ones.
template <EulerLagrangeNumber E>
[[gnu::always_inline]] inline E sin(const E& u) {
  const double s = shared_sine(u.value), c = shared_cosine(u.value);
  return u.chain(s, c, -s);
}
template <EulerLagrangeNumber E>
[[gnu::always_inline]] inline E cos(const E& u) {
  const double s = shared_sine(u.value), c = shared_cosine(u.value);
  return u.chain(c, -s, -c);
}
template <EulerLagrangeNumber E>
struct SinCosOf {
  E sin;
  E cos;
};
template <EulerLagrangeNumber E>
[[gnu::always_inline]] inline SinCosOf<E> sincos(const E& u) {
  return {sin(u), cos(u)};
}
template <EulerLagrangeNumber E>
[[gnu::always_inline]] inline E exp(const E& u) {
  const double value = std::exp(u.value);
  return u.chain(value, value, value);
}
template <EulerLagrangeNumber E>
[[gnu::always_inline]] inline E log(const E& u) {
  const double slope = u.value < 0.0 ? std::numeric_limits<double>::quiet_NaN() : 1.0 / u.value;
  return u.chain(std::log(u.value), slope, -slope * slope);
}
template <EulerLagrangeNumber E>
[[gnu::always_inline]] inline E sqrt(const E& u) {
  const double root = std::sqrt(u.value), inverse = 1.0 / root;  // which a quotient by the root shares
  Present half = 0;  // then the root's ½ meets the square's 2, and neither is computed
  if constexpr (requires { u.half; }) half = u.half;
  const double slope = half ? inverse : 0.5 * inverse, curvature = -inverse * (slope * slope);
  if constexpr (requires { u.half; }) return u.chain_of_components(root, slope, curvature);
  else return u.chain(root, slope, curvature);
}

}  // namespace qdot::detail
