#pragma once
// SPDX-License-Identifier: MIT
//
// The scalar of Lagrange's equations for loops over few coordinates.
//
// It has the algebra and the components of ad/euler_lagrange.hpp: a value, D, g = ∂/∂q̇, X and the lower triangle of
// H = ∂²/∂q̇∂q̇. Here they lie in arrays of pairs, two numbers that are computed with at once, and bits that are looked at while the program runs
// say which *kinds* of component a value has. Values graded by their degree in q̇ have few of them: those of degree 0 no g, those of
// degree 1 no H. A kind that a value does not have is neither written nor read.
//
// An H takes of the order of n² operations for each sum, so that many coordinates do better with a record (ad/graded.hpp).

#include <type_traits>

#include "qdot/ad/euler_lagrange.hpp"
#include "qdot/ad/hessian_record.hpp"

namespace qdot::detail {

// A component that a value does not have is read by nobody: more than GCC sees.
#pragma GCC diagnostic push
#ifndef __clang__
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif

template <int n>
struct GradedJet {
  using Self = GradedJet;
  enum Kind : unsigned { has_rate = 1, has_g = 2, has_x = 4, has_h = 8 };
  static constexpr int pairs = (n + 1) / 2;
  // Row i of H has i/2 + 1 pairs.
  static constexpr int row(int i) { return (i / 2) * (i / 2 + 1) + (i % 2) * (i / 2 + 1); }

  double value;
  double rate;
  unsigned kinds;
  int leaf;                  // the coordinate that it is
  KnownAngles<8>* angles;    // of a coordinate; otherwise nullptr
  Pair g[pairs], x[pairs], h[row(n)];

  GradedJet() = default;
  template <class Number>
    requires std::is_arithmetic_v<Number>
  GradedJet(Number constant) : value(static_cast<double>(constant)), rate(0.0), kinds(0), leaf(0), angles(nullptr) {}
  GradedJet(const Self& o) { *this = o; }
  [[gnu::always_inline]] Self& operator=(const Self& o) {
    value = o.value;
    rate = o.rate;
    kinds = o.kinds;
    leaf = o.leaf;
    angles = o.angles;
    if (kinds & has_g)
      for (int j = 0; j < pairs; ++j) g[j] = o.g[j];
    if (kinds & has_x)
      for (int j = 0; j < pairs; ++j) x[j] = o.x[j];
    if (kinds & has_h)
      for (int j = 0; j < row(n); ++j) h[j] = o.h[j];
    return *this;
  }

  static Self coordinate(double q, double qdot, int i, KnownAngles<8>* angles) {
    Self r(q);
    r.rate = qdot;
    r.kinds = has_rate | has_x;
    r.leaf = i;
    r.angles = angles;
    set_unit(r.x, i);
    return r;
  }
  static Self velocity(double qdot, int i) {
    Self r(qdot);
    r.kinds = has_g;
    set_unit(r.g, i);
    return r;
  }
  static Self time(double t) {
    Self r(t);
    r.rate = 1.0;
    r.kinds = has_rate;
    return r;
  }

  bool is_constant() const { return kinds == 0; }
  double hessian(int i, int j) const { return h[row(i) + j / 2][j % 2]; }

  Self& operator+=(const Self& o) {
    add(*this, o, 1.0);
    return *this;
  }
  Self& operator-=(const Self& o) {
    add(*this, o, -1.0);
    return *this;
  }
  Self& operator*=(const Self& o) { return *this = *this * o; }
  Self& operator/=(const Self& o) { return *this = *this / o; }

  friend Self operator+(const Self& u, const Self& v) {
    Self r(u);
    add(r, v, 1.0);
    return r;
  }
  friend Self operator-(const Self& u, const Self& v) {
    Self r(u);
    add(r, v, -1.0);
    return r;
  }
  friend Self operator+(const Self& u) { return u; }
  friend Self operator-(const Self& u) { return u.times(-1.0); }
  friend Self operator*(double c, const Self& u) { return u.times(c); }
  friend Self operator*(const Self& u, double c) { return u.times(c); }
  friend Self operator/(const Self& u, double c) { return u.times(1.0 / c); }
  friend Self operator*(const Self& u, const Self& v) {
    if (&u == &v) return u.chain(u.value * u.value, 2.0 * u.value, 2.0);
    Self r;
    r.set_product(u, v);
    return r;
  }
  friend Self operator/(const Self& u, const Self& v) {
    const double i = 1.0 / v.value;
    Self r = v.is_constant() ? u.times(i) : u * v.chain(i, -i * i, 2.0 * i * i * i);
    r.value = u.value / v.value;
    return r;
  }

  friend bool operator==(const Self& u, const Self& v) { return u.value == v.value; }
  friend bool operator!=(const Self& u, const Self& v) { return u.value != v.value; }
  friend bool operator<(const Self& u, const Self& v) { return u.value < v.value; }
  friend bool operator<=(const Self& u, const Self& v) { return u.value <= v.value; }
  friend bool operator>(const Self& u, const Self& v) { return u.value > v.value; }
  friend bool operator>=(const Self& u, const Self& v) { return u.value >= v.value; }

