#pragma once
// SPDX-License-Identifier: MIT
//
// Gradients of functions of thousands of variables, at the cost of a few evaluations.
//
//     ā += ȳ ∂f/∂a ,     b̄ += ȳ ∂f/∂b        for each operation y = f(a, b), in one sweep back from 1 at the result
//
// Forward derivatives cost one direction for each variable. Here operations are written down with their partial
// derivatives. The numbers may be duals: then the sweep gives the gradient and its derivative along their directions.
// (For the functions of <cmath> see ad/records/reverse.hpp.) The tape also sees which variables meet in a product or a
// function. |i − j| of any nonzero ∂²f/∂x_i∂x_j is at most the widest range of variables in an operation that is not
// linear: its `reach`, small for a sum over neighbours. Plain numbers have a tape of their own. There an operation is
// written down only where two meet that depend on different variables or operations. What is done to one alone is kept
// beside it as its slope: to add ½ m v² is one operation, the sum. (With duals a product for the slope costs as much as
// one in the sweep.) These count degrees, too: a quadratic function is known to be one everywhere, if nothing was
// compared on the way, and so is a quadratic form without other terms.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <vector>

#include "qdot/ad/dual_eigen.hpp"
#include "qdot/ad/dual_math.hpp"

namespace qdot::detail {

template <class N>
struct Reverse;

template <class N>
struct Tape {
  struct Node {
    int a, b;         // operands, −1: none
    int first, last;  // variables it depends on
    N along_a, along_b;
    // Made where it stays: copies of numbers that have just been written wait for them.
    Node(int x, int y, int lowest, int highest, const N& along_x, const N& along_y)
        : a(x), b(y), first(lowest), last(highest), along_a(along_x), along_b(along_y) {}
  };

  std::vector<Node> nodes;
  int reach = 0;

  Tape(Eigen::Index variables, Eigen::Index expected) { nodes.reserve(static_cast<std::size_t>(variables + expected)); }

  /// The next variable, at a node; number `index` where neighbours are counted.
  Reverse<N> variable(Eigen::Index node, const N& value, Eigen::Index index) {
    nodes.emplace_back(-1, -1, static_cast<int>(index), static_cast<int>(index), N(0.0), N(0.0));
    return Reverse<N>(value, static_cast<int>(node), this);
  }
  Reverse<N> variable(Eigen::Index node, const N& value) { return variable(node, value, node); }

  int operation(bool linear, int a, const N& along_a, int b = -1, const N& along_b = N(0.0)) {
    int first = std::numeric_limits<int>::max(), last = 0;
    for (const int operand : {a, b}) {
      if (operand < 0) continue;
      first = std::min(first, nodes[static_cast<std::size_t>(operand)].first);
      last = std::max(last, nodes[static_cast<std::size_t>(operand)].last);
    }
    if (!linear) reach = std::max(reach, last - first);
    nodes.emplace_back(a, b, first, last, along_a, along_b);
    return static_cast<int>(nodes.size()) - 1;
  }

  // ∂x/∂(every node).
  void sweep(const Reverse<N>& x, std::vector<N>& adjoint) const {
    adjoint.assign(nodes.size(), N(0.0));
    if (x.node < 0) return;
    adjoint[static_cast<std::size_t>(x.node)] = N(1.0);
    for (std::size_t k = static_cast<std::size_t>(x.node) + 1; k-- > 0;) {
      const Node& node = nodes[k];
      if (node.a >= 0) adjoint[static_cast<std::size_t>(node.a)] += adjoint[k] * node.along_a;
      if (node.b >= 0) adjoint[static_cast<std::size_t>(node.b)] += adjoint[k] * node.along_b;
    }
  }
};

// A number whose operations are written to a tape.
template <class N>
struct Reverse : ComparedByValue<Reverse<N>> {
  N value{0.0};
  int node = -1;  // −1: no variable in it
  Tape<N>* tape = nullptr;

