#pragma once
// SPDX-License-Identifier: MIT
//
// The record of an evaluation, and the derivatives of X L from it.
//
// A value on a node of the record (ad/lagrange/graded.hpp) is a function of that node alone: of q_i and q̇_i at a coordinate, of the node's
// value u and rate Du elsewhere. While the energies are evaluated, derivatives are therefore taken with respect to the *two local variables* of
// one node: each of the numbers value, D, a, b is a dual number with a pair for its tangent. Only where two nodes meet in a
// new one, the derivatives with respect to both pairs are written down.
//
// What that means for all q and q̇ is found afterwards, in rows as long as there are directions:
//
//     forwards     δu, δDu      from those of the two nodes that met,
//     backwards    A, B of ad/records/hessian_record.hpp and δA, δB,      X_i L = B_i and its derivatives δB_i at the leaves.
//
// A number that does not depend on the variables, the 1 of a plain sum or the A of what is only added, has no row.

#include <algorithm>
#include <type_traits>

#include "qdot/ad/dual.hpp"
#include "qdot/ad/records/hessian_record.hpp"

namespace qdot::detail {

// A dual number with derivatives along two variables. Like a double it is not initialized.
struct LocalDual {
  using Self = LocalDual;

  double value;
  double along[2];

  LocalDual() = default;
  template <class Constant>
    requires std::is_arithmetic_v<Constant>
  LocalDual(Constant constant) : value(static_cast<double>(constant)), along{0.0, 0.0} {}
  LocalDual(double value_, double first, double second) : value(value_), along{first, second} {}

  // f(x) from f and f′ at x.
  Self through(double f, double slope) const { return Self(f, slope * along[0], slope * along[1]); }

  friend Self operator-(const Self& x) { return x.through(-x.value, -1.0); }
  friend Self operator+(const Self& x, const Self& y) { return Self(x.value + y.value, x.along[0] + y.along[0], x.along[1] + y.along[1]); }
  friend Self operator-(const Self& x, const Self& y) { return Self(x.value - y.value, x.along[0] - y.along[0], x.along[1] - y.along[1]); }
  friend Self operator*(const Self& x, const Self& y) {
    return Self(x.value * y.value, x.along[0] * y.value + y.along[0] * x.value, x.along[1] * y.value + y.along[1] * x.value);
  }
  friend Self operator*(double c, const Self& x) { return x.through(c * x.value, c); }
  friend Self operator/(const Self& x, const Self& y) {
    const double quotient = x.value / y.value, inverse = 1.0 / y.value;
    return Self(quotient, (x.along[0] - quotient * y.along[0]) * inverse, (x.along[1] - quotient * y.along[1]) * inverse);
  }
  friend Self operator/(double c, const Self& y) {
    const double quotient = c / y.value;
    return y.through(quotient, -quotient / y.value);
  }

  friend bool operator==(const Self& x, const Self& y) { return x.value == y.value; }
  friend bool operator!=(const Self& x, const Self& y) { return x.value != y.value; }
  friend bool operator<(const Self& x, const Self& y) { return x.value < y.value; }
  friend bool operator<=(const Self& x, const Self& y) { return x.value <= y.value; }
  friend bool operator>(const Self& x, const Self& y) { return x.value > y.value; }
  friend bool operator>=(const Self& x, const Self& y) { return x.value >= y.value; }
};

// The plain number in it, beside those of duals.
using qdot::innermost_value;
inline const double& innermost_value(const LocalDual& x) { return x.value; }

// f(x) from f and f′, and f(x, y) from f, ∂f/∂x, ∂f/∂y.
inline LocalDual lifted(const LocalDual& x, double f, double slope) { return x.through(f, slope); }
inline LocalDual lifted(const LocalDual& x, const LocalDual& y, double f, double f_x, double f_y) {
  return LocalDual(f, f_x * x.along[0] + f_y * y.along[0], f_x * x.along[1] + f_y * y.along[1]);
}

// In place of the weights of second derivatives that nobody asks for.
struct NoWeight {
  NoWeight() = default;
  constexpr NoWeight(double) {}
  friend constexpr NoWeight operator+(NoWeight x, NoWeight) { return x; }
  template <class Factor>
  friend constexpr NoWeight operator*(const Factor&, NoWeight x) { return x; }
};

// `usual`: nodes that need no allocation.
template <int usual>
class ResidualRecord : public KnownAngles<32> {
 public:
  using Number = LocalDual;
  using Weight = NoWeight;
  static constexpr int width = 32;  // directions of one sweep

  // The nodes 0 … n − 1 are the coordinates.
  explicit ResidualRecord(int n) : leaves_(n) {}
  ResidualRecord(const ResidualRecord&) = delete;
  ResidualRecord& operator=(const ResidualRecord&) = delete;

