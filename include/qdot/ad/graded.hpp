#pragma once
// SPDX-License-Identifier: MIT
//
// The scalar of Lagrange's equations for loops and for many coordinates.
//
// It has the algebra of ad/euler_lagrange.hpp, but no derivative is carried along. With g = ∂/∂q̇ and X = ∂/∂q − D ∂/∂q̇, every
// rule of that algebra turns the pair (g, X) of an operand into
//
//     g ← a g ,      X ← a X + b g ,      H ← a H + w g gᵀ ,
//
// with three numbers a, b, w. A value is therefore a node of the record together with these three numbers, and functions of one
// argument, products with constants and products of values on the same node only change the numbers. A sum or product of two
// different nodes makes a new node. A coordinate and its velocity share one node, with g = e_i, X = 0: the velocity is
// (a, b) = (1, 0), the coordinate (0, 1).
//
// What becomes of the nodes is found afterwards, by one sweep backwards that is the same length for any number of
// coordinates (hessian_record.hpp). Values of an evaluation do not outlive its record.

#include <type_traits>

#include "qdot/ad/hessian_record.hpp"

namespace qdot::detail {

template <int blocks>
struct Graded {
  using Self = Graded;
  using Record = HessianRecord<blocks>;

  double value;
  double rate;     // D
  double a, b, w;  // of its node
  int node;        // −1: none
  Record* record;

  Graded() = default;
  template <class Number>
    requires std::is_arithmetic_v<Number>
  Graded(Number constant) : Graded(static_cast<double>(constant), 0.0, 0.0, 0.0, 0.0, -1, nullptr) {}
  Graded(double value_, double rate_, double a_, double b_, double w_, int node_, Record* record_)
      : value(value_), rate(rate_), a(a_), b(b_), w(w_), node(node_), record(record_) {}

  bool is_constant() const { return rate == 0.0 && node < 0; }

  Self& operator+=(const Self& o) { return *this = sum(*this, o, 1.0); }
  Self& operator-=(const Self& o) { return *this = sum(*this, o, -1.0); }
  Self& operator*=(const Self& o) { return *this = *this * o; }
  Self& operator/=(const Self& o) { return *this = *this / o; }

  friend Self operator+(const Self& u, const Self& v) { return sum(u, v, 1.0); }
  friend Self operator-(const Self& u, const Self& v) { return sum(u, v, -1.0); }
  friend Self operator+(const Self& u) { return u; }
  friend Self operator-(const Self& u) { return u.times(-1.0); }
  [[gnu::always_inline]] friend inline Self operator*(const Self& u, const Self& v) {
    const double f = u.value * v.value, Df = u.value * v.rate + v.value * u.rate;
    const double ua = v.value * u.a, ub = v.value * u.b - v.rate * u.a, uw = v.value * u.w;
    const double va = u.value * v.a, vb = u.value * v.b - u.rate * v.a, vw = u.value * v.w;
    const double cross = u.a * v.a;
    if (u.node == v.node || v.node < 0 || u.node < 0)
      return Self(f, Df, ua + va, ub + vb, uw + vw + 2.0 * cross, u.node < 0 ? v.node : u.node, u.node < 0 ? v.record : u.record);
    return Self(f, Df, 1.0, 0.0, 0.0, u.record->add(u.node, ua, ub, uw, v.node, va, vb, vw, cross), u.record);
  }
  friend Self operator/(const Self& u, const Self& v) {
    const double i = 1.0 / v.value;
    Self r = v.is_constant() ? u.times(i) : u * v.chain(i, -i * i, 2.0 * i * i * i);
    r.value = u.value / v.value;
    return r;
  }

  // Mixed with plain numbers: no temporary of this type.
  friend Self operator*(double c, const Self& u) { return u.times(c); }
  friend Self operator*(const Self& u, double c) { return u.times(c); }
  friend Self operator/(const Self& u, double c) { return u.times(1.0 / c); }

  friend bool operator==(const Self& u, const Self& v) { return u.value == v.value; }
  friend bool operator!=(const Self& u, const Self& v) { return u.value != v.value; }
  friend bool operator<(const Self& u, const Self& v) { return u.value < v.value; }
  friend bool operator<=(const Self& u, const Self& v) { return u.value <= v.value; }
  friend bool operator>(const Self& u, const Self& v) { return u.value > v.value; }
  friend bool operator>=(const Self& u, const Self& v) { return u.value >= v.value; }

  // f(u) from f, f′, f″ at u.
  [[gnu::always_inline]] Self chain(double f, double f1, double f2) const {
    return Self(f, f1 * rate, f1 * a, f1 * b - f2 * rate * a, f1 * w + f2 * a * a, node, record);
  }

  Self whole() const { return *this; }

 private:
  Self times(double c) const { return Self(c * value, c * rate, c * a, c * b, c * w, node, record); }

  [[gnu::always_inline]] static Self sum(const Self& u, const Self& v, double sign) {
    const double f = u.value + sign * v.value, Df = u.rate + sign * v.rate;
    if (u.node == v.node || v.node < 0) return Self(f, Df, u.a + sign * v.a, u.b + sign * v.b, u.w + sign * v.w, u.node, u.record);
    if (u.node < 0) return Self(f, Df, sign * v.a, sign * v.b, sign * v.w, v.node, v.record);
    return Self(f, Df, 1.0, 0.0, 0.0,
                u.record->add(u.node, u.a, u.b, u.w, v.node, sign * v.a, sign * v.b, sign * v.w, 0.0), u.record);
  }
};

}  // namespace qdot::detail
