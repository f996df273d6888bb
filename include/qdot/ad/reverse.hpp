#pragma once
// SPDX-License-Identifier: MIT
//
// Gradients of functions of thousands of variables, at the cost of a few evaluations.
//
// Forward derivatives cost one direction for each variable. Backward, each operation y = f(a, b) is written down with its
// two partial derivatives, and one sweep from the result to the variables multiplies them up:
//
//     ā += ȳ ∂f/∂a ,     b̄ += ȳ ∂f/∂b ,     starting from 1 at the result.
//
// The numbers themselves may be duals: then the sweep gives the gradient and its derivative along their directions.
//
// The tape sees besides which variables meet. Second derivatives arise where values are multiplied or put through a
// function, so |i − j| of any nonzero ∂²f/∂x_i∂x_j is at most the widest range of variables in an operation that is not
// linear: the `reach` of the tape. A sum over neighbours has a small one, however long it is. And it counts degrees, so that a
// quadratic function is known to be one, everywhere, when nothing was compared on the way.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/ad/dual_eigen.hpp"
#include "qdot/ad/dual_math.hpp"

namespace qdot::detail {

// A tape of numbers for which this is false sees neither which variables meet nor degrees: for first derivatives, and shorter.
template <class N>
inline constexpr bool tape_sees_meetings = true;
template <>
inline constexpr bool tape_sees_meetings<double> = false;

template <class N>
struct Tape {
  struct Seen {
    int first, last;  // variables it depends on
    int degree;       // as a polynomial in them; `transcendental` when it is none
  };
  struct Unseen {
    Unseen(int, int, int) {}
  };
  struct Node {
    int a, b;  // operands, −1: none
    [[no_unique_address]] std::conditional_t<tape_sees_meetings<N>, Seen, Unseen> seen;
    N along_a, along_b;
    // Made where it stays: copies of numbers that have just been written wait for them.
    Node(int x, int y, int first, int last, int degree, const N& along_x, const N& along_y)
        : a(x), b(y), seen{first, last, degree}, along_a(along_x), along_b(along_y) {}
  };
  static constexpr int transcendental = 1000;

  std::vector<Node> nodes;
  int reach = 0;
  bool compared = false;  // a value that depends on variables was compared: the operations may be others elsewhere

  int variable(int index) {
    nodes.emplace_back(-1, -1, index, index, 1, N(0.0), N(0.0));
    return static_cast<int>(nodes.size()) - 1;
  }
  int degree(int node) const {
    if constexpr (tape_sees_meetings<N>) {
      return node < 0 ? 0 : nodes[static_cast<std::size_t>(node)].seen.degree;
    } else {
      return transcendental;
    }
  }
  int operation(bool linear, int degree, int a, const N& along_a, int b = -1, const N& along_b = N(0.0)) {
    int first = std::numeric_limits<int>::max(), last = 0;
    if constexpr (tape_sees_meetings<N>) {
      for (const int operand : {a, b}) {
        if (operand < 0) continue;
        first = std::min(first, nodes[static_cast<std::size_t>(operand)].seen.first);
        last = std::max(last, nodes[static_cast<std::size_t>(operand)].seen.last);
      }
      if (!linear) reach = std::max(reach, last - first);
    }
    nodes.emplace_back(a, b, first, last, std::min(degree, transcendental), along_a, along_b);
    return static_cast<int>(nodes.size()) - 1;
  }

  // ∂(node)/∂(every node before it).
  void sweep(int from, std::vector<N>& adjoint) const {
    adjoint.assign(nodes.size(), N(0.0));
    if (from < 0) return;
    adjoint[static_cast<std::size_t>(from)] = N(1.0);
    for (std::size_t k = static_cast<std::size_t>(from) + 1; k-- > 0;) {
      const Node& node = nodes[k];
      if (node.a >= 0) adjoint[static_cast<std::size_t>(node.a)] += adjoint[k] * node.along_a;
      if (node.b >= 0) adjoint[static_cast<std::size_t>(node.b)] += adjoint[k] * node.along_b;
    }
  }

