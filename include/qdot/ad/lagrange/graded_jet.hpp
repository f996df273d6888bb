#pragma once
// SPDX-License-Identifier: MIT
//
// The scalar of Lagrange's equations for loops over few coordinates.
//
// It has the algebra of ad/lagrange/euler_lagrange.hpp: a value, D, g = ∂/∂q̇ and X. Here they lie in arrays of pairs, two numbers that are computed with
// at once, and bits that are looked at while the program runs say which *kinds* of component a value has. Values graded by their degree
// in q̇ have few of them: those of degree 0 no g, velocities no X. A kind that a value does not have is not computed with.
//
// The second derivatives H = ∂²/∂q̇∂q̇ are not carried along. They begin where two g meet, as g gᵀ, and from there on are only added and multiplied by
// numbers; so a value has the place of its H in a record, and a factor. At the end one look back at the record gives each g gᵀ its weight in M.
//
// Every sum still takes of the order of n operations, so that many coordinates do better with a record of everything (ad/lagrange/graded.hpp).

#include <type_traits>

#include "qdot/ad/lagrange/euler_lagrange.hpp"
#include "qdot/ad/records/hessian_record.hpp"

namespace qdot::detail {

// The second derivatives of an evaluation, and the sines and cosines of its coordinates.
template <int n>
class SquareRecord : public KnownAngles<8> {
 public:
  static constexpr int pairs = (n + 1) / 2;

  // Places of g gᵀ, of g kᵀ + k gᵀ, and of a H + b K.
  int add_square(const Pair* g) {
    Node& node = nodes_.push();
    node.left = node.right = square;
    for (int j = 0; j < pairs; ++j) node.g[j] = g[j];
    return nodes_.size() - 1;
  }
  int add_product(const Pair* g, const Pair* k) {
    Node& node = nodes_.push();
    node.left = square;
    node.right = product;
    for (int j = 0; j < pairs; ++j) {
      node.g[j] = g[j];
      node.k[j] = k[j];
    }
    return nodes_.size() - 1;
  }
  int add_sum(double a, int H, double b, int K) {
    Node& node = nodes_.push();
    node.left = H;
    node.right = K;
    node.a = a;
    node.b = b;
    return nodes_.size() - 1;
  }

  // M, rows of 2·pairs numbers of which what is above the diagonal has no meaning, from the place and factor of L.
  void hessian(int root, double factor, Pair* M) {
    for (int k = 0; k < n * pairs; ++k) M[k] = Pair{};
    for (int k = 0; k <= root; ++k) nodes_[k].weight = 0.0;
    nodes_[root].weight = factor;
    for (int k = root; k >= 0; --k) {
      const Node& node = nodes_[k];
      if (node.left != square) {
        nodes_[node.left].weight += node.a * node.weight;
        nodes_[node.right].weight += node.b * node.weight;
      } else {
        add_outer(M, node.weight, node.g, node.right == product ? node.k : node.g);
        if (node.right == product) add_outer(M, node.weight, node.k, node.g);
      }
    }
  }

 private:
  static constexpr int square = -1, product = -2;
  struct Node {
    int left, right;  // of a sum; otherwise what it is
    double a, b, weight;
    Pair g[pairs], k[pairs];
  };

  [[gnu::always_inline]] static void add_outer(Pair* M, double weight, const Pair* g, const Pair* k) {
    for (int i = 0; i < n; ++i) {
      const double c = weight * g[i / 2][i % 2];
      if (c == 0.0) continue;
      for (int j = 0; j <= i / 2; ++j) M[i * pairs + j] += c * k[j];
    }
  }

  ShortStack<Node, 6 * n + 10> nodes_;
};

template <int n>
struct GradedJet {
  using Self = GradedJet;
  enum Kind : unsigned { has_rate = 1, has_g = 2, has_x = 4, has_h = 8 };
  static constexpr int pairs = (n + 1) / 2;

  double value;
  double rate;
  unsigned kinds;
  int leaf;                 // the coordinate that it is, −1: none
  int square;               // place and factor of H
  double factor;
  SquareRecord<n>* record;  // nullptr: of constants and the time
  Pair g[pairs], x[pairs];