  // The node of u v, or of u + sign v, of values on different nodes.
  template <class Value>
  int add_product(const Value& u, const Value& v) {
    Node& node = nodes_.push();
    node.left = product_side(u, v);
    node.right = product_side(v, u);
    return leaves_ + nodes_.size() - 1;
  }
  // The node of F(u, v) from its derivatives: first by u and by v, and so on.
  struct Slopes {
    double f_u, f_uu, f_uv, f_uuu, f_uuv, f_uvv;
  };
  template <class Value>
  int add_function(const Value& u, const Slopes& of_u, const Value& v, const Slopes& of_v) {
    Node& node = nodes_.push();
    node.left = function_side(u, v, of_u);
    node.right = function_side(v, u, of_v);
    return leaves_ + nodes_.size() - 1;
  }
  template <class Value>
  int add_sum(const Value& u, const Value& v, double sign) {
    Node& node = nodes_.push();
    node.left = sum_side(u, 1.0);
    node.right = sum_side(v, sign);
    return leaves_ + nodes_.size() - 1;
  }

  // Calls f(i, first, row) for each coordinate: the derivatives of X_i L along q_{first/2}, q̇_{first/2}, the next coordinate's …,
  // `width` of them. L = (a, b) of a node.
  template <class F>
  void derivatives(int root, const Number& a, const Number& b, const F& f) {
    const int inner = nodes_.size(), all = leaves_ + inner;
    const int columns = std::min(width, (2 * leaves_ + 3) / 4 * 4);
    sums_.resize(all);
    forwards_.resize(2 * columns * inner);
    backwards_.resize(2 * columns * all);
    for (int first = 0; first < 2 * leaves_; first += columns) {
      window_ = {first, columns};
      for (int k = leaves_; k < all; ++k) {
        const Node& node = nodes_[k - leaves_];
        double *const u = row(forwards_, k - leaves_, 0), *const rate = row(forwards_, k - leaves_, 1);
        std::fill(u, u + 2 * columns, 0.0);
        for (const Side* side : {&node.left, &node.right}) {
          add_locals(u, 1.0, side->value, side->node);
          add_locals(rate, 1.0, side->rate, side->node);
        }
      }
      for (int k = 0; k < all; ++k) sums_[k] = {0.0, 0.0, false, false};
      if (root >= 0) {
        sums_[root].a = a.value;
        sums_[root].b = b.value;
        add_to_row(root, 0, 1.0, a.along, root);
        add_to_row(root, 1, 1.0, b.along, root);
      }
      for (int k = all - 1; k >= leaves_; --k) {
        const Node& node = nodes_[k - leaves_];
        sweep_to(node.left, node.right.node, k);
        sweep_to(node.right, node.left.node, k);
      }
      for (int i = 0; i < leaves_; ++i) {
        double* const result = row(backwards_, i, 1);
        if (!sums_[i].b_moves) std::fill(result, result + columns, 0.0);
        f(i, first, result);
      }
    }
  }

 private:
  // What one of the two nodes contributes: factors a and b, and how everything depends on its own two variables and on the other's.
  struct Side {
    int node;
    double a, b;
    double value[2], rate[2];             // ∂u and ∂Du, own
    double own_a[2], own_b[2];            // ∂a and ∂b, own
    double other_a[2], other_b[2];        // and of the other node
  };
  struct Node {
    Side left, right;
  };
  struct Sums {
    double a, b;
    bool a_moves, b_moves;  // δA, δB are there
  };
  struct Window {
    int first, columns;
  };