  // The same of a node that depends on few others, and only those are seen: visit(variable, share) for each way to a variable. In `waiting` are
  // the nodes that are still to be seen, in their order, and in `adjoint` what those have got so far; both are room to work in.
  template <class Visit>
  void for_each_derivative(int from, int variables, std::vector<int>& waiting, std::vector<N>& adjoint, Visit&& visit) const {
    if (adjoint.size() < nodes.size()) adjoint.resize(nodes.size());
    waiting.clear();
    const auto add = [&](int node, const N& share) {
      if (node < variables) {
        if (node >= 0) visit(node, share);
        return;
      }
      std::size_t at = waiting.size();
      while (at > 0 && waiting[at - 1] > node) --at;
      if (at > 0 && waiting[at - 1] == node) {
        adjoint[static_cast<std::size_t>(node)] += share;
        return;
      }
      adjoint[static_cast<std::size_t>(node)] = share;
      waiting.push_back(node);
      for (std::size_t k = waiting.size() - 1; k > at; --k) std::swap(waiting[k], waiting[k - 1]);
    };
    add(from, N(1.0));
    while (!waiting.empty()) {
      const auto k = static_cast<std::size_t>(waiting.back());
      waiting.pop_back();
      const Node& node = nodes[k];
      add(node.a, adjoint[k] * node.along_a);
      if (node.b >= 0) add(node.b, adjoint[k] * node.along_b);
    }
  }
};

// A number whose operations are written to a tape.
template <class N>
struct Reverse {
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
    return both(true, highest(x, y), x.value + y.value, x, N(1.0), y, N(1.0));
  }
  friend Reverse operator-(const Reverse& x, const Reverse& y) {
    if (y.node < 0) return Reverse(x.value - y.value, x.node, x.tape);
    return both(true, highest(x, y), x.value - y.value, x, N(1.0), y, N(-1.0));
  }
  friend Reverse operator*(const Reverse& x, const Reverse& y) {
    return both(x.node < 0 || y.node < 0, x.degree() + y.degree(), x.value * y.value, x, y.value, y, x.value);
  }
  friend Reverse operator/(const Reverse& x, const Reverse& y) {
    const N inverse = 1.0 / y.value, quotient = x.value / y.value;
    return both(y.node < 0, y.node < 0 ? x.degree() : Tape<N>::transcendental, quotient, x, inverse, y, -(quotient * inverse));
  }
  Reverse& operator+=(const Reverse& o) { return *this = *this + o; }
  Reverse& operator-=(const Reverse& o) { return *this = *this - o; }
  Reverse& operator*=(const Reverse& o) { return *this = *this * o; }
  Reverse& operator/=(const Reverse& o) { return *this = *this / o; }

  friend bool operator==(const Reverse& a, const Reverse& b) { return compared(a, b), a.value == b.value; }
  friend bool operator!=(const Reverse& a, const Reverse& b) { return compared(a, b), a.value != b.value; }
  friend bool operator<(const Reverse& a, const Reverse& b) { return compared(a, b), a.value < b.value; }
  friend bool operator<=(const Reverse& a, const Reverse& b) { return compared(a, b), a.value <= b.value; }
  friend bool operator>(const Reverse& a, const Reverse& b) { return compared(a, b), a.value > b.value; }
  friend bool operator>=(const Reverse& a, const Reverse& b) { return compared(a, b), a.value >= b.value; }

  friend const auto& innermost_value(const Reverse& x) {
    using qdot::innermost_value;
    return innermost_value(x.value);
  }
  int degree() const { return node < 0 ? 0 : tape->degree(node); }
  static int highest(const Reverse& x, const Reverse& y) { return std::max(x.degree(), y.degree()); }
  static void compared(const Reverse& x, const Reverse& y) {
    if (x.node >= 0) x.tape->compared = true;
    if (y.node >= 0) y.tape->compared = true;
  }

  // f(x) from f and f′.
  Reverse through(const N& f, const N& slope) const {
    return node < 0 ? Reverse(f) : Reverse(f, tape->operation(false, Tape<N>::transcendental, node, slope), tape);
  }
  // The same with f as a generic function.
  template <class F>
  Reverse through(const F& f) const {
    using D = Dual<N, 1>;
    const D y = f(D::variable(value, 0));
    return through(y.value, y.tangent[0]);
  }
  Reverse scaled(const N& result, const N& factor) const {
    return node < 0 ? Reverse(result) : Reverse(result, tape->operation(true, degree(), node, factor), tape);
  }
  static Reverse both(bool linear, int degree, const N& result, const Reverse& x, const N& along_x, const Reverse& y, const N& along_y) {
    if (x.node < 0 && y.node < 0) return Reverse(result);
    Tape<N>* const tape = x.node >= 0 ? x.tape : y.tape;
    if (y.node < 0) return Reverse(result, tape->operation(linear, degree, x.node, along_x), tape);
    if (x.node < 0) return Reverse(result, tape->operation(linear, degree, y.node, along_y), tape);
    return Reverse(result, tape->operation(linear, degree, x.node, along_x, y.node, along_y), tape);
  }
};

