#pragma once
// SPDX-License-Identifier: MIT
//
// The scalar of Lagrange's equations with a pack inside: the equations of several members at once.
//
// Sine, exponential and logarithm are the fast ones, without the look at every argument that tells whether <cmath> is
// needed: where it is, the result is NaN, and who evaluates the equations looks at the accelerations anyway. Functions of
// which ad/pack_math.hpp has no fast form take their derivatives from duals, lane by lane.

#include <limits>
#include <type_traits>
#include <utility>

#include "qdot/ad/lagrange/euler_lagrange_math.hpp"
#include "qdot/ad/pack_math.hpp"

namespace qdot::detail {

// True when the compiler sees that both are the same in every lane.
template <int lanes, int width>
[[gnu::always_inline]] inline Present known_equal(const Pack<lanes, width>& a, const Pack<lanes, width>& b) {
  if constexpr (Pack<lanes, width>::is_register) {
    using B = BitsOf<Register<double, lanes>>;
    const bool equal = !PackMask<lanes, width>(B(as_bits<B>(a.lanes_of_register) ^ as_bits<B>(b.lanes_of_register))).any();
    return __builtin_constant_p(equal) && equal ? 1U : 0U;
  } else {
    return known_equal(a.low, b.low) & known_equal(a.high, b.high);
  }
}

template <class E>
inline constexpr bool holds_packs = false;
template <int n, int lanes, int width, class Is, class K>
inline constexpr bool holds_packs<EulerLagrange<n, Pack<lanes, width>, Is, K>> = true;

template <class E>
concept EulerLagrangePack = EulerLagrangeNumber<E> && holds_packs<E>;

template <EulerLagrangePack E>
[[gnu::always_inline]] inline E sin(const E& u) {
  const auto s = fast_sin(u.value), c = fast_cos(u.value);
  return u.chain(s, c, -s);
}
template <EulerLagrangePack E>
[[gnu::always_inline]] inline E cos(const E& u) {
  const auto s = fast_sin(u.value), c = fast_cos(u.value);
  return u.chain(c, -s, -c);
}
template <EulerLagrangePack E>
[[gnu::always_inline]] inline E tan(const E& u) {
  const auto f = fast_sin(u.value) / fast_cos(u.value), slope = 1.0 + f * f;
  return u.chain(f, slope, 2.0 * f * slope);
}
template <EulerLagrangePack E>
[[gnu::always_inline]] inline E exp(const E& u) {
  const auto f = fast_exp(u.value);
  return u.chain(f, f, f);
}
template <EulerLagrangePack E>
[[gnu::always_inline]] inline E log(const E& u) {
  const auto i = qdot::select(u.value < 0.0, std::numeric_limits<double>::quiet_NaN(), 1.0 / u.value);
  return u.chain(fast_log(u.value), i, -i * i);
}
template <EulerLagrangePack E>
[[gnu::always_inline]] inline E sqrt(const E& u) {
  const auto f = qdot::sqrt(u.value), slope = 0.5 / f;
  return u.chain(f, slope, -2.0 * slope * (slope * slope));
}
template <EulerLagrangePack E>
[[gnu::always_inline]] inline E pow(const E& u, double k) {
  if (k == 0.0) return E(1.0);
  if (k == 1.0) return u;
  if (k == 2.0) return u * u;
  const auto below = qdot::pow(u.value, k - 2.0);
  return u.chain(below * u.value * u.value, k * below * u.value, k * (k - 1.0) * below);
}
template <EulerLagrangePack E>
[[gnu::always_inline]] inline E pow(const E& u, int k) {
  return pow(u, static_cast<double>(k));
}

// f(u), the derivatives of f from duals, lane by lane.
template <EulerLagrangePack E, class F>
inline E through(const E& u, const F& f) {
  using P = std::remove_cvref_t<decltype(u.value)>;
  using Twice = Dual<Dual<double, 1>, 1>;
  double value[P::size], slope[P::size], curvature[P::size];
  for (int i = 0; i < P::size; ++i) {
    const Twice y = f(Twice::variable(Dual<double, 1>::variable(u.value[i], 0), 0));
    value[i] = y.value.value;
    slope[i] = y.tangent[0].value;
    curvature[i] = y.tangent[0].tangent[0];
  }
  return u.chain(P::load(value), P::load(slope), P::load(curvature));
}
template <EulerLagrangePack E, class F>
inline E through(const E& a, const E& b, const F& f) {
  using P = std::remove_cvref_t<decltype(a.value)>;
  using Once = Dual<double, 2>;
  using Twice = Dual<Once, 2>;
  double value[P::size], f_a[P::size], f_b[P::size], f_aa[P::size], f_ab[P::size], f_bb[P::size];
  for (int i = 0; i < P::size; ++i) {
    const Twice y = f(Twice::variable(Once::variable(a.value[i], 0), 0), Twice::variable(Once::variable(b.value[i], 1), 1));
    value[i] = y.value.value;
    f_a[i] = y.tangent[0].value;
    f_b[i] = y.tangent[1].value;
    f_aa[i] = y.tangent[0].tangent[0];
    f_ab[i] = y.tangent[0].tangent[1];
    f_bb[i] = y.tangent[1].tangent[1];
  }
  E from_a = a.whole();
  E from_b = b.whole();
  from_a.value = 0.0;
  from_b.value = 0.0;
  return a.chain(P::load(value), P::load(f_a), P::load(f_aa)) + b.chain(P(0.0), P::load(f_b), P::load(f_bb)) +
         E(P::load(f_ab)) * (from_a * from_b);
}

// a or b, component by component.
template <class Condition, int n, class Number, int... Is, int... K>
[[gnu::always_inline]] inline auto chosen_number(
    const Condition& condition, const EulerLagrange<n, Number, std::integer_sequence<int, Is...>, std::integer_sequence<int, K...>>& a,
    const EulerLagrange<n, Number, std::integer_sequence<int, Is...>, std::integer_sequence<int, K...>>& b) {
  EulerLagrange<n, Number> r(0.0);
  r.value = qdot::select(condition, a.value, b.value);
  r.rate = qdot::select(condition, a.rate, b.rate);
  r.has_rate = a.has_rate | b.has_rate;
  r.g_mask = a.g_mask | b.g_mask;
  r.x_mask = a.x_mask | b.x_mask;
  r.h_mask = a.h_mask | b.h_mask;
  ((r.template g<Is>() = qdot::select(condition, a.template g<Is>(), b.template g<Is>())), ...);
  ((r.template x<Is>() = qdot::select(condition, a.template x<Is>(), b.template x<Is>())), ...);
  ((r.template h<K>() = qdot::select(condition, a.template h<K>(), b.template h<K>())), ...);
  return r;
}

template <class A, class B>
concept EulerLagrangePackBeside = FollowerBeside<A, B> && (holds_packs<A> || holds_packs<B>);

// a in the lanes where the condition holds, b in the others.
template <int lanes, int width, class A, class B>
  requires EulerLagrangePackBeside<A, B>
[[gnu::always_inline]] inline auto select(const PackMask<lanes, width>& condition, const A& a, const B& b) {
  using E = FollowerOf<A, B>;
  return chosen_number(condition, E(a).whole(), E(b).whole());
}
// The same for numbers that are no packs, without losing what is known of their zeros.
template <int n, class Is, class K>
[[gnu::always_inline]] inline auto select(bool condition, const EulerLagrange<n, double, Is, K>& a,
                                          const EulerLagrange<n, double, Is, K>& b) {
  return chosen_number(condition, a.whole(), b.whole());
}

template <EulerLagrangePack E>
[[gnu::always_inline]] inline E abs(const E& x) { return select(x < E(0.0), -x, x); }
template <EulerLagrangePack E>
[[gnu::always_inline]] inline E max(const E& a, const E& b) {  // rather than std::max
  return select(a < b, b, a);
}
template <class A, class B>
  requires EulerLagrangePackBeside<A, B>
[[gnu::always_inline]] inline auto max(const A& x, const B& y) {
  const FollowerOf<A, B> a(x), b(y);
  if constexpr (std::is_arithmetic_v<A>) return select(b < a, a, b);  // at a tie the one that is no constant
  else return select(a < b, b, a);
}
template <EulerLagrangePack E>
[[gnu::always_inline]] inline E min(const E& a, const E& b) {  // rather than std::min
  return select(b < a, b, a);
}
template <class A, class B>
  requires EulerLagrangePackBeside<A, B>
[[gnu::always_inline]] inline auto min(const A& x, const B& y) {
  const FollowerOf<A, B> a(x), b(y);
  if constexpr (std::is_arithmetic_v<A>) return select(a < b, a, b);  // at a tie the one that is no constant
  else return select(b < a, b, a);
}
template <class A, class B>
  requires EulerLagrangePackBeside<A, B>
auto fmax(const A& x, const B& y) {
  const FollowerOf<A, B> a(x), b(y);
  return select(a != a, b, select(b != b, a, max(a, b)));
}
template <class A, class B>
  requires EulerLagrangePackBeside<A, B>
auto fmin(const A& x, const B& y) {
  const FollowerOf<A, B> a(x), b(y);
  return select(a != a, b, select(b != b, a, min(a, b)));
}
template <class A, class B>
  requires EulerLagrangePackBeside<A, B>
auto copysign(const A& x, const B& y) {
  const FollowerOf<A, B> a(x), b(y);
  return select(signbit(a.value) == signbit(b.value), a, -a);
}
template <EulerLagrangePack E>
auto isfinite(const E& x) { return isfinite(x.value); }
template <EulerLagrangePack E>
auto isnan(const E& x) { return isnan(x.value); }
template <EulerLagrangePack E>
auto isinf(const E& x) { return isinf(x.value); }
template <EulerLagrangePack E>
auto signbit(const E& x) { return signbit(x.value); }
template <EulerLagrangePack E>
E floor(const E& x) { return E(qdot::floor(x.value)); }
template <EulerLagrangePack E>
E ceil(const E& x) { return E(qdot::ceil(x.value)); }

}  // namespace qdot::detail
