#pragma once
// SPDX-License-Identifier: MIT
//
// A number that knows how it moves: what velocities in T, forces on points and constraints ask of a position.
//
// Of a position x(q, t) the equations of motion need
//
//     J = ∂x/∂q ,     ẋ = J q̇ + ∂x/∂t ,     ẍ = J q̈ + s ,     s = J̇ q̇ + … ,
//
// and s is the second derivative along the motion with q̈ = 0. These are first derivatives in n directions and
// two derivatives in one, closed under arithmetic:
//
//     J(u w) = u Jw + w Ju       (u w)˙ = u ẇ + w u̇        s(u w) = u sw + w su + 2 u̇ ẇ
//     J f(u) = f′ Ju              f(u)˙ = f′ u̇              s f(u) = f′ su + f″ u̇²
//
// A scalar of Lagrange's equations that a position is made with, captured in a functor, is a constant, or has derivatives for which there is
// no place here. Then a bit of the mask, above all others, is one that the compiler must not know: what follows from it has it as well.
//
// A square is kept with the derivatives of its half, as ad/lagrange/euler_lagrange.hpp keeps it: in ½(x² + y² − l²), of which constraints are made, and in
// √(x² + y²) neither the 2 nor the ½ is computed. Code that reads derivatives calls whole() first.
//
// n + 3 numbers, where T(q, q̇) written with velocities needs a Hessian. As in ad/lagrange/euler_lagrange.hpp masks say which of them
// may be other than zero, every component is a member with a name of its own and every operation is inlined,
// so that in straight-line code what is zero is never computed.

#include <type_traits>
#include <utility>

#include "qdot/ad/lagrange/euler_lagrange_math.hpp"