template <class N>
Reverse<N> sin(const Reverse<N>& x) {
  using std::cos, std::sin;
  return x.through(sin(x.value), cos(x.value));
}
template <class N>
Reverse<N> cos(const Reverse<N>& x) {
  using std::cos, std::sin;
  return x.through(cos(x.value), -sin(x.value));
}
template <class N>
Reverse<N> sqrt(const Reverse<N>& x) {
  using std::sqrt;
  const N root = sqrt(x.value);
  return x.through(root, 0.5 / root);
}
template <class N>
Reverse<N> exp(const Reverse<N>& x) {
  using std::exp;
  const N power = exp(x.value);
  return x.through(power, power);
}
template <class N>
Reverse<N> log(const Reverse<N>& x) { return x.through([](const auto& y) { return log(y); }); }
template <class N> Reverse<N> tan(const Reverse<N>& x) { return x.through([](const auto& y) { return tan(y); }); }
template <class N> Reverse<N> asin(const Reverse<N>& x) { return x.through([](const auto& y) { return asin(y); }); }
template <class N> Reverse<N> acos(const Reverse<N>& x) { return x.through([](const auto& y) { return acos(y); }); }
template <class N> Reverse<N> atan(const Reverse<N>& x) { return x.through([](const auto& y) { return atan(y); }); }
template <class N> Reverse<N> sinh(const Reverse<N>& x) { return x.through([](const auto& y) { return sinh(y); }); }
template <class N> Reverse<N> cosh(const Reverse<N>& x) { return x.through([](const auto& y) { return cosh(y); }); }
template <class N> Reverse<N> tanh(const Reverse<N>& x) { return x.through([](const auto& y) { return tanh(y); }); }
template <class N> Reverse<N> asinh(const Reverse<N>& x) { return x.through([](const auto& y) { return asinh(y); }); }
template <class N> Reverse<N> acosh(const Reverse<N>& x) { return x.through([](const auto& y) { return acosh(y); }); }
template <class N> Reverse<N> atanh(const Reverse<N>& x) { return x.through([](const auto& y) { return atanh(y); }); }
template <class N> Reverse<N> cbrt(const Reverse<N>& x) { return x.through([](const auto& y) { return cbrt(y); }); }
template <class N> Reverse<N> exp2(const Reverse<N>& x) { return x.through([](const auto& y) { return exp2(y); }); }
template <class N> Reverse<N> expm1(const Reverse<N>& x) { return x.through([](const auto& y) { return expm1(y); }); }
template <class N> Reverse<N> log2(const Reverse<N>& x) { return x.through([](const auto& y) { return log2(y); }); }
template <class N> Reverse<N> log10(const Reverse<N>& x) { return x.through([](const auto& y) { return log10(y); }); }
template <class N> Reverse<N> log1p(const Reverse<N>& x) { return x.through([](const auto& y) { return log1p(y); }); }
template <class N> Reverse<N> erf(const Reverse<N>& x) { return x.through([](const auto& y) { return erf(y); }); }
template <class N> Reverse<N> erfc(const Reverse<N>& x) { return x.through([](const auto& y) { return erfc(y); }); }
template <class N, class Number>
  requires std::is_arithmetic_v<Number>
Reverse<N> pow(const Reverse<N>& x, Number k) { return x.through([k](const auto& y) { return pow(y, k); }); }
template <class N, class Number>
  requires std::is_arithmetic_v<Number>
Reverse<N> pow(Number base, const Reverse<N>& x) { return x.through([base](const auto& y) { return pow(base, y); }); }
template <class N>
Reverse<N> pow(const Reverse<N>& x, const Reverse<N>& y) {
  using D = Dual<N, 2>;
  const D z = pow(D::variable(x.value, 0), D::variable(y.value, 1));
  return Reverse<N>::both(false, Tape<N>::transcendental, z.value, x, z.tangent[0], y, z.tangent[1]);
}
template <class A>
inline constexpr bool is_reverse = false;
template <class N>
inline constexpr bool is_reverse<Reverse<N>> = true;
// Two arguments of which at least one is such a number and the other one too, or a plain one.
template <class A, class B>
concept ReverseBeside = (is_reverse<A> && (std::is_same_v<A, B> || std::is_arithmetic_v<B>)) || (is_reverse<B> && std::is_arithmetic_v<A>);
template <class A, class B>
using ReverseOf = std::conditional_t<is_reverse<A>, A, B>;

template <class A, class B>
  requires ReverseBeside<A, B>
auto atan2(const A& a, const B& b) {
  using R = ReverseOf<A, B>;
  const R y(a), x(b);
  using D = Dual<decltype(y.value), 2>;
  const D z = atan2(D::variable(y.value, 0), D::variable(x.value, 1));
  return R::both(false, Tape<decltype(y.value)>::transcendental, z.value, y, z.tangent[0], x, z.tangent[1]);
}
template <class A, class B>
  requires ReverseBeside<A, B>