  template <class Value>
  static Side product_side(const Value& u, const Value& v) {
    Side s;
    s.node = u.node;
    s.a = v.value.value * u.a.value;
    s.b = v.value.value * u.b.value - v.rate.value * u.a.value;
    for (int d = 0; d < 2; ++d) {
      s.value[d] = v.value.value * u.value.along[d];
      s.rate[d] = v.rate.value * u.value.along[d] + v.value.value * u.rate.along[d];
      s.own_a[d] = v.value.value * u.a.along[d];
      s.own_b[d] = v.value.value * u.b.along[d] - v.rate.value * u.a.along[d];
      s.other_a[d] = u.a.value * v.value.along[d];
      s.other_b[d] = u.b.value * v.value.along[d] - u.a.value * v.rate.along[d];
    }
    return s;
  }
  // The same where F_u is not v but a function of both.
  template <class Value>
  static Side function_side(const Value& u, const Value& v, const Slopes& F) {
    Side s;
    s.node = u.node;
    const double rate = F.f_uu * u.rate.value + F.f_uv * v.rate.value;  // D F_u
    s.a = F.f_u * u.a.value;
    s.b = F.f_u * u.b.value - rate * u.a.value;
    for (int d = 0; d < 2; ++d) {
      const double du = u.value.along[d], dv = v.value.along[d];
      const double own_rate = (F.f_uuu * u.rate.value + F.f_uuv * v.rate.value) * du + F.f_uu * u.rate.along[d];
      const double other_rate = (F.f_uuv * u.rate.value + F.f_uvv * v.rate.value) * dv + F.f_uv * v.rate.along[d];
      s.value[d] = F.f_u * du;
      s.rate[d] = rate * du + F.f_u * u.rate.along[d];
      s.own_a[d] = F.f_u * u.a.along[d] + F.f_uu * du * u.a.value;
      s.own_b[d] = F.f_u * u.b.along[d] + F.f_uu * du * u.b.value - rate * u.a.along[d] - own_rate * u.a.value;
      s.other_a[d] = F.f_uv * dv * u.a.value;
      s.other_b[d] = F.f_uv * dv * u.b.value - other_rate * u.a.value;
    }
    return s;
  }
  template <class Value>
  static Side sum_side(const Value& u, double sign) {
    Side s;
    s.node = u.node;
    s.a = sign * u.a.value;
    s.b = sign * u.b.value;
    for (int d = 0; d < 2; ++d) {
      s.value[d] = sign * u.value.along[d];
      s.rate[d] = sign * u.rate.along[d];
      s.own_a[d] = sign * u.a.along[d];
      s.own_b[d] = sign * u.b.along[d];
      s.other_a[d] = s.other_b[d] = 0.0;
    }
    return s;
  }

  template <class Rows>
  double* row(Rows& rows, int k, int which) { return &rows[(2 * k + which) * window_.columns]; }

  [[gnu::always_inline]] static void add_multiple(double* to, double c, const double* from, int columns) {
    for (int j = 0; j < columns; j += 4) add_block(to + j, c, from + j);
  }
  // to ← to + c (x[0] δ(first variable of k) + x[1] δ(second))
  void add_locals(double* to, double c, const double* x, int k) {
    if (k < leaves_) {
      const int column = 2 * k - window_.first;
      if (column < 0 || column >= window_.columns) return;
      to[column] += c * x[0];
      to[column + 1] += c * x[1];
    } else {
      if (x[0] != 0.0) add_multiple(to, c * x[0], row(forwards_, k - leaves_, 0), window_.columns);
      if (x[1] != 0.0) add_multiple(to, c * x[1], row(forwards_, k - leaves_, 1), window_.columns);
    }
  }
  // The row of δA or δB of a node, for something that is added to it.
  double* moving_row(int k, int which) {
    double* const to = row(backwards_, k, which);
    bool& moves = which == 0 ? sums_[k].a_moves : sums_[k].b_moves;
    if (!moves) {
      std::fill(to, to + window_.columns, 0.0);
      moves = true;
    }
    return to;
  }
  void add_to_row(int to, int which, double c, const double* x, int k) {
    if (c != 0.0 && (x[0] != 0.0 || x[1] != 0.0)) add_locals(moving_row(to, which), c, x, k);
  }

  // A_side += A a,  B_side += A b + B a, and their derivatives.
  void sweep_to(const Side& side, int other, int k) {
    const Sums& own = sums_[k];
    Sums& sums = sums_[side.node];
    sums.a += own.a * side.a;
    sums.b += own.a * side.b + own.b * side.a;
    if (side.node >= leaves_) {  // nobody asks for A of a leaf
      add_to_row(side.node, 0, own.a, side.own_a, side.node);
      add_to_row(side.node, 0, own.a, side.other_a, other);
      if (own.a_moves && side.a != 0.0) add_multiple(moving_row(side.node, 0), side.a, row(backwards_, k, 0), window_.columns);
    }
    const double ours[2] = {own.a * side.own_b[0] + own.b * side.own_a[0], own.a * side.own_b[1] + own.b * side.own_a[1]};
    const double theirs[2] = {own.a * side.other_b[0] + own.b * side.other_a[0], own.a * side.other_b[1] + own.b * side.other_a[1]};
    add_to_row(side.node, 1, 1.0, ours, side.node);
    add_to_row(side.node, 1, 1.0, theirs, other);
    if (own.a_moves && side.b != 0.0) add_multiple(moving_row(side.node, 1), side.b, row(backwards_, k, 0), window_.columns);
    if (own.b_moves && side.a != 0.0) add_multiple(moving_row(side.node, 1), side.a, row(backwards_, k, 1), window_.columns);
  }

  int leaves_;
  Window window_{0, 0};
  ShortStack<Node, usual> nodes_;
  ShortStack<Sums, usual> sums_;
  ShortStack<double, usual * width> forwards_;
  ShortStack<double, usual * width> backwards_;
};

}  // namespace qdot::detail
