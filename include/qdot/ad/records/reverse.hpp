#pragma once
// SPDX-License-Identifier: MIT
//
// The functions of <cmath>, and Eigen's traits, for numbers whose operations are written to a tape (ad/records/tape.hpp).

#include <cmath>
#include <type_traits>

#include "qdot/ad/records/tape.hpp"

namespace qdot::detail {

template <class N>
Reverse<N> sin(const Reverse<N>& x) {
  using std::cos, std::sin;
  return x.through(sin(x.value), cos(x.value));
}
template <class N>
Reverse<N> cos(const Reverse<N>& x) {
  using std::cos, std::sin;
  return x.through(cos(x.value), -sin(x.value));
}
template <class N>
Reverse<N> sqrt(const Reverse<N>& x) {
  using std::sqrt;
  const N root = sqrt(x.value);
  return x.through(root, 0.5 / root);
}
template <class N>
Reverse<N> exp(const Reverse<N>& x) {
  using std::exp;
  const N power = exp(x.value);
  return x.through(power, power);
}
template <class N>
Reverse<N> log(const Reverse<N>& x) { return x.through([](const auto& y) { return log(y); }); }
template <class N> Reverse<N> tan(const Reverse<N>& x) { return x.through([](const auto& y) { return tan(y); }); }
template <class N> Reverse<N> asin(const Reverse<N>& x) { return x.through([](const auto& y) { return asin(y); }); }
template <class N> Reverse<N> acos(const Reverse<N>& x) { return x.through([](const auto& y) { return acos(y); }); }
template <class N> Reverse<N> atan(const Reverse<N>& x) { return x.through([](const auto& y) { return atan(y); }); }
template <class N> Reverse<N> sinh(const Reverse<N>& x) { return x.through([](const auto& y) { return sinh(y); }); }
template <class N> Reverse<N> cosh(const Reverse<N>& x) { return x.through([](const auto& y) { return cosh(y); }); }
template <class N> Reverse<N> tanh(const Reverse<N>& x) { return x.through([](const auto& y) { return tanh(y); }); }
template <class N> Reverse<N> asinh(const Reverse<N>& x) { return x.through([](const auto& y) { return asinh(y); }); }
template <class N> Reverse<N> acosh(const Reverse<N>& x) { return x.through([](const auto& y) { return acosh(y); }); }
template <class N> Reverse<N> atanh(const Reverse<N>& x) { return x.through([](const auto& y) { return atanh(y); }); }
template <class N> Reverse<N> cbrt(const Reverse<N>& x) { return x.through([](const auto& y) { return cbrt(y); }); }
template <class N> Reverse<N> exp2(const Reverse<N>& x) { return x.through([](const auto& y) { return exp2(y); }); }
template <class N> Reverse<N> expm1(const Reverse<N>& x) { return x.through([](const auto& y) { return expm1(y); }); }
template <class N> Reverse<N> log2(const Reverse<N>& x) { return x.through([](const auto& y) { return log2(y); }); }
template <class N> Reverse<N> log10(const Reverse<N>& x) { return x.through([](const auto& y) { return log10(y); }); }
template <class N> Reverse<N> log1p(const Reverse<N>& x) { return x.through([](const auto& y) { return log1p(y); }); }
template <class N> Reverse<N> erf(const Reverse<N>& x) { return x.through([](const auto& y) { return erf(y); }); }
template <class N> Reverse<N> erfc(const Reverse<N>& x) { return x.through([](const auto& y) { return erfc(y); }); }
template <class N, class Number>
  requires std::is_arithmetic_v<Number>
Reverse<N> pow(const Reverse<N>& x, Number k) { return x.through([k](const auto& y) { return pow(y, k); }); }
template <class N, class Number>
  requires std::is_arithmetic_v<Number>
Reverse<N> pow(Number base, const Reverse<N>& x) { return x.through([base](const auto& y) { return pow(base, y); }); }
template <class N>
Reverse<N> pow(const Reverse<N>& x, const Reverse<N>& y) {
  using D = Dual<N, 2>;
  const D z = pow(D::variable(x.value, 0), D::variable(y.value, 1));
  return Reverse<N>::both(z.value, x, z.tangent[0], y, z.tangent[1]);
}
template <class A>
inline constexpr bool is_reverse = false;
template <class N>
inline constexpr bool is_reverse<Reverse<N>> = true;
// Two arguments of which at least one is such a number and the other one too, or a plain one.
template <class A, class B>
concept ReverseBeside = (is_reverse<A> && (std::is_same_v<A, B> || std::is_arithmetic_v<B>)) || (is_reverse<B> && std::is_arithmetic_v<A>);
template <class A, class B>
using ReverseOf = std::conditional_t<is_reverse<A>, A, B>;

template <class A, class B>
  requires ReverseBeside<A, B>
auto atan2(const A& a, const B& b) {
  using R = ReverseOf<A, B>;
  const R y(a), x(b);
  using D = Dual<decltype(y.value), 2>;
  const D z = atan2(D::variable(y.value, 0), D::variable(x.value, 1));
  return R::both(z.value, y, z.tangent[0], x, z.tangent[1]);
}
template <class A, class B>
  requires ReverseBeside<A, B>
auto hypot(const A& a, const B& b) {
  using R = ReverseOf<A, B>;
  const R x(a), y(b);
  using D = Dual<decltype(x.value), 2>;
  const D z = hypot(D::variable(x.value, 0), D::variable(y.value, 1));
  return R::both(z.value, x, z.tangent[0], y, z.tangent[1]);
}
// Three arguments of which at least one is such a number.
template <class A, class B, class C>
using ReverseAmong = ReverseOf<A, ReverseOf<B, C>>;
template <class A, class B, class C>
concept ReverseBesideTwo = ReverseBeside<ReverseAmong<A, B, C>, A> && ReverseBeside<ReverseAmong<A, B, C>, B> && ReverseBeside<ReverseAmong<A, B, C>, C>;
template <class A, class B, class C>
  requires ReverseBesideTwo<A, B, C>
auto hypot(const A& x, const B& y, const C& z) { return hypot(hypot(ReverseAmong<A, B, C>(x), ReverseAmong<A, B, C>(y)), ReverseAmong<A, B, C>(z)); }
template <class A, class B, class C>
  requires ReverseBesideTwo<A, B, C>
auto fma(const A& x, const B& y, const C& z) { return ReverseAmong<A, B, C>(x) * ReverseAmong<A, B, C>(y) + ReverseAmong<A, B, C>(z); }
template <class A, class B>
  requires ReverseBeside<A, B>
auto max(const A& a, const B& b) {
  const ReverseOf<A, B> x(a), y(b);
  return x < y ? y : x;
}
template <class A, class B>
  requires ReverseBeside<A, B>
auto min(const A& a, const B& b) {
  const ReverseOf<A, B> x(a), y(b);
  return y < x ? y : x;
}
template <class A, class B>
  requires ReverseBeside<A, B>
auto fmax(const A& a, const B& b) {
  const ReverseOf<A, B> x(a), y(b);
  return isnan(x) ? y : isnan(y) ? x : max(x, y);
}
template <class A, class B>
  requires ReverseBeside<A, B>
auto fmin(const A& a, const B& b) {
  const ReverseOf<A, B> x(a), y(b);
  return isnan(x) ? y : isnan(y) ? x : min(x, y);
}
template <class A, class B>
  requires ReverseBeside<A, B>
auto copysign(const A& a, const B& b) {
  const ReverseOf<A, B> x(a), y(b);
  return signbit(x) == signbit(y) ? x : -x;
}
// Steps: no derivative, but elsewhere another value.
template <class N>
Reverse<N> floor(const Reverse<N>& x) {
  using std::floor;
  Reverse<N>::compared(x, x);
  return Reverse<N>(floor(x.value));
}
template <class N>
Reverse<N> ceil(const Reverse<N>& x) {
  using std::ceil;
  Reverse<N>::compared(x, x);
  return Reverse<N>(ceil(x.value));
}
template <class N>
Reverse<N> abs(const Reverse<N>& x) { return x < Reverse<N>(0.0) ? -x : x; }
template <class N>
Reverse<N> fabs(const Reverse<N>& x) { return abs(x); }
template <class N>
bool isfinite(const Reverse<N>& x) {
  using std::isfinite;
  Reverse<N>::compared(x, x);
  return isfinite(x.value);
}
template <class N>
bool isnan(const Reverse<N>& x) {
  using std::isnan;
  Reverse<N>::compared(x, x);
  return isnan(x.value);
}
template <class N>
bool isinf(const Reverse<N>& x) {
  using std::isinf;
  Reverse<N>::compared(x, x);
  return isinf(x.value);
}
template <class N>
bool signbit(const Reverse<N>& x) {
  using std::signbit;
  Reverse<N>::compared(x, x);
  return signbit(x.value);
}
template <class N>
const Reverse<N>& conj(const Reverse<N>& x) { return x; }
template <class N>
const Reverse<N>& real(const Reverse<N>& x) { return x; }
template <class N>
Reverse<N> imag(const Reverse<N>&) { return Reverse<N>(0.0); }
template <class N>
Reverse<N> abs2(const Reverse<N>& x) { return x * x; }

}  // namespace qdot::detail

template <class N>
struct Eigen::NumTraits<qdot::detail::Reverse<N>> : Eigen::NumTraits<double> {
  using Real = qdot::detail::Reverse<N>;
  using NonInteger = Real;
  using Nested = Real;
  enum { IsInteger = 0, IsSigned = 1, IsComplex = 0, RequireInitialization = !std::is_trivially_default_constructible_v<Real>, ReadCost = 3, AddCost = 20, MulCost = 20 };
};
template <class N, class Number, class Operation>
  requires std::is_arithmetic_v<Number>
struct Eigen::ScalarBinaryOpTraits<qdot::detail::Reverse<N>, Number, Operation> {
  using ReturnType = qdot::detail::Reverse<N>;
};
template <class N, class Number, class Operation>
  requires std::is_arithmetic_v<Number>
struct Eigen::ScalarBinaryOpTraits<Number, qdot::detail::Reverse<N>, Operation> {
  using ReturnType = qdot::detail::Reverse<N>;
};
