#pragma once
// SPDX-License-Identifier: MIT
//
// A scalar that carries what Lagrange's equations ask of it, and no more.
//
// Lagrange's equations apply one operator to L. On any quantity f(q, q̇, t) it is
//
//     X_i f = ∂f/∂q_i − D ∂f/∂q̇_i ,      D = q̇·∂/∂q + ∂/∂t   (q̇ held),
//
// and then M q̈ = X L with M = ∂²L/∂q̇∂q̇. X has a product rule and a chain rule of its own,
//
//     X_i(u w) = u X_i w + w X_i u − Du ∂w/∂q̇_i − Dw ∂u/∂q̇_i
//     X_i f(u) = f′ X_i u − f″ Du ∂u/∂q̇_i ,
//
// so ∂f/∂q and D ∂f/∂q̇ need not be carried apart: a value, D, g = ∂/∂q̇, X and the lower triangle of
// H = ∂²/∂q̇∂q̇ are closed under arithmetic. For the velocity ẋ of anything that has a position x(q, t), X ẋ = 0.
//
// Most of these components are zero for most intermediate values: cos q₁ has no g, q̇₁ no X, only products of
// two velocities have an H. Bit masks beside the numbers say which components may be other than zero. In
// straight-line code the compiler knows the masks while it compiles, and what they exclude is never
// computed: neither multiplied nor stored. For that to happen every component is a member with a name of its own (one
// base class each, no array), every operation is inlined, and loops over components are fold expressions.
// Where the masks are not known, in a loop that the compiler keeps as a loop, the results are the same but slow; the
// evaluation (mechanics/equations/straight_line.hpp) notices that and takes another way.

#include <type_traits>
#include <utility>

#include "qdot/ad/unroll.hpp"