  Reverse() = default;
  template <class Number>
    requires(std::is_arithmetic_v<Number> || std::is_same_v<Number, N>)
  Reverse(const Number& constant) : value(constant) {}
  Reverse(const N& v, int k, Tape<N>* t) : value(v), node(k), tape(t) {}

  friend Reverse operator+(const Reverse& x) { return x; }
  friend Reverse operator-(const Reverse& x) { return x.scaled(-x.value, N(-1.0)); }
  friend Reverse operator+(const Reverse& x, const Reverse& y) {
    if (y.node < 0) return Reverse(x.value + y.value, x.node, x.tape);
    if (x.node < 0) return Reverse(x.value + y.value, y.node, y.tape);
    return met(true, x.value + y.value, x, N(1.0), y, N(1.0));
  }
  friend Reverse operator-(const Reverse& x, const Reverse& y) {
    if (y.node < 0) return Reverse(x.value - y.value, x.node, x.tape);
    return met(true, x.value - y.value, x, N(1.0), y, N(-1.0));
  }
  friend Reverse operator*(const Reverse& x, const Reverse& y) { return met(x.node < 0 || y.node < 0, x.value * y.value, x, y.value, y, x.value); }
  friend Reverse operator/(const Reverse& x, const Reverse& y) {
    const N inverse = 1.0 / y.value, quotient = x.value / y.value;
    return met(y.node < 0, quotient, x, inverse, y, -(quotient * inverse));
  }
  Reverse& operator+=(const Reverse& o) { return *this = *this + o; }
  Reverse& operator-=(const Reverse& o) { return *this = *this - o; }
  Reverse& operator*=(const Reverse& o) { return *this = *this * o; }
  Reverse& operator/=(const Reverse& o) { return *this = *this / o; }

  friend decltype(auto) innermost_value(const Reverse& x) {
    using qdot::innermost_value;
    return innermost_value(x.value);
  }
  static void compared(const Reverse&, const Reverse&) {}

  // f(x) from f and f′.
  Reverse through(const N& f, const N& slope) const {
    return node < 0 ? Reverse(f) : Reverse(f, tape->operation(false, node, slope), tape);
  }
  // f(x, y) from f and its derivatives.
  static Reverse both(const N& f, const Reverse& x, const N& by_x, const Reverse& y, const N& by_y) { return met(false, f, x, by_x, y, by_y); }

 private:
  Reverse scaled(const N& result, const N& factor) const { return node < 0 ? Reverse(result) : Reverse(result, tape->operation(true, node, factor), tape); }
  static Reverse met(bool linear, const N& result, const Reverse& x, const N& along_x, const Reverse& y, const N& along_y) {
    if (x.node < 0 && y.node < 0) return Reverse(result);
    Tape<N>* const tape = x.node >= 0 ? x.tape : y.tape;
    if (y.node < 0) return Reverse(result, tape->operation(linear, x.node, along_x), tape);
    if (x.node < 0) return Reverse(result, tape->operation(linear, y.node, along_y), tape);
    return Reverse(result, tape->operation(linear, x.node, along_x, y.node, along_y), tape);
  }
};

template <>
struct Reverse<double>;

template <>
struct Tape<double> {
  struct Operation {
    int a, b;
    double along_a, along_b;
    // Made where it stays: copies of numbers that have just been written wait for them.
    Operation(int x, int y, double along_x, double along_y) : a(x), b(y), along_a(along_x), along_b(along_y) {}
  };

  int variables, nodes;  // those that come first, and all
  std::vector<Operation> operations;
  int reach = 0;
  bool compared = false;  // a value that depends on variables was compared: the operations may be others elsewhere

  // Room for many operations, most of all that an evaluation asks for. What is not touched costs nothing. glibc gives 128 kB that are freed back to
  // the system, and twice the largest block once that was more. So it does not fetch the same pages again at each evaluation.
  explicit Tape(Eigen::Index count) : variables(static_cast<int>(count)), nodes(variables) {
    operations.reserve(static_cast<std::size_t>(std::max<Eigen::Index>(12 * count, 6000)));
  }