  GradedJet() = default;
  template <class Number>
    requires std::is_arithmetic_v<Number>
  GradedJet(Number constant) : value(static_cast<double>(constant)), rate(0.0), kinds(0), leaf(-1), square(0), factor(0.0), record(nullptr) {
    clear();
  }

  static Self coordinate(double q, double qdot, int i, SquareRecord<n>* squares) {
    Self r(q);
    r.rate = qdot;
    r.kinds = has_rate | has_x;
    r.leaf = i;
    r.record = squares;
    set_unit(r.x, i);
    return r;
  }
  static Self velocity(double qdot, int i, SquareRecord<n>* squares) {
    Self r(qdot);
    r.kinds = has_g;
    r.record = squares;
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
    r.record = record;
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
      r.kinds &= ~unsigned(has_h);
      if (f2 != 0.0) r.add_to_hessian(f2, record->add_square(g));
      if (kinds & has_h) r.add_to_hessian(f1 * factor, square);
    }
    return r;
  }

  Self whole() const { return *this; }
  SineAndCosine* place_of_angle() const { return leaf < 0 || record == nullptr ? nullptr : &record->known(leaf); }

 private:
  // Nobody reads a kind that a value does not have, but compilers do not see that and warn the user.
  void clear() {
    for (int j = 0; j < pairs; ++j) g[j] = x[j] = Pair{};
  }
  static void set_unit(Pair* to, int i) {
    for (int j = 0; j < pairs; ++j) to[j] = Pair{i == 2 * j ? 1.0 : 0.0, i == 2 * j + 1 ? 1.0 : 0.0};
  }
  static void set(Pair* to, double c, const Pair* from) {
    for (int j = 0; j < pairs; ++j) to[j] = c * from[j];
  }
  static bool is_zero(const Pair* from) {
    auto different = from[0] != Pair{};
    for (int j = 1; j < pairs; ++j) different |= from[j] != Pair{};
    return (different[0] | different[1]) == 0;
  }
  static void accumulate(Pair* to, double c, const Pair* from) {
    for (int j = 0; j < pairs; ++j) to[j] += c * from[j];
  }

  // H ← H + c (that of a place)
  void add_to_hessian(double c, int place) {
    if (kinds & has_h) {
      square = record->add_sum(factor, square, c, place);
      factor = 1.0;
    } else {
      kinds |= has_h;
      square = place;
      factor = c;
    }
  }

  Self times(double c) const {
    Self r(c * value);
    r.rate = c * rate;
    r.kinds = kinds;
    r.square = square;
    r.factor = c * factor;
    r.record = record;
    if (kinds & has_g) set(r.g, c, g);
    if (kinds & has_x) set(r.x, c, x);
    return r;
  }

  static void add_kind(bool had, bool has, Pair* to, double sign, const Pair* from) {
    if (!has) return;
    if (had) {
      accumulate(to, sign, from);
    } else {
      set(to, sign, from);
    }
  }
  static void add(Self& r, const Self& v, double sign) {
    r.value += sign * v.value;
    r.rate += sign * v.rate;
    r.leaf = -1;
    if (r.record == nullptr) r.record = v.record;
    add_kind(r.kinds & has_g, v.kinds & has_g, r.g, sign, v.g);
    add_kind(r.kinds & has_x, v.kinds & has_x, r.x, sign, v.x);
    if (v.kinds & has_h) r.add_to_hessian(sign * v.factor, v.square);
    r.kinds |= v.kinds;
  }

  void set_product(const Self& u, const Self& v) {
    value = u.value * v.value;
    rate = u.value * v.rate + v.value * u.rate;
    leaf = -1;
    square = 0;
    factor = 0.0;
    clear();
    record = u.record == nullptr ? v.record : u.record;
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
    if (x_is_set && !(kinds & has_g && is_zero(x))) kinds |= has_x;  // X of a velocity is zero
    if (u.kinds & v.kinds & has_g) add_to_hessian(1.0, record->add_product(u.g, v.g));
    if (u.kinds & has_h) add_to_hessian(v.value * u.factor, u.square);
    if (v.kinds & has_h) add_to_hessian(u.value * v.factor, v.square);
  }
};

}  // namespace qdot::detail