namespace qdot::detail {

using ComponentMask = unsigned long long;

constexpr int triangle_row(int k) {
  int i = 0;
  while ((i + 1) * (i + 2) / 2 <= k) ++i;
  return i;
}
constexpr int triangle_column(int k) { return k - triangle_row(k) * (triangle_row(k) + 1) / 2; }

// 1 or 0: whether something may be other than zero. Not bool, so that & and | are arithmetic and not control flow.
using Present = unsigned;

[[gnu::always_inline]] inline constexpr Present has(ComponentMask mask, int i) { return static_cast<Present>((mask >> i) & 1U); }
[[gnu::always_inline]] inline constexpr ComponentMask bit(Present set, int i) { return static_cast<ComponentMask>(set) << i; }

// a b where both may be other than zero.
[[gnu::always_inline]] inline double product_if(Present present, double a, double b) { return present ? a * b : 0.0; }

// a + b, of which either may be known to be zero.
[[gnu::always_inline]] inline double sum_of(Present has_a, double a, Present has_b, double b) {
  return has_a ? (has_b ? a + b : a) : (has_b ? b : 0.0);
}

// a − b, likewise.
[[gnu::always_inline]] inline double difference_of(Present has_a, double a, Present has_b, double b) {
  return has_a ? (has_b ? a - b : a) : (has_b ? -b : 0.0);
}

// Whether all numbers are finite, by their sum, which is not where one of them is not. Of packs for each. A sum begins with −0, the zero that adds
// nothing: 0 + x would have to be computed, for an x that is −0.
template <class Number>
[[gnu::always_inline]] inline auto is_finite(const Number& sum) {
  if constexpr (std::is_same_v<Number, double>) return static_cast<bool>(__builtin_isfinite(sum));
  else return sum - sum == 0.0;
}

// True when the compiler sees that both are the same value, so that their difference is zero.
[[gnu::always_inline]] inline Present known_equal(double a, double b) {
  const bool equal = __builtin_bit_cast(long long, a) == __builtin_bit_cast(long long, b);
  return __builtin_constant_p(equal) && equal ? 1U : 0U;
}

// Whether the compiler does not know a number to be zero.
template <class S>
[[gnu::always_inline]] inline Present may_differ_from_zero(const S& x) { return 1U ^ known_equal(x, S(0.0)); }

// Two numbers in one register, on every machine.
using Pair = double __attribute__((vector_size(16)));

// Numbers that will be read in pairs: a processor that finds a store narrower than the load waits for it.
template <int n>
[[gnu::always_inline]] inline void write_in_pairs(double* to, const double* from) {
  unroll<n / 2>([&](auto k) __attribute__((always_inline)) {
    const Pair pair{from[2 * k], from[2 * k + 1]};
    __builtin_memcpy(to + 2 * k, &pair, sizeof pair);
  });
  if constexpr (n % 2 == 1) to[n - 1] = from[n - 1];
}

enum class Part { velocity, variation, hessian };
template <Part part, int i>
struct Component {
  double number;
};

template <int n, class = std::make_integer_sequence<int, n>, class = std::make_integer_sequence<int, n*(n + 1) / 2>>
struct EulerLagrange;

// The components are those of the doubled value when `half` is set: u u then needs half the additions.
template <int n, int... Is, int... K>
struct EulerLagrange<n, std::integer_sequence<int, Is...>, std::integer_sequence<int, K...>>
    : Component<Part::velocity, Is>..., Component<Part::variation, Is>..., Component<Part::hessian, K>... {
  using Self = EulerLagrange;

  double value;
  double rate;  // D
  ComponentMask g_mask, x_mask, h_mask;
  Present has_rate, half;

  template <int i>
  [[gnu::always_inline]] double& g() { return static_cast<Component<Part::velocity, i>&>(*this).number; }
  template <int i>
  [[gnu::always_inline]] double g() const { return static_cast<const Component<Part::velocity, i>&>(*this).number; }
  template <int i>
  [[gnu::always_inline]] double& x() { return static_cast<Component<Part::variation, i>&>(*this).number; }
  template <int i>
  [[gnu::always_inline]] double x() const { return static_cast<const Component<Part::variation, i>&>(*this).number; }
  template <int k>
  [[gnu::always_inline]] double& h() { return static_cast<Component<Part::hessian, k>&>(*this).number; }
  template <int k>
  [[gnu::always_inline]] double h() const { return static_cast<const Component<Part::hessian, k>&>(*this).number; }

  // Trivial, like double's: an array of these is not initialized in a loop.
  EulerLagrange() = default;

  // A constant.
  template <class Constant>
    requires std::is_arithmetic_v<Constant>
  [[gnu::always_inline]] EulerLagrange(const Constant& constant)
      : value(static_cast<double>(constant)), rate(0.0), g_mask(0), x_mask(0), h_mask(0), has_rate(0), half(0) {
    ((g<Is>() = 0.0), ...);
    ((x<Is>() = 0.0), ...);
    ((h<K>() = 0.0), ...);
  }
  [[gnu::always_inline]] EulerLagrange(const Self& o)
      : value(o.value), rate(o.rate), g_mask(o.g_mask), x_mask(o.x_mask), h_mask(o.h_mask), has_rate(o.has_rate), half(o.half) {
    ((g<Is>() = o.template g<Is>()), ...);
    ((x<Is>() = o.template x<Is>()), ...);
    ((h<K>() = o.template h<K>()), ...);
  }
  [[gnu::always_inline]] Self& operator=(const Self& o) {
    value = o.value;
    rate = o.rate;
    g_mask = o.g_mask;
    x_mask = o.x_mask;
    h_mask = o.h_mask;
    has_rate = o.has_rate;
    half = o.half;
    ((g<Is>() = o.template g<Is>()), ...);
    ((x<Is>() = o.template x<Is>()), ...);
    ((h<K>() = o.template h<K>()), ...);
    return *this;
  }

  // q_i, whose D is q̇_i; q̇_i; and the time.
  template <int i>
  [[gnu::always_inline]] static Self coordinate(double q, double qdot) {
    Self r(q);
    r.rate = qdot;
    r.has_rate = 1;
    r.template x<i>() = 1.0;
    r.x_mask = bit(1, i);
    return r;
  }
  template <int i>
  [[gnu::always_inline]] static Self velocity(double qdot) {
    Self r(qdot);
    r.template g<i>() = 1.0;
    r.g_mask = bit(1, i);
    return r;
  }
  [[gnu::always_inline]] static Self time(double t) {
    Self r(t);
    r.rate = 1.0;
    r.has_rate = 1;
    return r;
  }

  [[gnu::always_inline]] Present is_constant() const {
    return static_cast<Present>((static_cast<ComponentMask>(has_rate) | g_mask | x_mask | h_mask) == 0);
  }

  [[gnu::always_inline]] void scale_components(double c) {
    rate = product_if(has_rate, rate, c);
    ((g<Is>() = product_if(has(g_mask, Is), g<Is>(), c)), ...);
    ((x<Is>() = product_if(has(x_mask, Is), x<Is>(), c)), ...);
    ((h<K>() = product_if(has(h_mask, K), h<K>(), c)), ...);
  }
  // The same number with its components written out in full.
  [[gnu::always_inline]] Self whole() const {
    Self r(*this);
    if (half) {
      r.scale_components(2.0);
      r.half = 0;
    }
    return r;
  }

  [[gnu::always_inline]] friend Self operator+(const Self& a, const Self& b) {
    const Present both = (a.half | a.is_constant()) & (b.half | b.is_constant());
    const double fa = (a.half > both) ? 2.0 : 1.0;
    const double fb = (b.half > both) ? 2.0 : 1.0;
    Self r;
    r.half = both & (a.half | b.half);
    r.value = a.value + b.value;
    r.has_rate = a.has_rate | b.has_rate;
    r.rate = sum_of(a.has_rate, fa * a.rate, b.has_rate, fb * b.rate);
    r.g_mask = a.g_mask | b.g_mask;
    r.x_mask = a.x_mask | b.x_mask;
    r.h_mask = a.h_mask | b.h_mask;
    ((r.template g<Is>() = sum_of(has(a.g_mask, Is), fa * a.template g<Is>(), has(b.g_mask, Is), fb * b.template g<Is>())), ...);
    ((r.template x<Is>() = sum_of(has(a.x_mask, Is), fa * a.template x<Is>(), has(b.x_mask, Is), fb * b.template x<Is>())), ...);
    ((r.template h<K>() = sum_of(has(a.h_mask, K), fa * a.template h<K>(), has(b.h_mask, K), fb * b.template h<K>())), ...);
    return r;
  }
  [[gnu::always_inline]] friend Self operator-(const Self& a) {
    Self r(a);
    r.value = -a.value;
    r.rate = -a.rate;
    ((r.template g<Is>() = -a.template g<Is>()), ...);
    ((r.template x<Is>() = -a.template x<Is>()), ...);
    ((r.template h<K>() = -a.template h<K>()), ...);
    return r;
  }
  [[gnu::always_inline]] friend Self operator+(const Self& a) { return a; }
  [[gnu::always_inline]] friend Self operator-(const Self& a, const Self& b) { return a + (-b); }

  [[gnu::always_inline]] friend Self operator*(const Self& a, const Self& b) {
#ifndef __clang__  // where the test would keep both operands in memory
    if (&a == &b) return a.square();
#endif
    // What the components of each factor are multiplied with, and those of both.
    const double ca = b.value * a.doubled(), cb = a.value * b.doubled();
    const double both = a.doubled() * b.doubled();
    Self r;
    r.half = 0;
    r.value = a.value * b.value;
    r.has_rate = a.has_rate | b.has_rate;
    r.rate = sum_of(a.has_rate, product_if(a.has_rate, a.rate, ca), b.has_rate, product_if(b.has_rate, cb, b.rate));
    r.g_mask = a.g_mask | b.g_mask;
    r.x_mask = 0;
    r.h_mask = 0;
    ((r.template g<Is>() = sum_of(has(b.g_mask, Is), product_if(has(b.g_mask, Is), cb, b.template g<Is>()),
                                  has(a.g_mask, Is), product_if(has(a.g_mask, Is), ca, a.template g<Is>()))), ...);
    (r.template set_variation_of_product<Is>(a, ca, b, cb, both), ...);
    (r.template set_hessian_of_product<K>(a, ca, b, cb, both), ...);
    return r;
  }
  [[gnu::always_inline]] friend Self operator/(const Self& a, const Self& b) {
    const double i = 1.0 / b.value;
    if (b.is_constant()) {
      Self r = a * Self(i);
      r.value = a.value / b.value;
      return r;
    }
    Self r = a * b.chain(i, -i * i, 2.0 * i * i * i);
    r.value = a.value / b.value;
    return r;
  }
  [[gnu::always_inline]] Self& operator+=(const Self& o) { return *this = *this + o; }
  [[gnu::always_inline]] Self& operator-=(const Self& o) { return *this = *this - o; }
  [[gnu::always_inline]] Self& operator*=(const Self& o) { return *this = *this * o; }
  [[gnu::always_inline]] Self& operator/=(const Self& o) { return *this = *this / o; }

  friend auto operator==(const Self& a, const Self& b) { return a.value == b.value; }
  friend auto operator!=(const Self& a, const Self& b) { return a.value != b.value; }
  friend auto operator<(const Self& a, const Self& b) { return a.value < b.value; }
  friend auto operator<=(const Self& a, const Self& b) { return a.value <= b.value; }
  friend auto operator>(const Self& a, const Self& b) { return a.value > b.value; }
  friend auto operator>=(const Self& a, const Self& b) { return a.value >= b.value; }

  // f(u) from f, f′, f″ at u.
  [[gnu::always_inline]] Self chain(double f, double slope, double curvature) const {
    return chain_of_components(f, slope * doubled(), curvature * (doubled() * doubled()));
  }
  // The same from derivatives by what the components are of.
  [[gnu::always_inline]] Self chain_of_components(double f, double f1, double f2) const {
    Self r;
    r.half = 0;
    r.value = f;
    r.has_rate = has_rate;
    r.rate = product_if(has_rate, f1, rate);
    r.g_mask = g_mask;
    r.x_mask = x_mask | (has_rate ? g_mask : ComponentMask(0));
    r.h_mask = 0;
    ((r.template g<Is>() = product_if(has(g_mask, Is), f1, g<Is>())), ...);
    ((r.template x<Is>() = sum_of(has(x_mask, Is), product_if(has(x_mask, Is), f1, x<Is>()), has_rate & has(g_mask, Is),
                                  product_if(has_rate & has(g_mask, Is), -(f2 * rate), g<Is>()))), ...);
    (r.template set_hessian_of_chain<K>(*this, f1, f2), ...);
    return r;
  }

 private:
  [[gnu::always_inline]] double doubled() const { return half ? 2.0 : 1.0; }

  template <int i>
  [[gnu::always_inline]] void set_variation(Present has_plus, double plus, Present has_minus, double minus) {
    const Present cancels = (has_plus & has_minus) ? known_equal(plus, minus) : 0U;
    x<i>() = cancels ? 0.0 : has_plus ? (has_minus ? plus - minus : plus) : (has_minus ? -minus : 0.0);
    x_mask |= bit((has_plus | has_minus) > cancels, i);
  }
  template <int i>
  [[gnu::always_inline]] void set_variation_of_product(const Self& a, double ca, const Self& b, double cb, double both) {
    const Present p1 = has(b.x_mask, i), p2 = has(a.x_mask, i);
    const Present m1 = a.has_rate & has(b.g_mask, i), m2 = b.has_rate & has(a.g_mask, i);
    set_variation<i>(p1 | p2, sum_of(p1, product_if(p1, cb, b.template x<i>()), p2, product_if(p2, ca, a.template x<i>())),
                     m1 | m2, sum_of(m1, product_if(m1, a.rate, b.template g<i>()), m2, product_if(m2, b.rate, a.template g<i>())) * both);
  }
  template <int k>
  [[gnu::always_inline]] void set_hessian_of_product(const Self& a, double ca, const Self& b, double cb, double both) {
    constexpr int i = triangle_row(k), j = triangle_column(k);
    const Present g1 = has(a.g_mask, i) & has(b.g_mask, j), g2 = has(b.g_mask, i) & has(a.g_mask, j);
    const Present h1 = has(b.h_mask, k), h2 = has(a.h_mask, k);
    h<k>() = sum_of(g1 | g2, sum_of(g1, product_if(g1, a.template g<i>(), b.template g<j>()), g2, product_if(g2, b.template g<i>(), a.template g<j>())) * both,
                    h1 | h2, sum_of(h1, product_if(h1, cb, b.template h<k>()), h2, product_if(h2, ca, a.template h<k>())));
    h_mask |= bit(g1 | g2 | h1 | h2, k);
  }
  template <int k>
  [[gnu::always_inline]] void set_hessian_of_chain(const Self& u, double f1, double f2) {
    constexpr int i = triangle_row(k), j = triangle_column(k);
    const Present squares = has(u.g_mask, i) & has(u.g_mask, j), own = has(u.h_mask, k);
    h<k>() = sum_of(squares, product_if(squares, f2 * u.template g<i>(), u.template g<j>()), own, product_if(own, f1, u.template h<k>()));
    h_mask |= bit(squares | own, k);
  }
  [[gnu::always_inline]] Self square() const {
    const Self a = whole();
    Self r;
    r.half = 1;
    r.value = a.value * a.value;
    r.has_rate = a.has_rate;
    r.rate = product_if(a.has_rate, a.value, a.rate);
    r.g_mask = a.g_mask;
    r.x_mask = 0;
    r.h_mask = 0;
    ((r.template g<Is>() = product_if(has(a.g_mask, Is), a.value, a.template g<Is>())), ...);
    (r.template set_variation<Is>(has(a.x_mask, Is), product_if(has(a.x_mask, Is), a.value, a.template x<Is>()),
                                  a.has_rate & has(a.g_mask, Is), product_if(a.has_rate & has(a.g_mask, Is), a.rate, a.template g<Is>())), ...);
    (r.template set_half_hessian_of_square<K>(a), ...);
    return r;
  }
  template <int k>
  [[gnu::always_inline]] void set_half_hessian_of_square(const Self& a) {
    constexpr int i = triangle_row(k), j = triangle_column(k);
    const Present squares = has(a.g_mask, i) & has(a.g_mask, j), own = has(a.h_mask, k);
    h<k>() = sum_of(squares, product_if(squares, a.template g<i>(), a.template g<j>()), own, product_if(own, a.value, a.template h<k>()));
    h_mask |= bit(squares | own, k);
  }
};

}  // namespace qdot::detail
