#pragma once
// SPDX-License-Identifier: MIT
//
// The scalar of Lagrange's equations for loops and for many coordinates.
//
// It has the algebra of ad/lagrange/euler_lagrange.hpp, but no derivative is carried along. With g = ∂/∂q̇ and X = ∂/∂q − D ∂/∂q̇, every
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
// coordinates (ad/records/hessian_record.hpp). Values of an evaluation do not outlive its record.
//
// This is for evaluations that may rely on nothing from before, a bare acceleration() and the looks of a run at itself; what a run evaluates are
// lines that it has derived (mechanics/derive/kept_lines.hpp), in a fifth to a half of the time. Nested duals are what is left without it: q̈ of chains
// of 2, 4, 8 and 16 links takes 0.36, 0.73, 1.8 and 3.7 µs this way and 0.9, 3.5, 24 and 140 by those (g++ -O3).

#include <type_traits>

#include "qdot/ad/dual.hpp"
#include "qdot/ad/records/hessian_record.hpp"

namespace qdot::detail {

// Record is HessianRecord, which says how many coordinates there may be.
template <class Record_>
struct Graded : ComparedByValue<Graded<Record_>> {
  using Self = Graded;
  using Record = Record_;

  double value;
  double rate;     // D
  double a, b, w;  // of its node
  int node;
  Record* record;  // nullptr: no node, a constant or a function of the time

  Graded() = default;
  template <class Constant>
    requires std::is_arithmetic_v<Constant>
  Graded(const Constant& constant) : Graded(static_cast<double>(constant), 0.0, 0.0, 0.0, 0.0, 0, nullptr) {}
  Graded(double value_, double rate_, double a_, double b_, double w_, int node_, Record* record_)
      : value(value_), rate(rate_), a(a_), b(b_), w(w_), node(node_), record(record_) {}

  bool is_constant() const { return rate == 0.0 && record == nullptr; }

  Self& operator+=(const Self& o) { return *this = sum(*this, o, 1.0); }
  Self& operator-=(const Self& o) { return *this = sum(*this, o, -1.0); }
  Self& operator*=(const Self& o) { return *this = *this * o; }
  Self& operator/=(const Self& o) { return *this = *this / o; }

  friend Self operator+(const Self& u, const Self& v) { return sum(u, v, 1.0); }
  friend Self operator-(const Self& u, const Self& v) { return sum(u, v, -1.0); }
  friend Self operator+(const Self& u) { return u; }
  friend Self operator-(const Self& u) { return u.times(-1.0); }
  [[gnu::always_inline]] friend inline Self operator*(const Self& u, const Self& v) {
    if (u.meets(v))
      return on_new_node(u.record->add_product(u, v), u.value * v.value, u.value * v.rate + v.value * u.rate, u.record);
    return Self(u.value * v.value, u.value * v.rate + v.value * u.rate, v.value * u.a + u.value * v.a,
                (v.value * u.b - v.rate * u.a) + (u.value * v.b - u.rate * v.a),
                v.value * u.w + u.value * v.w + 2.0 * u.a * v.a, u.record == nullptr ? v.node : u.node, u.record == nullptr ? v.record : u.record);
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

  // f(u) from f, f′, f″ at u.
  [[gnu::always_inline]] Self chain(double f, double f1, double f2) const {
    return Self(f, f1 * rate, f1 * a, f1 * b - f2 * rate * a, f1 * w + f2 * a * a, node, record);
  }

  bool meets(const Self& o) const { return record != nullptr && o.record != nullptr && node != o.node; }
  Self whole() const { return *this; }
  SineAndCosine* place_of_angle() const { return record == nullptr ? nullptr : &record->known(node); }

 private:
  template <class Factor>
  Self times(const Factor& c) const { return Self(c * value, c * rate, c * a, c * b, c * w, node, record); }

  // A value and rate that are now the variables of a node of their own.
  [[gnu::always_inline]] static Self on_new_node(int node, double f, double Df, Record* record) {
    return Self(f, Df, 1.0, 0.0, 0.0, node, record);
  }

  [[gnu::always_inline]] static Self sum(const Self& u, const Self& v, double sign) {
    const double f = u.value + sign * v.value, Df = u.rate + sign * v.rate;
    if (v.record == nullptr || (u.record != nullptr && u.node == v.node))
      return Self(f, Df, u.a + sign * v.a, u.b + sign * v.b, u.w + sign * v.w, u.node, u.record);
    if (u.record == nullptr) return Self(f, Df, sign * v.a, sign * v.b, sign * v.w, v.node, v.record);
    return on_new_node(u.record->add_sum(u, v, sign), f, Df, u.record);
  }
};

}  // namespace qdot::detail
