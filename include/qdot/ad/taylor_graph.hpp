#pragma once
// SPDX-License-Identifier: MIT
//
// A formula as a graph, and its derivatives as more graph.
//
// A Taylor series of the motion needs Lagrange's equations not as numbers at one state, but as a
// recipe that can be carried out on power series. So the energies are run once through a scalar that
// computes nothing and writes down every operation (taylor_recording.hpp). What it writes is this graph:
//
//     node              value                             node              value
//     constant          c                                 quotient          a / b
//     variable          x_index                           power             aᶜ
//     affine            ca·a + cb·b + c                   function          f(a), or f(a, b)
//     product           a · b
//
// Every node is made once: a formula that occurs twice is the same node (hash-consing), so the cosine
// that T and V have in common is computed once. Making a node also simplifies it: constants are folded,
// factors move outwards, roots and quotients become powers and powers of one base are multiplied,
// 1/√(x² + y²) differentiated is −x (x² + y²)^(−3/2) with one power and not a tower of quotients.
//
// Differentiation walks the graph backwards from an output and adds nodes for the chain rule (reverse
// mode): all partial derivatives of one output cost a few times the nodes of the output. The result is
// graph again, and can be differentiated again.
//
// A function's derivative is f′(a) = a *slope* node z. For series that is all there is to know about f:
// w = f(u) has w˙ = z u˙, hence  k w_k = Σ_{j=1…k} (j u_j) z_{k−j}  (taylor_sweep.hpp).

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

namespace qdot::taylor {

enum class Kind : std::uint8_t { constant, variable, affine, product, quotient, power, function };

enum class Function : std::uint8_t {
  none, sin, cos, tan, asin, acos, atan, atan2, exp, expm1, log, log1p, sinh, cosh, tanh, asinh, acosh, atanh, cbrt, erf, erfc
};

/// The value of a function at a plain number; y is atan2's second argument.
inline double value_of(Function f, double x, double y = 0.0) {
  switch (f) {
    case Function::none: return x;
    case Function::sin: return std::sin(x);
    case Function::cos: return std::cos(x);
    case Function::tan: return std::tan(x);
    case Function::asin: return std::asin(x);
    case Function::acos: return std::acos(x);
    case Function::atan: return std::atan(x);
    case Function::atan2: return std::atan2(x, y);
    case Function::exp: return std::exp(x);
    case Function::expm1: return std::expm1(x);
    case Function::log: return std::log(x);
    case Function::log1p: return std::log1p(x);
    case Function::sinh: return std::sinh(x);
    case Function::cosh: return std::cosh(x);
    case Function::tanh: return std::tanh(x);
    case Function::asinh: return std::asinh(x);
    case Function::acosh: return std::acosh(x);
    case Function::atanh: return std::atanh(x);
    case Function::cbrt: return std::cbrt(x);
    case Function::erf: return std::erf(x);
    case Function::erfc: return std::erfc(x);
  }
  return x;
}

/// One operation. Arguments a and b are made before it, so the order of making is an order of computing.
struct Node {
  Kind kind = Kind::constant;
  Function function = Function::none;
  int a = -1;  ///< argument, or the variable's index
  int b = -1;  ///< second argument; −1 if there is none
  double ca = 0.0, cb = 0.0;
  double c = 0.0;  ///< the constant, the affine offset, or the exponent
};

/// A formula of any number of outputs; nodes are named by their numbers.
class Graph {
 public:
  const std::vector<Node>& nodes() const noexcept { return nodes_; }
  const Node& operator[](int x) const { return nodes_[static_cast<std::size_t>(x)]; }

  int constant(double c) { return made({.kind = Kind::constant, .c = c}); }
  int variable(int index) { return made({.kind = Kind::variable, .a = index}); }
  bool is_constant(int x, double c) const { return (*this)[x].kind == Kind::constant && (*this)[x].c == c; }

  int sum(int x, int y) { return combination(x, 1.0, y, 1.0); }
  int difference(int x, int y) { return combination(x, 1.0, y, -1.0); }
  int scaled(int x, double factor) { return combination(x, factor, constant(0.0), 0.0); }

  [[gnu::noinline]] int product(int x, int y) {
    Term tx = term(x), ty = term(y);
    if (tx.node < 0) return scaled(y, tx.offset);
    if (ty.node < 0) return scaled(x, ty.offset);
    if (tx.offset != 0.0) tx = {x, 1.0, 0.0};
    if (ty.offset != 0.0) ty = {y, 1.0, 0.0};
    const double factor = tx.factor * ty.factor;
    const Power px = as_power(tx.node), py = as_power(ty.node);
    if (px.base == py.base && (px.exponent != 1.0 || py.exponent != 1.0))
      return scaled(power(px.base, px.exponent + py.exponent), factor);
    return scaled(made({.kind = Kind::product, .a = std::min(tx.node, ty.node), .b = std::max(tx.node, ty.node)}), factor);
  }