  const Operation& operation(int node) const { return operations[static_cast<std::size_t>(node - variables)]; }

  /// The variable at a node; number `index` where neighbours are counted.
  Reverse<double> variable(Eigen::Index node, double value, Eigen::Index index);
  Reverse<double> variable(Eigen::Index node, double value);

  // ∂x/∂(every node).
  void sweep(const Reverse<double>& x, std::vector<double>& adjoint) const;
};

template <>
struct Reverse<double> {
  static constexpr int transcendental = 1000;

  double value, slope;  // the slope is that by the node
  int node;
  std::int16_t lowest, degree;  // of its terms as a polynomial in the variables; `transcendental` when it is none
  int first, last;              // variables it depends on
  Tape<double>* tape;           // none: no variable in it

  Reverse() = default;  // trivial, like double's
  template <class Number>
    requires std::is_arithmetic_v<Number>
  Reverse(Number constant) : value(static_cast<double>(constant)), slope(0.0), node(-1), lowest(0), degree(0), first(0), last(0), tape(nullptr) {}
  Reverse(double v, double s, int k, int least, int most, int lowest_index, int highest_index, Tape<double>* t)
      : value(v), slope(s), node(k), lowest(static_cast<std::int16_t>(least)), degree(static_cast<std::int16_t>(most)),
        first(lowest_index), last(highest_index),
        tape(t) {}

  friend Reverse operator+(const Reverse& x) { return x; }
  friend Reverse operator-(const Reverse& x) { return x.with(-x.value, -x.slope); }
  [[gnu::always_inline]] friend Reverse operator+(const Reverse& x, const Reverse& y) {
    const double sum = x.value + y.value;
    return !y.tape ? x.plus(y.value, sum, x.slope) : !x.tape ? y.plus(x.value, sum, y.slope) : met(true, sum, x, x.slope, y, y.slope);
  }
  [[gnu::always_inline]] friend Reverse operator-(const Reverse& x, const Reverse& y) {
    const double difference = x.value - y.value;
    return !y.tape ? x.plus(y.value, difference, x.slope) : !x.tape ? y.plus(x.value, difference, -y.slope) : met(true, difference, x, x.slope, y, -y.slope);
  }
  [[gnu::always_inline]] friend Reverse operator*(const Reverse& x, const Reverse& y) {
    const double product = x.value * y.value;
    if (!y.tape) return x.with(product, y.value * x.slope);
    if (!x.tape) return y.with(product, x.value * y.slope);
    return met(false, product, x, y.value * x.slope, y, x.value * y.slope, x.lowest + y.lowest, x.degree + y.degree);
  }
  friend Reverse operator/(const Reverse& x, const Reverse& y) {
    const double inverse = 1.0 / y.value, quotient = x.value / y.value;
    return y.tape ? both(quotient, x, inverse, y, -(quotient * inverse)) : x.with(quotient, inverse * x.slope);
  }
  Reverse& operator+=(const Reverse& o) { return *this = *this + o; }
  Reverse& operator-=(const Reverse& o) { return *this = *this - o; }
  Reverse& operator*=(const Reverse& o) { return *this = *this * o; }
  Reverse& operator/=(const Reverse& o) { return *this = *this / o; }

  // With plain numbers: no product rule.
  template <class Number>
    requires std::is_arithmetic_v<Number>
  friend Reverse operator*(const Reverse& x, Number k) { return x.with(x.value * k, x.slope * k); }
  template <class Number>
    requires std::is_arithmetic_v<Number>
  friend Reverse operator*(Number k, const Reverse& x) { return x.with(x.value * k, x.slope * k); }
  template <class Number>
    requires std::is_arithmetic_v<Number>
  friend Reverse operator/(const Reverse& x, Number k) { return x.with(x.value / k, x.slope / k); }

