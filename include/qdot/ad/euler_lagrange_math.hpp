#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of <cmath>, and Eigen's traits, for the scalars of Lagrange's equations.
//
// A function of one argument needs f, f′ and f″. Sine, cosine, root and the like write them out; all others take them
// from the dual numbers, nested once, so that every formula stands in one place only. A function of two
// arguments is its second-order Taylor polynomial,
//
//     F(a, b) = [F + F_a δa + ½ F_aa δa²] + [F_b δb + ½ F_bb δb²] + F_ab δa δb ,
//
// two chain rules and one product of values zero.

#include <Eigen/Core>

#include <cmath>
#include <limits>
#include <type_traits>

#include "qdot/ad/dual_math.hpp"
#include "qdot/ad/euler_lagrange.hpp"
#include "qdot/ad/graded.hpp"

namespace qdot::detail {

// Clang takes sin and cos for functions with a side effect (errno) and never merges two of the same argument.
#if defined(__clang__) && defined(__GLIBC__)
extern "C" [[gnu::const]] double shared_sine(double) __asm__("sin");
extern "C" [[gnu::const]] double shared_cosine(double) __asm__("cos");
#else
[[gnu::always_inline]] inline double shared_sine(double x) { return std::sin(x); }
[[gnu::always_inline]] inline double shared_cosine(double x) { return std::cos(x); }
#endif

template <class T>
struct is_euler_lagrange : std::false_type {};
template <int n, class Number, class I, class K>
struct is_euler_lagrange<EulerLagrange<n, Number, I, K>> : std::true_type {};
template <int blocks>
struct is_euler_lagrange<Graded<blocks>> : std::true_type {};

template <class T>
concept EulerLagrangeNumber = is_euler_lagrange<T>::value;

// f(u), the derivatives of f from duals.
template <EulerLagrangeNumber E, class F>
[[gnu::always_inline]] inline E through(const E& u, const F& f) {
  using Twice = Dual<Dual<double, 1>, 1>;
  const Twice y = f(Twice::variable(Dual<double, 1>::variable(u.value, 0), 0));
  return u.chain(y.value.value, y.tangent[0].value, y.tangent[0].tangent[0]);
}

// f(a, b), the derivatives of f from duals.
template <EulerLagrangeNumber E, class F>
[[gnu::always_inline]] inline E through(const E& a, const E& b, const F& f) {
  using Once = Dual<double, 2>;
  using Twice = Dual<Once, 2>;
  const Twice y = f(Twice::variable(Once::variable(a.value, 0), 0), Twice::variable(Once::variable(b.value, 1), 1));
  E from_a = a.whole();
  E from_b = b.whole();
  from_a.value = 0.0;
  from_b.value = 0.0;
  return a.chain(y.value.value, y.tangent[0].value, y.tangent[0].tangent[0]) +
         b.chain(0.0, y.tangent[1].value, y.tangent[1].tangent[1]) + E(y.tangent[0].tangent[1]) * (from_a * from_b);
}

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
  const double f = std::exp(u.value);
  return u.chain(f, f, f);
}
template <EulerLagrangeNumber E>
[[gnu::always_inline]] inline E log(const E& u) {
  const double i = 1.0 / u.value;
  return u.chain(std::log(u.value), i, -i * i);
}
template <EulerLagrangeNumber E>
[[gnu::always_inline]] inline E sqrt(const E& u) {
  const double f = std::sqrt(u.value), slope = 0.5 / f;
  return u.chain(f, slope, -0.5 * slope / u.value);
}

