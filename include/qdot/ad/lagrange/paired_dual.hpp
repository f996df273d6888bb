#pragma once
// SPDX-License-Identifier: MIT
//
// A dual number with the derivatives along all coordinates and velocities, for straight-line code.
//
// Its tangent has a pair for each coordinate, (∂/∂q_i, ∂/∂q̇_i): two doubles are one register on every machine, and what
// depends on a coordinate usually depends on its velocity too. Bits say which pairs may be other than zero. As in
// ad/lagrange/euler_lagrange.hpp, of which this is the Number when its results are to be differentiated, the compiler knows the bits of
// straight-line code and leaves out what they exclude; therefore each pair is a member with a name of its own here too.
//
// Jacobians of straight-line T and V of up to four coordinates: 1.6 to 1.9 times their q̈. From lines of a graph, which larger systems take, they are 1.5 to
// 2.1 times as much, and a bare acceleration_jacobian() may not keep those.

#include <type_traits>
#include <utility>

#include "qdot/ad/dual.hpp"
#include "qdot/ad/lagrange/euler_lagrange.hpp"

namespace qdot::detail {

// a b and a + b where the pairs may be known to be zero.
[[gnu::always_inline]] inline Pair pair_times(Present present, const Pair& a, double b) { return present ? a * b : Pair{}; }
[[gnu::always_inline]] inline Pair pair_sum(Present has_a, const Pair& a, Present has_b, const Pair& b) {
  return has_a ? (has_b ? a + b : a) : (has_b ? b : Pair{});
}

template <int i>
struct PairOf {
  Pair pair;
};

template <int n, class = std::make_integer_sequence<int, n>>
struct PairedDual;

template <int n, int... Is>
struct PairedDual<n, std::integer_sequence<int, Is...>> : PairOf<Is>..., ComparedByValue<PairedDual<n, std::integer_sequence<int, Is...>>> {
  using Self = PairedDual;

  double value;
  ComponentMask mask;

  template <int i>
  [[gnu::always_inline]] Pair& pair() { return static_cast<PairOf<i>&>(*this).pair; }
  template <int i>
  [[gnu::always_inline]] const Pair& pair() const { return static_cast<const PairOf<i>&>(*this).pair; }

  PairedDual() = default;
  template <class Constant>
    requires std::is_arithmetic_v<Constant>
  [[gnu::always_inline]] PairedDual(const Constant& constant) : value(static_cast<double>(constant)), mask(0) {
    ((pair<Is>() = Pair{}), ...);
  }
  [[gnu::always_inline]] PairedDual(const Self& o) : value(o.value), mask(o.mask) { ((pair<Is>() = o.template pair<Is>()), ...); }
  [[gnu::always_inline]] Self& operator=(const Self& o) {
    value = o.value;
    mask = o.mask;
    ((pair<Is>() = o.template pair<Is>()), ...);
    return *this;
  }

  // A number whose derivatives along q_i and q̇_i are given, and no others.
  template <int i>
  [[gnu::always_inline]] static Self variable(double at, double along_q, double along_qdot) {
    Self r(at);
    r.template pair<i>() = Pair{along_q, along_qdot};
    r.mask = bit(1, i);
    return r;
  }

  // f(x) from f and f′ at x.
  [[gnu::always_inline]] Self through(double f, double slope) const {
    Self r;
    r.value = f;
    r.mask = mask;
    ((r.template pair<Is>() = pair_times(has(mask, Is), pair<Is>(), slope)), ...);
    return r;
  }

  [[gnu::always_inline]] friend Self operator+(const Self& x) { return x; }
  [[gnu::always_inline]] friend Self operator-(const Self& x) {
    Self r;
    r.value = -x.value;
    r.mask = x.mask;
    ((r.template pair<Is>() = -x.template pair<Is>()), ...);
    return r;
  }
  [[gnu::always_inline]] friend Self operator+(const Self& x, const Self& y) {
    Self r;
    r.value = x.value + y.value;
    r.mask = x.mask | y.mask;
    ((r.template pair<Is>() = pair_sum(has(x.mask, Is), x.template pair<Is>(), has(y.mask, Is), y.template pair<Is>())), ...);
    return r;
  }
  [[gnu::always_inline]] friend Self operator-(const Self& x, const Self& y) { return x + (-y); }
  [[gnu::always_inline]] friend Self operator*(const Self& x, const Self& y) {
    Self r;
    r.value = x.value * y.value;
    r.mask = x.mask | y.mask;
    ((r.template pair<Is>() = pair_sum(has(x.mask, Is), pair_times(has(x.mask, Is), x.template pair<Is>(), y.value),
                                       has(y.mask, Is), pair_times(has(y.mask, Is), y.template pair<Is>(), x.value))), ...);
    return r;
  }
  [[gnu::always_inline]] friend Self operator/(const Self& x, const Self& y) {
    const double inverse = 1.0 / y.value;
    Self r = x * y.through(inverse, -inverse * inverse);
    r.value = x.value / y.value;
    return r;
  }
  [[gnu::always_inline]] friend Self operator*(const Self& x, double c) { return x.through(x.value * c, c); }
  [[gnu::always_inline]] friend Self operator*(double c, const Self& x) { return x.through(x.value * c, c); }
  [[gnu::always_inline]] friend Self operator/(double c, const Self& y) {
    const double quotient = c / y.value;
    return y.through(quotient, -quotient / y.value);
  }
  [[gnu::always_inline]] Self& operator+=(const Self& o) { return *this = *this + o; }
  [[gnu::always_inline]] Self& operator-=(const Self& o) { return *this = *this - o; }
};

[[gnu::always_inline]] inline Present known_equal(const Pair& a, const Pair& b) { return known_equal(a[0], b[0]) & known_equal(a[1], b[1]); }

template <int n, int... Is>
[[gnu::always_inline]] inline Present known_equal(const PairedDual<n, std::integer_sequence<int, Is...>>& a,
                                                  const PairedDual<n, std::integer_sequence<int, Is...>>& b) {
  return (known_equal(a.value, b.value) & ... &
          (has(a.mask | b.mask, Is) ? known_equal(a.template pair<Is>(), b.template pair<Is>()) : 1U));
}

// The plain number in it, beside those of duals.
using qdot::innermost_value;
template <int n, class Is>
[[gnu::always_inline]] inline double innermost_value(const PairedDual<n, Is>& x) { return x.value; }

// f(x) from f and f′, and f(x, y) from f, ∂f/∂x, ∂f/∂y.
template <int n, class Is>
[[gnu::always_inline]] inline PairedDual<n, Is> lifted(const PairedDual<n, Is>& x, double f, double slope) { return x.through(f, slope); }
template <int n, class Is>
[[gnu::always_inline]] inline PairedDual<n, Is> lifted(const PairedDual<n, Is>& x, const PairedDual<n, Is>& y, double f, double f_x, double f_y) {
  return x.through(f, f_x) + y.through(0.0, f_y);
}

}  // namespace qdot::detail
