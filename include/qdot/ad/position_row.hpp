#pragma once
// SPDX-License-Identifier: MIT
//
// The number of ad/position_jet.hpp for loops, rotation matrices and many coordinates: the same value, ẋ, s and J = ∂x/∂q, with
// J a contiguous row of blocks that is zero outside of a range (hessian_record.hpp), and decisions made while it runs.

#include <limits>
#include <type_traits>

#include "qdot/ad/euler_lagrange_math.hpp"
#include "qdot/ad/hessian_record.hpp"

namespace qdot::detail {

template <int blocks>
struct PositionRow {
  using Self = PositionRow;

  double value, rate, bend;
  BlockRow<blocks> J;

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

  friend bool operator==(const Self& a, const Self& b) { return a.value == b.value; }
  friend bool operator!=(const Self& a, const Self& b) { return a.value != b.value; }
  friend bool operator<(const Self& a, const Self& b) { return a.value < b.value; }
  friend bool operator<=(const Self& a, const Self& b) { return a.value <= b.value; }
  friend bool operator>(const Self& a, const Self& b) { return a.value > b.value; }
  friend bool operator>=(const Self& a, const Self& b) { return a.value >= b.value; }

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

template <int blocks>
struct std::numeric_limits<qdot::detail::PositionRow<blocks>> : std::numeric_limits<double> {};
template <int blocks>
struct Eigen::NumTraits<qdot::detail::PositionRow<blocks>> : qdot::detail::RealTraits<qdot::detail::PositionRow<blocks>> {};
template <int blocks, class Number, class Operation>
  requires std::is_arithmetic_v<Number>
struct Eigen::ScalarBinaryOpTraits<qdot::detail::PositionRow<blocks>, Number, Operation> {
  using ReturnType = qdot::detail::PositionRow<blocks>;
};
template <int blocks, class Number, class Operation>
  requires std::is_arithmetic_v<Number>
struct Eigen::ScalarBinaryOpTraits<Number, qdot::detail::PositionRow<blocks>, Operation> {
  using ReturnType = qdot::detail::PositionRow<blocks>;
};