template <EulerLagrangeNumber E> E cbrt(const E& u) { return through(u, [](const auto& x) { return cbrt(x); }); }
template <EulerLagrangeNumber E> E exp2(const E& u) { return through(u, [](const auto& x) { return exp2(x); }); }
template <EulerLagrangeNumber E> E expm1(const E& u) { return through(u, [](const auto& x) { return expm1(x); }); }
template <EulerLagrangeNumber E> E log2(const E& u) { return through(u, [](const auto& x) { return log2(x); }); }
template <EulerLagrangeNumber E> E log10(const E& u) { return through(u, [](const auto& x) { return log10(x); }); }
template <EulerLagrangeNumber E> E log1p(const E& u) { return through(u, [](const auto& x) { return log1p(x); }); }
template <EulerLagrangeNumber E> E erf(const E& u) { return through(u, [](const auto& x) { return erf(x); }); }
template <EulerLagrangeNumber E> E erfc(const E& u) { return through(u, [](const auto& x) { return erfc(x); }); }
template <EulerLagrangeNumber E> E tan(const E& u) { return through(u, [](const auto& x) { return tan(x); }); }
template <EulerLagrangeNumber E> E asin(const E& u) { return through(u, [](const auto& x) { return asin(x); }); }
template <EulerLagrangeNumber E> E acos(const E& u) { return through(u, [](const auto& x) { return acos(x); }); }
template <EulerLagrangeNumber E> E atan(const E& u) { return through(u, [](const auto& x) { return atan(x); }); }
template <EulerLagrangeNumber E> E sinh(const E& u) { return through(u, [](const auto& x) { return sinh(x); }); }
template <EulerLagrangeNumber E> E cosh(const E& u) { return through(u, [](const auto& x) { return cosh(x); }); }
template <EulerLagrangeNumber E> E tanh(const E& u) { return through(u, [](const auto& x) { return tanh(x); }); }
template <EulerLagrangeNumber E> E asinh(const E& u) { return through(u, [](const auto& x) { return asinh(x); }); }
template <EulerLagrangeNumber E> E acosh(const E& u) { return through(u, [](const auto& x) { return acosh(x); }); }
template <EulerLagrangeNumber E> E atanh(const E& u) { return through(u, [](const auto& x) { return atanh(x); }); }

template <EulerLagrangeNumber E, class Number>
  requires std::is_arithmetic_v<Number>
E pow(const E& u, Number k) { return through(u, [k](const auto& x) { return pow(x, k); }); }
template <EulerLagrangeNumber E>
E pow(const E& u, const E& w) {
  if (w.is_constant()) return pow(u, w.value);
  return through(u, w, [](const auto& x, const auto& y) { return pow(x, y); });
}
template <EulerLagrangeNumber E, class Number>
  requires std::is_arithmetic_v<Number>
E pow(Number base, const E& u) { return through(u, [base](const auto& x) { return pow(base, x); }); }

template <class A, class B>
using EulerLagrangeOf = std::conditional_t<EulerLagrangeNumber<A>, A, B>;
// Two arguments of which at least one is such a scalar and the other one too, or a number.
template <class A, class B>
concept EulerLagrangeBeside = (EulerLagrangeNumber<A> && (std::is_same_v<A, B> || std::is_arithmetic_v<B>)) ||
                              (EulerLagrangeNumber<B> && std::is_arithmetic_v<A>);

template <class A, class B>
  requires EulerLagrangeBeside<A, B>
auto atan2(const A& y, const B& x) {
  using E = EulerLagrangeOf<A, B>;
  return through(E(y), E(x), [](const auto& a, const auto& b) { return atan2(a, b); });
}
template <class A, class B>
  requires EulerLagrangeBeside<A, B>
auto hypot(const A& x, const B& y) {
  using E = EulerLagrangeOf<A, B>;
  return through(E(x), E(y), [](const auto& a, const auto& b) { return hypot(a, b); });
}
template <EulerLagrangeNumber E>
E hypot(const E& x, const E& y, const E& z) { return hypot(hypot(x, y), z); }
template <EulerLagrangeNumber E>
E fma(const E& x, const E& y, const E& z) { return x * y + z; }
template <EulerLagrangeNumber E>
E abs(const E& x) { return x.value < 0.0 ? -x : x; }
template <EulerLagrangeNumber E>
E fabs(const E& x) { return abs(x); }
template <EulerLagrangeNumber E>
E floor(const E& x) { return E(std::floor(x.value)); }
template <EulerLagrangeNumber E>
E ceil(const E& x) { return E(std::ceil(x.value)); }
template <class A, class B>
  requires EulerLagrangeBeside<A, B>
auto max(const A& x, const B& y) {
  const EulerLagrangeOf<A, B> a(x), b(y);
  return a.value < b.value ? b : a;
}
template <class A, class B>
  requires EulerLagrangeBeside<A, B>
