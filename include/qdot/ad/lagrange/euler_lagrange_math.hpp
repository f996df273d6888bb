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

template <int n, class Number, class Is, class K>
struct is_euler_lagrange<EulerLagrange<n, Number, Is, K>> : std::true_type {};

// f(x) and f(x, y) of the numbers inside, from values and first derivatives: of a plain number its value.
template <class Number>
  requires(!requires(const Number& x) { x.value; })
[[gnu::always_inline]] inline Number lifted(const Number&, const Number& f, const Number&) { return f; }
template <class Number>
  requires(!requires(const Number& x) { x.value; })
[[gnu::always_inline]] inline Number lifted(const Number&, const Number&, const Number& f, const Number&, const Number&) { return f; }

// f(u), the derivatives of f from duals.
template <EulerLagrangeNumber E, class F>
[[gnu::always_inline]] inline E through(const E& u, const F& f) {
  using Once = Dual<double, 1>;
  using Twice = Dual<Once, 1>;
  if constexpr (std::is_same_v<decltype(u.value), double>) {
    const Twice y = f(Twice::variable(Once::variable(u.value, 0), 0));
    return u.chain(y.value.value, y.tangent[0].value, y.tangent[0].tangent[0]);
  } else {
    using Thrice = Dual<Twice, 1>;
    const Thrice y = f(Thrice::variable(Twice::variable(Once::variable(innermost_value(u.value), 0), 0), 0));
    const double f0 = y.value.value.value, f1 = y.tangent[0].value.value, f2 = y.tangent[0].tangent[0].value,
                 f3 = y.tangent[0].tangent[0].tangent[0];
    return u.chain(lifted(u.value, f0, f1), lifted(u.value, f1, f2), lifted(u.value, f2, f3));
  }
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
  if constexpr (std::is_same_v<decltype(a.value), double>) {
    const Twice y = f(Twice::variable(Once::variable(a.value, 0), 0), Twice::variable(Once::variable(b.value, 1), 1));
    return a.chain(y.value.value, y.tangent[0].value, y.tangent[0].tangent[0]) +
           b.chain(0.0, y.tangent[1].value, y.tangent[1].tangent[1]) + E(y.tangent[0].tangent[1]) * (from_a * from_b);
  } else {
    using Thrice = Dual<Twice, 2>;
    const auto variable = [](double at, int i) { return Thrice::variable(Twice::variable(Once::variable(at, i), i), i); };
    const Thrice y = f(variable(innermost_value(a.value), 0), variable(innermost_value(b.value), 1));
    if constexpr (requires { typename E::Record::Slopes; }) {  // whose numbers are local to a node
      const auto slopes = [&](std::size_t i, std::size_t j) {
        return typename E::Record::Slopes{y.tangent[i].value.value,
                                          y.tangent[i].tangent[i].value,
                                          y.tangent[i].tangent[j].value,
                                          y.tangent[i].tangent[i].tangent[i],
                                          y.tangent[i].tangent[i].tangent[j],
                                          y.tangent[i].tangent[j].tangent[j]};
      };
      if (a.meets(b)) return E::function(y.value.value.value, a, slopes(0, 1), b, slopes(1, 0));
    }
    const auto number = [&](const Once& x) { return lifted(a.value, b.value, x.value, x.tangent[0], x.tangent[1]); };
    const Twice &y_a = y.tangent[0], &y_b = y.tangent[1];
    auto nothing = number(Once(0.0));
    return a.chain(number(y.value.value), number(y_a.value), number(y_a.tangent[0])) +
           b.chain(nothing, number(y_b.value), number(y_b.tangent[1])) + E(number(y_a.tangent[1])) * (from_a * from_b);
  }
}

// Straight-line code leaves it to the compiler to merge equal ones.
struct SineAndCosine {
  double sine, cosine;
};
template <EulerLagrangeNumber E>
[[gnu::always_inline]] inline SineAndCosine sine_and_cosine_of(const E& u) {
  const double x = innermost_value(u.value);
  return {shared_sine(x), shared_cosine(x)};
}
template <EulerLagrangeNumber E>
[[gnu::always_inline]] inline E sin(const E& u) {
  const auto [s, c] = sine_and_cosine_of(u);
  const auto S = lifted(u.value, s, c);
  return u.chain(S, lifted(u.value, c, -s), -S);
}
template <EulerLagrangeNumber E>
[[gnu::always_inline]] inline E cos(const E& u) {
  const auto [s, c] = sine_and_cosine_of(u);
  const auto C = lifted(u.value, c, -s);
  return u.chain(C, lifted(u.value, -s, -c), -C);
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
  const double value = std::exp(innermost_value(u.value));
  const auto f = lifted(u.value, value, value);
  return u.chain(f, f, f);
}
template <EulerLagrangeNumber E>
[[gnu::always_inline]] inline E log(const E& u) {
  const double x = innermost_value(u.value), slope = x < 0.0 ? std::numeric_limits<double>::quiet_NaN() : 1.0 / x;
  const auto f1 = lifted(u.value, slope, -slope * slope);
  return u.chain(lifted(u.value, std::log(x), slope), f1, -f1 * f1);
}
template <EulerLagrangeNumber E>
[[gnu::always_inline]] inline E sqrt(const E& u) {
  const double root = std::sqrt(innermost_value(u.value));
  const auto f = lifted(u.value, root, 0.5 / root), i = 1.0 / f;  // which a quotient by the root shares
  Present half = 0;  // then the root's ½ meets the square's 2, and neither is computed
  if constexpr (requires { u.half; }) half = u.half;
  const auto slope = half ? i : 0.5 * i, curvature = -i * (slope * slope);
  if constexpr (requires { u.half; }) return u.chain_of_components(f, slope, curvature);
  else return u.chain(f, slope, curvature);
}

}  // namespace qdot::detail