  [[gnu::noinline]] int quotient(int x, int y) {
    Term tx = term(x), ty = term(y);
    if (ty.node < 0) return scaled(x, 1.0 / ty.offset);
    if (tx.node < 0) return scaled(power(y, -1.0), tx.offset);
    if (tx.offset != 0.0) tx = {x, 1.0, 0.0};
    if (ty.offset != 0.0) ty = {y, 1.0, 0.0};
    const double factor = tx.factor / ty.factor;
    const Power px = as_power(tx.node), py = as_power(ty.node);
    if (px.base == py.base) return scaled(power(px.base, px.exponent - py.exponent), factor);
    if (py.exponent != 1.0) return scaled(product(tx.node, power(py.base, -py.exponent)), factor);
    return scaled(made({.kind = Kind::quotient, .a = tx.node, .b = ty.node}), factor);
  }

  /// xᵉ. Positive whole powers are products, which are right at x = 0.
  [[gnu::noinline]] int power(int x, double exponent) {
    if (exponent == 0.0) return constant(1.0);
    if (exponent == 1.0) return x;
    const Term t = term(x);
    if (t.node < 0) return constant(std::pow(t.offset, exponent));
    const bool whole = exponent == std::floor(exponent);
    if (t.offset == 0.0 && t.factor != 1.0 && (t.factor > 0.0 || whole))
      return scaled(power(t.node, exponent), std::pow(t.factor, exponent));
    const Power p = as_power(x);
    if (p.exponent != 1.0 && (whole || p.exponent != std::floor(p.exponent))) return power(p.base, p.exponent * exponent);
    if (whole && exponent > 0.0 && exponent <= 64.0) {
      const int half = power(x, std::floor(exponent / 2));
      const int square = product(half, half);
      return std::fmod(exponent, 2.0) == 0.0 ? square : product(square, x);
    }
    return made({.kind = Kind::power, .a = x, .c = exponent});
  }

  int function(Function f, int x, int y = -1) {
    if ((*this)[x].kind == Kind::constant && (y < 0 || (*this)[y].kind == Kind::constant))
      return constant(value_of(f, (*this)[x].c, y < 0 ? 0.0 : (*this)[y].c));
    return made({.kind = Kind::function, .function = f, .a = x, .b = y});
  }

  /// ∂w/∂a of a function node w.
  int slope(int w) {
    const Node node = (*this)[w];
    const int x = node.a;
    const auto affine_square = [&](int u, double factor) {  // 1 + factor u²
      return sum(constant(1.0), scaled(product(u, u), factor));
    };
    switch (node.function) {
      case Function::sin: return function(Function::cos, x);
      case Function::cos: return scaled(function(Function::sin, x), -1.0);
      case Function::tan: return affine_square(w, 1.0);
      case Function::asin: return power(affine_square(x, -1.0), -0.5);
      case Function::acos: return scaled(power(affine_square(x, -1.0), -0.5), -1.0);
      case Function::atan: return power(affine_square(x, 1.0), -1.0);
      case Function::atan2: return quotient(node.b, sum(product(x, x), product(node.b, node.b)));
      case Function::exp: return w;
      case Function::expm1: return sum(w, constant(1.0));
      case Function::log: return power(x, -1.0);
      case Function::log1p: return power(sum(constant(1.0), x), -1.0);
      case Function::sinh: return function(Function::cosh, x);
      case Function::cosh: return function(Function::sinh, x);
      case Function::tanh: return affine_square(w, -1.0);
      case Function::asinh: return power(affine_square(x, 1.0), -0.5);
      case Function::acosh: return power(sum(product(x, x), constant(-1.0)), -0.5);
      case Function::atanh: return power(affine_square(x, -1.0), -1.0);
      case Function::cbrt: return scaled(power(w, -2.0), 1.0 / 3.0);
      case Function::erf: return scaled(function(Function::exp, scaled(product(x, x), -1.0)), two_over_root_pi);
      case Function::erfc: return scaled(function(Function::exp, scaled(product(x, x), -1.0)), -two_over_root_pi);
      case Function::none: break;
    }
    return constant(1.0);
  }

  /// ∂w/∂b of atan2(a, b).
  int second_slope(int w) {
    const Node node = (*this)[w];
    return scaled(quotient(node.a, sum(product(node.a, node.a), product(node.b, node.b))), -1.0);
  }