  // f(u) from f, f′, f″ at u.
  Self chain(double f, double f1, double f2) const {
    Self r(f);
    r.rate = f1 * rate;
    r.kinds = kinds;
    const double f2_rate = f2 * rate;
    if (kinds & has_x) set(r.x, f1, x);
    if (kinds & has_g) {
      set(r.g, f1, g);
      if (kinds & has_rate) {
        if (kinds & has_x) {
          accumulate(r.x, -f2_rate, g);
        } else {
          set(r.x, -f2_rate, g);
          r.kinds |= has_x;
        }
      }
      if (f2 != 0.0 || kinds & has_h) {
        const bool own = kinds & has_h;
        r.kinds |= has_h;
        for (int i = 0; i < n; ++i) {
          const double c = f2 * g[i / 2][i % 2];
          for (int j = 0; j <= i / 2; ++j) r.h[row(i) + j] = own ? f1 * h[row(i) + j] + c * g[j] : c * g[j];
        }
      }
    }
    return r;
  }

  Self whole() const { return *this; }
  SineAndCosine* place_of_angle() const { return angles == nullptr ? nullptr : &angles->known(leaf); }

 private:
  static void set_unit(Pair* to, int i) {
    for (int j = 0; j < pairs; ++j) to[j] = Pair{i == 2 * j ? 1.0 : 0.0, i == 2 * j + 1 ? 1.0 : 0.0};
  }
  static void set(Pair* to, double c, const Pair* from) {
    for (int j = 0; j < pairs; ++j) to[j] = c * from[j];
  }
  static void accumulate(Pair* to, double c, const Pair* from) {
    for (int j = 0; j < pairs; ++j) to[j] += c * from[j];
  }

  Self times(double c) const {
    Self r(c * value);
    r.rate = c * rate;
    r.kinds = kinds;
    if (kinds & has_g) set(r.g, c, g);
    if (kinds & has_x) set(r.x, c, x);
    if (kinds & has_h)
      for (int j = 0; j < row(n); ++j) r.h[j] = c * h[j];
    return r;
  }

  template <int count>
  static void add_kind(bool had, bool has, Pair* to, double sign, const Pair* from) {
    if (!has) return;
    if (had) {
      for (int j = 0; j < count; ++j) to[j] += sign * from[j];
    } else {
      for (int j = 0; j < count; ++j) to[j] = sign * from[j];
    }
  }
  static void add(Self& r, const Self& v, double sign) {
    r.value += sign * v.value;
    r.rate += sign * v.rate;
    r.angles = nullptr;
    add_kind<pairs>(r.kinds & has_g, v.kinds & has_g, r.g, sign, v.g);
    add_kind<pairs>(r.kinds & has_x, v.kinds & has_x, r.x, sign, v.x);
    add_kind<row(n)>(r.kinds & has_h, v.kinds & has_h, r.h, sign, v.h);
    r.kinds |= v.kinds;
  }

  void set_product(const Self& u, const Self& v) {
    value = u.value * v.value;
    rate = u.value * v.rate + v.value * u.rate;
    leaf = 0;
    angles = nullptr;
    kinds = (u.kinds | v.kinds) & (has_rate | has_g);
    Present x_is_set = 0;
    const auto add_x = [&](double c, const Pair* from) {
      if (x_is_set) {
        accumulate(x, c, from);
      } else {
        set(x, c, from);
        x_is_set = 1;
      }
    };
    if (u.kinds & has_x) add_x(v.value, u.x);
    if (v.kinds & has_x) add_x(u.value, v.x);
    if (u.kinds & has_g) {
      set(g, v.value, u.g);
      if (v.kinds & has_rate) add_x(-v.rate, u.g);
    }
    if (v.kinds & has_g) {
      if (u.kinds & has_g) {
        accumulate(g, u.value, v.g);
      } else {
        set(g, u.value, v.g);
      }
      if (u.kinds & has_rate) add_x(-u.rate, v.g);
    }
    if (x_is_set) kinds |= has_x;
    if (u.kinds & v.kinds & has_g) {
      kinds |= has_h;
      for (int i = 0; i < n; ++i)
        for (int j = 0; j <= i / 2; ++j) h[row(i) + j] = u.g[i / 2][i % 2] * v.g[j] + v.g[i / 2][i % 2] * u.g[j];
      add_kind<row(n)>(true, u.kinds & has_h, h, v.value, u.h);
      add_kind<row(n)>(true, v.kinds & has_h, h, u.value, v.h);
    } else if ((u.kinds | v.kinds) & has_h) {
      kinds |= has_h;
      add_kind<row(n)>(false, u.kinds & has_h, h, v.value, u.h);
      add_kind<row(n)>(u.kinds & has_h, v.kinds & has_h, h, u.value, v.h);
    }
  }
};

#pragma GCC diagnostic pop

}  // namespace qdot::detail