  friend bool operator==(const Reverse& a, const Reverse& b) { return compared(a, b), a.value == b.value; }
  friend bool operator!=(const Reverse& a, const Reverse& b) { return compared(a, b), a.value != b.value; }
  friend bool operator<(const Reverse& a, const Reverse& b) { return compared(a, b), a.value < b.value; }
  friend bool operator<=(const Reverse& a, const Reverse& b) { return compared(a, b), a.value <= b.value; }
  friend bool operator>(const Reverse& a, const Reverse& b) { return compared(a, b), a.value > b.value; }
  friend bool operator>=(const Reverse& a, const Reverse& b) { return compared(a, b), a.value >= b.value; }

  friend const double& innermost_value(const Reverse& x) { return x.value; }
  /// True of a sum of squares and products of two variables, with no other terms; everywhere, when nothing was compared.
  bool is_quadratic_form() const { return tape && lowest == 2 && degree == 2; }
  static void compared(const Reverse& x, const Reverse& y) {
    if (x.tape) x.tape->compared = true;
    if (y.tape) y.tape->compared = true;
  }

  // f(x) from f and f′.
  Reverse through(double f, double by_x) const {
    if (!tape) return Reverse(f);
    tape->reach = std::max(tape->reach, last - first);
    return Reverse(f, by_x * slope, node, 0, transcendental, first, last, tape);
  }
  // f(x, y) from f and its derivatives.
  static Reverse both(double f, const Reverse& x, double by_x, const Reverse& y, double by_y) {
    if (!x.tape) return y.through(f, by_y);
    if (!y.tape) return x.through(f, by_x);
    return met(false, f, x, by_x * x.slope, y, by_y * y.slope, 0, transcendental);
  }

 private:
  Reverse with(double result, double new_slope) const { return Reverse(result, new_slope, node, lowest, degree, first, last, tape); }
  Reverse plus(double constant, double result, double new_slope) const {
    return Reverse(result, new_slope, node, constant == 0.0 ? lowest : 0, degree, first, last, tape);
  }
  // Of two that depend on variables. Degrees are those of a sum where it is linear.
  [[gnu::always_inline]] static Reverse met(bool linear, double result, const Reverse& x, double along_x, const Reverse& y, double along_y, int least = 0,
                                            int most = 0) {
    Tape<double>& tape = *x.tape;
    const int first = std::min(x.first, y.first), last = std::max(x.last, y.last);
    if (linear) {
      least = std::min(x.lowest, y.lowest);
      most = std::max(x.degree, y.degree);
    } else {
      tape.reach = std::max(tape.reach, last - first);
      least = std::min(least, transcendental);
      most = std::min(most, transcendental);
    }
    if (x.node == y.node) return Reverse(result, along_x + along_y, x.node, least, most, first, last, &tape);
    tape.operations.emplace_back(x.node, y.node, along_x, along_y);
    return Reverse(result, 1.0, tape.nodes++, least, most, first, last, &tape);
  }
};

inline Reverse<double> Tape<double>::variable(Eigen::Index node, double value, Eigen::Index index) {
  return Reverse<double>(value, 1.0, static_cast<int>(node), 1, 1, static_cast<int>(index), static_cast<int>(index), this);
}
inline Reverse<double> Tape<double>::variable(Eigen::Index node, double value) { return variable(node, value, node); }

inline void Tape<double>::sweep(const Reverse<double>& x, std::vector<double>& adjoint) const {
  adjoint.assign(static_cast<std::size_t>(nodes), 0.0);
  if (!x.tape) return;
  adjoint[static_cast<std::size_t>(x.node)] = x.slope;
  for (int k = x.node; k >= variables; --k) {
    const Operation& made = operation(k);
    const double share = adjoint[static_cast<std::size_t>(k)];
    adjoint[static_cast<std::size_t>(made.a)] += share * made.along_a;
    adjoint[static_cast<std::size_t>(made.b)] += share * made.along_b;
  }
}

}  // namespace qdot::detail