  /// ∂output/∂x for each of the variables x, as nodes.
  [[gnu::noinline]] std::vector<int> gradient(int output, std::span<const int> variables) {
    std::vector<int> adjoint(static_cast<std::size_t>(output) + 1, constant_zero());
    adjoint.back() = constant(1.0);
    const auto add = [&](int x, int contribution) {
      int& sum_so_far = adjoint[static_cast<std::size_t>(x)];
      sum_so_far = sum(sum_so_far, contribution);
    };
    for (int w = output; w >= 0; --w) {
      const int bar = adjoint[static_cast<std::size_t>(w)];
      if (is_constant(bar, 0.0)) continue;
      const Node node = (*this)[w];
      switch (node.kind) {
        case Kind::constant:
        case Kind::variable: break;
        case Kind::affine:
          add(node.a, scaled(bar, node.ca));
          if (node.b >= 0) add(node.b, scaled(bar, node.cb));
          break;
        case Kind::product:
          add(node.a, product(bar, node.b));
          add(node.b, product(bar, node.a));
          break;
        case Kind::quotient: {
          const int share = quotient(bar, node.b);
          add(node.a, share);
          add(node.b, scaled(product(share, w), -1.0));
          break;
        }
        case Kind::power: add(node.a, product(bar, scaled(power(node.a, node.c - 1.0), node.c))); break;
        case Kind::function:
          add(node.a, product(bar, slope(w)));
          if (node.b >= 0) add(node.b, product(bar, second_slope(w)));
          break;
      }
    }
    std::vector<int> result;
    for (const int x : variables)
      result.push_back(x <= output ? adjoint[static_cast<std::size_t>(x)] : constant_zero());
    return result;
  }

 private:
  static constexpr double two_over_root_pi = 1.12837916709551257390;

  struct Term {  // factor·node + offset; node −1 for a constant
    int node;
    double factor, offset;
  };
  struct Power {
    int base;
    double exponent;
  };

  int constant_zero() { return constant(0.0); }

  Term term(int x) const {
    const Node& node = (*this)[x];
    if (node.kind == Kind::constant) return {-1, 0.0, node.c};
    if (node.kind == Kind::affine && node.b < 0) return {node.a, node.ca, node.c};
    return {x, 1.0, 0.0};
  }

  Power as_power(int x) const {
    const Node& node = (*this)[x];
    return node.kind == Kind::power ? Power{node.a, node.c} : Power{x, 1.0};
  }

  // fx·x + fy·y in its simplest form.
  [[gnu::noinline]] int combination(int x, double fx, int y, double fy) {
    const Term tx = term(x), ty = term(y);
    int a = tx.node, b = ty.node;
    double ca = fx * tx.factor, cb = fy * ty.factor;
    const double c = fx * tx.offset + fy * ty.offset;
    if (a == b) {
      ca += cb;
      b = -1;
    }
    if (b >= 0 && cb == 0.0) b = -1;
    if (a < 0 || ca == 0.0) {
      a = b;
      ca = cb;
      b = -1;
    }
    if (a < 0) return constant(c);
    if (b < 0 && ca == 1.0 && c == 0.0) return a;
    if (b < 0) return made({.kind = Kind::affine, .a = a, .ca = ca, .c = c});
    if (a > b) {
      std::swap(a, b);
      std::swap(ca, cb);
    }
    return made({.kind = Kind::affine, .a = a, .b = b, .ca = ca, .cb = cb, .c = c});
  }

  // The number of this node, old if there is one like it.
  [[gnu::noinline]] int made(const Node& node) {
    const auto bits = [](double x) { return std::bit_cast<std::uint64_t>(x + 0.0); };  // −0 as 0
    const Key key{static_cast<std::uint64_t>(node.kind) << 8 | static_cast<std::uint64_t>(node.function),
                  static_cast<std::uint64_t>(static_cast<std::int64_t>(node.a)),
                  static_cast<std::uint64_t>(static_cast<std::int64_t>(node.b)), bits(node.ca), bits(node.cb), bits(node.c)};
    const auto [place, is_new] = known_.try_emplace(key, static_cast<int>(nodes_.size()));
    if (is_new) nodes_.push_back(node);
    return place->second;
  }

  using Key = std::array<std::uint64_t, 6>;
  struct Hash {
    std::size_t operator()(const Key& key) const noexcept {
      std::uint64_t h = 0;
      for (const std::uint64_t word : key) h = (h ^ word ^ (h >> 29)) * 0x9E3779B97F4A7C15u;  // 2⁶⁴/golden ratio, odd
      return static_cast<std::size_t>(h ^ (h >> 32));
    }
  };
  std::vector<Node> nodes_;
  std::unordered_map<Key, int, Hash> known_;
};

}  // namespace qdot::taylor