auto hypot(const A& a, const B& b) {
  using R = ReverseOf<A, B>;
  const R x(a), y(b);
  using D = Dual<decltype(x.value), 2>;
  const D z = hypot(D::variable(x.value, 0), D::variable(y.value, 1));
  return R::both(false, Tape<decltype(x.value)>::transcendental, z.value, x, z.tangent[0], y, z.tangent[1]);
}
// Three arguments of which at least one is such a number.
template <class A, class B, class C>
using ReverseAmong = ReverseOf<A, ReverseOf<B, C>>;
template <class A, class B, class C>
concept ReverseBesideTwo = ReverseBeside<ReverseAmong<A, B, C>, A> && ReverseBeside<ReverseAmong<A, B, C>, B> && ReverseBeside<ReverseAmong<A, B, C>, C>;
template <class A, class B, class C>
  requires ReverseBesideTwo<A, B, C>
auto hypot(const A& x, const B& y, const C& z) { return hypot(hypot(ReverseAmong<A, B, C>(x), ReverseAmong<A, B, C>(y)), ReverseAmong<A, B, C>(z)); }
template <class A, class B, class C>
  requires ReverseBesideTwo<A, B, C>
auto fma(const A& x, const B& y, const C& z) { return ReverseAmong<A, B, C>(x) * ReverseAmong<A, B, C>(y) + ReverseAmong<A, B, C>(z); }
template <class A, class B>
  requires ReverseBeside<A, B>
auto max(const A& a, const B& b) {
  const ReverseOf<A, B> x(a), y(b);
  return x < y ? y : x;
}
template <class A, class B>
  requires ReverseBeside<A, B>
auto min(const A& a, const B& b) {
  const ReverseOf<A, B> x(a), y(b);
  return y < x ? y : x;
}
template <class A, class B>
  requires ReverseBeside<A, B>
auto fmax(const A& a, const B& b) {
  const ReverseOf<A, B> x(a), y(b);
  return isnan(x) ? y : isnan(y) ? x : max(x, y);
}
template <class A, class B>
  requires ReverseBeside<A, B>
auto fmin(const A& a, const B& b) {
  const ReverseOf<A, B> x(a), y(b);
  return isnan(x) ? y : isnan(y) ? x : min(x, y);
}
template <class A, class B>
  requires ReverseBeside<A, B>
auto copysign(const A& a, const B& b) {
  const ReverseOf<A, B> x(a), y(b);
  return signbit(x) == signbit(y) ? x : -x;
}
// Steps: no derivative, but elsewhere another value.
template <class N>
Reverse<N> floor(const Reverse<N>& x) {
  using std::floor;
  Reverse<N>::compared(x, x);
  return Reverse<N>(floor(x.value));
}
template <class N>
Reverse<N> ceil(const Reverse<N>& x) {
  using std::ceil;
  Reverse<N>::compared(x, x);
  return Reverse<N>(ceil(x.value));
}
template <class N>
Reverse<N> abs(const Reverse<N>& x) { return x < Reverse<N>(0.0) ? -x : x; }
template <class N>
Reverse<N> fabs(const Reverse<N>& x) { return abs(x); }
template <class N>
bool isfinite(const Reverse<N>& x) {
  using std::isfinite;
  Reverse<N>::compared(x, x);
  return isfinite(x.value);
}
template <class N>
bool isnan(const Reverse<N>& x) {
  using std::isnan;
  Reverse<N>::compared(x, x);
  return isnan(x.value);
}
template <class N>
bool isinf(const Reverse<N>& x) {
  using std::isinf;
  Reverse<N>::compared(x, x);
  return isinf(x.value);
}
template <class N>
bool signbit(const Reverse<N>& x) {
  using std::signbit;
  Reverse<N>::compared(x, x);
  return signbit(x.value);
}
template <class N>
const Reverse<N>& conj(const Reverse<N>& x) { return x; }
template <class N>
const Reverse<N>& real(const Reverse<N>& x) { return x; }
template <class N>
Reverse<N> imag(const Reverse<N>&) { return Reverse<N>(0.0); }
template <class N>
Reverse<N> abs2(const Reverse<N>& x) { return x * x; }

}  // namespace qdot::detail

template <class N>
struct Eigen::NumTraits<qdot::detail::Reverse<N>> : Eigen::NumTraits<double> {
  using Real = qdot::detail::Reverse<N>;
  using NonInteger = Real;
  using Nested = Real;
  enum { IsInteger = 0, IsSigned = 1, IsComplex = 0, RequireInitialization = 1, ReadCost = 3, AddCost = 20, MulCost = 20 };
};
template <class N, class Number, class Operation>
  requires std::is_arithmetic_v<Number>
struct Eigen::ScalarBinaryOpTraits<qdot::detail::Reverse<N>, Number, Operation> {
  using ReturnType = qdot::detail::Reverse<N>;
};
template <class N, class Number, class Operation>
  requires std::is_arithmetic_v<Number>
struct Eigen::ScalarBinaryOpTraits<Number, qdot::detail::Reverse<N>, Operation> {
  using ReturnType = qdot::detail::Reverse<N>;
};
