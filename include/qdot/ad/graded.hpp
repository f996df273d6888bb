#pragma once
// SPDX-License-Identifier: MIT
//
// The scalar of Lagrange's equations for loops and for many coordinates.
//
// It has the algebra of ad/euler_lagrange.hpp (value, D, g = ∂/∂q̇, X = ∂/∂q − D ∂/∂q̇) in contiguous rows, with three
// economies that are decided while it runs:
//
//  - Rows consist of blocks of four numbers and have a range of blocks outside of which they are zero. A sum into an
//    accumulator costs the range of what is added. An X that cancels, as for every velocity, is dropped.
//  - A value of no velocity (cos q) has an empty g and costs nothing there.
//  - No second derivatives are carried. A product of two values with velocities is a term g hᵀ of the
//    Hessian whose weight is not known yet: what T multiplies it with comes later. So such products are written to a
//    record (hessian_record.hpp), and values refer to them.
//
// Values of an evaluation do not outlive its record.

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "qdot/ad/hessian_record.hpp"

namespace qdot::detail {

template <int blocks>
struct Graded {
  using Self = Graded;
  using Record = HessianRecord<blocks>;
  using RowOfBlocks = BlockRow<blocks>;

  double value;
  double rate;
  Record* record;
  double factor;  // of the node of second derivatives
  int hessian;    // that node of the record, −1: none
  RowOfBlocks g, x;

  Graded() : Graded(0.0) {}
  template <class Number>
    requires std::is_arithmetic_v<Number>
  Graded(Number constant)
      : value(static_cast<double>(constant)), rate(0.0), record(nullptr), factor(1.0), hessian(-1) {
    g.clear();
    x.clear();
  }

  bool is_constant() const { return rate == 0.0 && g.empty() && x.empty() && hessian < 0; }

  Self& operator+=(const Self& o) {
    value += o.value;
    rate += o.rate;
    g.add(1.0, o.g);
    x.add(1.0, o.x);
    add_hessian(1.0, o);
    return *this;
  }
  Self& operator-=(const Self& o) {
    value -= o.value;
    rate -= o.rate;
    g.add(-1.0, o.g);
    x.add(-1.0, o.x);
    add_hessian(-1.0, o);
    return *this;
  }
  Self& operator*=(const Self& o) { return *this = *this * o; }
  Self& operator/=(const Self& o) { return *this = *this / o; }

  friend Self operator+(const Self& a, const Self& b) {
    Self r(a);
    return r += b;
  }
  friend Self operator-(const Self& a, const Self& b) {
    Self r(a);
    return r -= b;
  }
  friend Self operator+(const Self& a) { return a; }
  friend Self operator-(const Self& a) { return a.times(-1.0); }
  friend Self operator*(const Self& a, const Self& b) {
    if (a.is_constant()) return b.times(a.value);
    if (b.is_constant()) return a.times(b.value);
    if (&a == &b) return a.chain(a.value * a.value, 2.0 * a.value, 2.0);
    Self r;
    r.record = a.record != nullptr ? a.record : b.record;
    r.value = a.value * b.value;
    r.rate = a.value * b.rate + b.value * a.rate;
    r.g.set(b.value, a.g);
    r.g.add(a.value, b.g);
    r.x.set(b.value, a.x);
    r.x.add(a.value, b.x);
    r.x.add(-b.rate, a.g);
    r.x.add(-a.rate, b.g);
    r.x.drop_zero_block();
    if (!a.g.empty() && !b.g.empty()) {
      r.hessian = r.record->add_product(2.0, a.g, &b.g, a.hessian, b.value * a.factor, b.hessian, a.value * b.factor);
    } else if (a.hessian >= 0 || b.hessian >= 0) {
      r.hessian = a.hessian >= 0 ? a.hessian : b.hessian;
      r.factor = a.hessian >= 0 ? a.factor * b.value : b.factor * a.value;
    }
    return r;
  }
  friend Self operator/(const Self& a, const Self& b) {
    const double i = 1.0 / b.value;
    Self r = b.is_constant() ? a.times(i) : a * b.chain(i, -i * i, 2.0 * i * i * i);
    r.value = a.value / b.value;
    return r;
  }

  // Mixed with plain numbers: no temporary of this type.
  friend Self operator*(double c, const Self& a) { return a.times(c); }
  friend Self operator*(const Self& a, double c) { return a.times(c); }
  friend Self operator/(const Self& a, double c) { return a.times(1.0 / c); }

  friend bool operator==(const Self& a, const Self& b) { return a.value == b.value; }
  friend bool operator!=(const Self& a, const Self& b) { return a.value != b.value; }
  friend bool operator<(const Self& a, const Self& b) { return a.value < b.value; }
  friend bool operator<=(const Self& a, const Self& b) { return a.value <= b.value; }
  friend bool operator>(const Self& a, const Self& b) { return a.value > b.value; }
  friend bool operator>=(const Self& a, const Self& b) { return a.value >= b.value; }

  // f(u) from f, f′, f″ at u.
  Self chain(double f, double f1, double f2) const {
    Self r;
    r.record = record;
    r.value = f;
    r.rate = f1 * rate;
    r.g.set(f1, g);
    r.x.set(f1, x);
    if (!g.empty()) {
      r.x.add(-f2 * rate, g);
      r.x.drop_zero_block();
      r.hessian = record->add_product(f2, g, nullptr, hessian, f1 * factor, -1, 0.0);
    } else {
      r.hessian = hessian;
      r.factor = f1 * factor;
    }
    return r;
  }

  Self whole() const { return *this; }

 private:
  Self times(double c) const {
    Self r;
    r.record = record;
    r.value = c * value;
    r.rate = c * rate;
    r.g.set(c, g);
    r.x.set(c, x);
    r.hessian = hessian;
    r.factor = c * factor;
    return r;
  }
  void add_hessian(double sign, const Self& o) {
    if (record == nullptr) record = o.record;
    if (o.hessian < 0) return;
    if (hessian < 0) {
      hessian = o.hessian;
      factor = sign * o.factor;
    } else {
      hessian = record->add_sum(hessian, factor, o.hessian, sign * o.factor);
      factor = 1.0;
    }
  }
};

}  // namespace qdot::detail