auto min(const A& x, const B& y) {
  const EulerLagrangeOf<A, B> a(x), b(y);
  return b.value < a.value ? b : a;
}
template <class A, class B>
  requires EulerLagrangeBeside<A, B>
auto fmax(const A& x, const B& y) {
  const EulerLagrangeOf<A, B> a(x), b(y);
  return a.value != a.value ? b : b.value != b.value ? a : max(a, b);
}
template <class A, class B>
  requires EulerLagrangeBeside<A, B>
auto fmin(const A& x, const B& y) {
  const EulerLagrangeOf<A, B> a(x), b(y);
  return a.value != a.value ? b : b.value != b.value ? a : min(a, b);
}
template <class A, class B>
  requires EulerLagrangeBeside<A, B>
auto copysign(const A& x, const B& y) {
  const EulerLagrangeOf<A, B> a(x), b(y);
  return std::signbit(a.value) == std::signbit(b.value) ? a : -a;
}
template <EulerLagrangeNumber E>
bool isfinite(const E& x) { return std::isfinite(x.value) && std::isfinite(x.rate); }
template <EulerLagrangeNumber E>
bool isnan(const E& x) { return std::isnan(x.value); }
template <EulerLagrangeNumber E>
bool isinf(const E& x) { return std::isinf(x.value); }
template <EulerLagrangeNumber E>
bool signbit(const E& x) { return std::signbit(x.value); }

template <EulerLagrangeNumber E>
[[gnu::always_inline]] inline const E& conj(const E& x) { return x; }
template <EulerLagrangeNumber E>
[[gnu::always_inline]] inline const E& real(const E& x) { return x; }
template <EulerLagrangeNumber E>
E imag(const E&) { return E(0.0); }
template <EulerLagrangeNumber E>
[[gnu::always_inline]] inline E abs2(const E& x) { return x * x; }

}  // namespace qdot::detail

namespace qdot::detail {

// Like a real number without SIMD packets.
template <class E>
struct RealTraits : Eigen::NumTraits<double> {
  using Real = E;
  using NonInteger = E;
  using Nested = E;
  enum { IsInteger = 0, IsSigned = 1, IsComplex = 0, RequireInitialization = 1, ReadCost = 1, AddCost = 2, MulCost = 4 };
};

}  // namespace qdot::detail

template <int n, class Number, class I, class K>
struct std::numeric_limits<qdot::detail::EulerLagrange<n, Number, I, K>> : std::numeric_limits<double> {};
template <int blocks>
struct std::numeric_limits<qdot::detail::Graded<blocks>> : std::numeric_limits<double> {};

template <int n, class Number, class I, class K>
struct Eigen::NumTraits<qdot::detail::EulerLagrange<n, Number, I, K>>
    : qdot::detail::RealTraits<qdot::detail::EulerLagrange<n, Number, I, K>> {};
template <int blocks>
struct Eigen::NumTraits<qdot::detail::Graded<blocks>> : qdot::detail::RealTraits<qdot::detail::Graded<blocks>> {};

template <int n, class Number, class I, class K, class Constant, class Operation>
  requires std::is_arithmetic_v<Constant>
struct Eigen::ScalarBinaryOpTraits<qdot::detail::EulerLagrange<n, Number, I, K>, Constant, Operation> {
  using ReturnType = qdot::detail::EulerLagrange<n, Number, I, K>;
};
template <int n, class Number, class I, class K, class Constant, class Operation>
  requires std::is_arithmetic_v<Constant>
struct Eigen::ScalarBinaryOpTraits<Constant, qdot::detail::EulerLagrange<n, Number, I, K>, Operation> {
  using ReturnType = qdot::detail::EulerLagrange<n, Number, I, K>;
};
template <int blocks, class Number, class Operation>
  requires std::is_arithmetic_v<Number>
struct Eigen::ScalarBinaryOpTraits<qdot::detail::Graded<blocks>, Number, Operation> {
  using ReturnType = qdot::detail::Graded<blocks>;
};
template <int blocks, class Number, class Operation>
  requires std::is_arithmetic_v<Number>
struct Eigen::ScalarBinaryOpTraits<Number, qdot::detail::Graded<blocks>, Operation> {
  using ReturnType = qdot::detail::Graded<blocks>;
};