namespace qdot::detail {

template <int i>
struct RowEntry {
  double number;
};

// The bit above those of the components, set but unknown to the compiler, where `wrong`.
[[gnu::always_inline]] inline ComponentMask unknown_if(Present wrong) {
  if (!wrong) return 0;
  ComponentMask mask = ~ComponentMask(0);
  asm("" : "+r"(mask));
  return mask & bit(1, 63);
}

// `remembers`: whether rotations by these numbers keep their coordinates (mechanics/equations/known_rotation.hpp). Then each kind has a type of its own.
template <int n, class = std::make_integer_sequence<int, n>, bool remembers = true>
struct PositionJet;

template <int n, int... Is, bool remembers>
struct PositionJet<n, std::integer_sequence<int, Is...>, remembers>
    : RowEntry<Is>..., ComparedByValue<PositionJet<n, std::integer_sequence<int, Is...>, remembers>> {
  using Self = PositionJet;
  static constexpr bool remembers_rotations = remembers;

  double value;
  double rate;  // ẋ
  double bend;  // s
  ComponentMask mask;
  Present has_rate, has_bend, half;

  template <int i>
  [[gnu::always_inline]] double& J() { return static_cast<RowEntry<i>&>(*this).number; }
  template <int i>
  [[gnu::always_inline]] const double& J() const { return static_cast<const RowEntry<i>&>(*this).number; }

  // Trivial, like double's.
  PositionJet() = default;

  template <class Number>
    requires std::is_arithmetic_v<Number>
  [[gnu::always_inline]] PositionJet(Number constant)
      : value(static_cast<double>(constant)), rate(0.0), bend(0.0), mask(0), has_rate(0), has_bend(0), half(0) {
    ((J<Is>() = 0.0), ...);
  }
  template <class K>
  [[gnu::always_inline]] PositionJet(const EulerLagrange<n, std::integer_sequence<int, Is...>, K>& captured) : PositionJet(captured.value) {
    mask = unknown_if(1U ^ captured.is_constant());
  }
  [[gnu::always_inline]] PositionJet(const Self& o)
      : value(o.value), rate(o.rate), bend(o.bend), mask(o.mask), has_rate(o.has_rate), has_bend(o.has_bend), half(o.half) {
    ((J<Is>() = o.template J<Is>()), ...);
  }
  [[gnu::always_inline]] Self& operator=(const Self& o) {
    value = o.value;
    rate = o.rate;
    bend = o.bend;
    mask = o.mask;
    has_rate = o.has_rate;
    has_bend = o.has_bend;
    half = o.half;
    ((J<Is>() = o.template J<Is>()), ...);
    return *this;
  }

  template <int i>
  [[gnu::always_inline]] static Self coordinate(double q, double qdot) {
    Self r(q);
    r.rate = qdot;
    r.has_rate = 1;
    r.template J<i>() = 1.0;
    r.mask = qdot::detail::bit(1, i);
    return r;
  }
  [[gnu::always_inline]] static Self time(double t) {
    Self r(t);
    r.rate = 1.0;
    r.has_rate = 1;
    return r;
  }

  [[gnu::always_inline]] Present is_constant() const {
    return static_cast<Present>((static_cast<ComponentMask>(has_rate) | static_cast<ComponentMask>(has_bend) | mask) == 0);
  }
  // The same number with its components written out in full.
  [[gnu::always_inline]] Self whole() const {
    Self r(*this);
    if (half) {
      r.rate = product_if(has_rate, 2.0, rate);
      r.bend = product_if(has_bend, 2.0, bend);
      ((r.template J<Is>() = product_if(has(mask, Is), 2.0, J<Is>())), ...);
      r.half = 0;
    }
    return r;
  }
  friend const double& innermost_value(const Self& x) { return x.value; }
  [[gnu::always_inline]] friend const double& mark_of(const Self& x) { return x.value; }  // mechanics/equations/known_rotation.hpp

  [[gnu::always_inline]] friend Self operator+(const Self& a, const Self& b) {
    const Present both = (a.half | a.is_constant()) & (b.half | b.is_constant());
    const double fa = (a.half > both) ? 2.0 : 1.0, fb = (b.half > both) ? 2.0 : 1.0;
    Self r;
    r.half = both & (a.half | b.half);
    r.value = a.value + b.value;
    r.has_rate = a.has_rate | b.has_rate;
    r.has_bend = a.has_bend | b.has_bend;
    r.mask = a.mask | b.mask;
    r.rate = sum_of(a.has_rate, fa * a.rate, b.has_rate, fb * b.rate);
    r.bend = sum_of(a.has_bend, fa * a.bend, b.has_bend, fb * b.bend);
    ((r.template J<Is>() = sum_of(has(a.mask, Is), fa * a.template J<Is>(), has(b.mask, Is), fb * b.template J<Is>())), ...);
    return r;
  }
  [[gnu::always_inline]] friend Self operator-(const Self& a) {
    Self r(a);
    r.value = -a.value;
    r.rate = -a.rate;
    r.bend = -a.bend;
    ((r.template J<Is>() = -a.template J<Is>()), ...);
    return r;
  }
  [[gnu::always_inline]] friend Self operator+(const Self& a) { return a; }
  [[gnu::always_inline]] friend Self operator-(const Self& a, const Self& b) { return a + (-b); }
  [[gnu::always_inline]] friend Self operator*(const Self& a, const Self& b) {
#ifndef __clang__  // where the test would keep both operands in memory
    if (&a == &b) return a.square();
#endif
    const double ca = b.value * a.doubled(), cb = a.value * b.doubled();
    Self r;
    r.half = 0;
    r.value = a.value * b.value;
    r.has_rate = a.has_rate | b.has_rate;
    r.mask = a.mask | b.mask;
    r.rate = sum_of(a.has_rate, product_if(a.has_rate, a.rate, ca), b.has_rate, product_if(b.has_rate, b.rate, cb));
    const Present both = a.has_rate & b.has_rate;
    r.has_bend = a.has_bend | b.has_bend | both;
    r.bend = sum_of(both, product_if(both, 2.0 * (a.doubled() * b.doubled()) * a.rate, b.rate), a.has_bend | b.has_bend,
                    sum_of(a.has_bend, product_if(a.has_bend, a.bend, ca), b.has_bend, product_if(b.has_bend, b.bend, cb)));
    ((r.template J<Is>() = sum_of(has(a.mask, Is), product_if(has(a.mask, Is), a.template J<Is>(), ca),
                                  has(b.mask, Is), product_if(has(b.mask, Is), b.template J<Is>(), cb))), ...);
    return r;
  }
  [[gnu::always_inline]] friend Self operator/(const Self& a, const Self& b) {
    const double i = 1.0 / b.value;
    Self r = b.is_constant() ? a * Self(i) : a * b.chain(i, -i * i, 2.0 * i * i * i);
    r.value = a.value / b.value;
    return r;
  }
  [[gnu::always_inline]] Self& operator+=(const Self& o) { return *this = *this + o; }
  [[gnu::always_inline]] Self& operator-=(const Self& o) { return *this = *this - o; }
  [[gnu::always_inline]] Self& operator*=(const Self& o) { return *this = *this * o; }
  [[gnu::always_inline]] Self& operator/=(const Self& o) { return *this = *this / o; }

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
    r.has_bend = has_bend | has_rate;
    r.mask = mask;
    r.rate = product_if(has_rate, f1, rate);
    r.bend = sum_of(has_rate, product_if(has_rate, f2, rate * rate), has_bend, product_if(has_bend, f1, bend));
    ((r.template J<Is>() = product_if(has(mask, Is), f1, J<Is>())), ...);
    return r;
  }

 private:
  [[gnu::always_inline]] double doubled() const { return half ? 2.0 : 1.0; }

  [[gnu::always_inline]] Self square() const {
    const Self a = whole();
    Self r;
    r.half = 1;
    r.value = a.value * a.value;
    r.has_rate = a.has_rate;
    r.has_bend = a.has_rate | a.has_bend;
    r.mask = a.mask;
    r.rate = product_if(a.has_rate, a.value, a.rate);
    r.bend = sum_of(a.has_rate, product_if(a.has_rate, a.rate, a.rate), a.has_bend, product_if(a.has_bend, a.value, a.bend));
    ((r.template J<Is>() = product_if(has(a.mask, Is), a.value, a.template J<Is>())), ...);
    return r;
  }
};

template <int n, class Is, bool remembers>
struct is_euler_lagrange<PositionJet<n, Is, remembers>> : std::true_type {};

}  // namespace qdot::detail
