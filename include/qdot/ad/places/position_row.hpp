#pragma once
// SPDX-License-Identifier: MIT
//
// The number of ad/places/position_jet.hpp for loops and many coordinates: the same value, ẋ, s and J = ∂x/∂q, with
// J a contiguous row of blocks that is zero outside of a range, and decisions made while it runs.
//
// It is for evaluations of positions outside of runs, and for runs of up to four coordinates: q̈ of chains of 2, 4, 8 and
// 16 masses takes 0.3, 0.6, 1.5 and 4.3 µs this way, and 1.0, 6.1, 55 and 374 by nested duals (g++ -O3).

#include <algorithm>
#include <limits>
#include <type_traits>

#include "qdot/ad/lagrange/euler_lagrange_math.hpp"
#include "qdot/ad/places/block.hpp"

namespace qdot::detail {

// `blocks` blocks, zero outside [first, last).
template <int blocks>
struct PositionGradient {
  int first, last;
  double number[4 * blocks];

  PositionGradient() = default;
  PositionGradient(const PositionGradient& o) : first(o.first), last(o.last) {
    copy_numbers(o);
  }
  PositionGradient& operator=(const PositionGradient& o) {
    first = o.first;
    last = o.last;
    copy_numbers(o);
    return *this;
  }

  double* block(int i) { return number + 4 * i; }
  const double* block(int i) const { return number + 4 * i; }

  void copy_numbers(const PositionGradient& o) {
    for (int i = first; i < last; ++i) {
      Block b;
      read(b, o.block(i));
      write(block(i), b);
    }
  }
  bool empty() const { return first == last; }
  double operator[](int i) const { return i / 4 >= first && i / 4 < last ? number[i] : 0.0; }

  void clear() { first = last = 0; }
  // The unit vector e_i.
  void set_unit(int i) {
    first = i / 4;
    last = first + 1;
    for (int k = 4 * first; k < 4 * last; ++k) number[k] = k == i ? 1.0 : 0.0;
  }
  // this ← c a
  void set(double c, const PositionGradient& a) {
    first = a.first;
    last = a.last;
    for (int i = first; i < last; ++i) set_block(block(i), c, a.block(i));
  }
  // this ← this + c a
  void add(double c, const PositionGradient& a) {
    if (a.empty()) return;
    if (empty()) {
      set(c, a);
      return;
    }
    for (int i = a.first; i < first; ++i) write(block(i), Block{});
    for (int i = last; i < a.last; ++i) write(block(i), Block{});
    first = std::min(first, a.first);
    last = std::max(last, a.last);
    for (int i = a.first; i < a.last; ++i) add_block(block(i), c, a.block(i));
  }
};

template <int blocks>
struct PositionRow : ComparedByValue<PositionRow<blocks>> {
  using Self = PositionRow;

  double value, rate, bend;
  PositionGradient<blocks> J;

  PositionRow() : PositionRow(0.0) {}
  template <class Number>
    requires std::is_arithmetic_v<Number>
  PositionRow(Number constant) : value(static_cast<double>(constant)), rate(0.0), bend(0.0) {
    J.clear();
  }

  bool is_constant() const { return rate == 0.0 && bend == 0.0 && J.empty(); }
  const Self& whole() const { return *this; }

  Self& operator+=(const Self& o) {
    value += o.value;
    rate += o.rate;
    bend += o.bend;
    J.add(1.0, o.J);
    return *this;
  }
  Self& operator-=(const Self& o) {
    value -= o.value;
    rate -= o.rate;
    bend -= o.bend;
    J.add(-1.0, o.J);
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
    Self r;
    r.value = a.value * b.value;
    r.rate = a.value * b.rate + b.value * a.rate;
    r.bend = a.value * b.bend + b.value * a.bend + 2.0 * a.rate * b.rate;
    r.J.set(b.value, a.J);
    r.J.add(a.value, b.J);
    return r;
  }
  friend Self operator/(const Self& a, const Self& b) {
    const double i = 1.0 / b.value;
    Self r = a * b.chain(i, -i * i, 2.0 * i * i * i);
    r.value = a.value / b.value;
    return r;
  }
  friend Self operator*(double c, const Self& a) { return a.times(c); }
  friend Self operator*(const Self& a, double c) { return a.times(c); }
  friend Self operator/(const Self& a, double c) { return a.times(1.0 / c); }

  // f(u) from f, f′, f″ at u.
  Self chain(double f, double f1, double f2) const {
    Self r;
    r.value = f;
    r.rate = f1 * rate;
    r.bend = f1 * bend + f2 * rate * rate;
    r.J.set(f1, J);
    return r;
  }

 private:
  Self times(double c) const {
    Self r;
    r.value = c * value;
    r.rate = c * rate;
    r.bend = c * bend;
    r.J.set(c, J);
    return r;
  }
};

template <int blocks>
struct is_euler_lagrange<PositionRow<blocks>> : std::true_type {};

}  // namespace qdot::detail
