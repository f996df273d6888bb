#pragma once
// SPDX-License-Identifier: MIT
//
// A formula as a graph, and its derivatives as more graph.
//
//     constant c          affine ca·a + cb·b + c        quotient a / b        function f(a), or f(a, b)
//     variable x_index    product a · b                 power    aᶜ
//
// A Taylor series of the motion needs Lagrange's equations as operations on power series. So the energies are run once
// through a scalar that writes down every operation (ad/formula/recording.hpp). A formula that occurs twice is one node
// (hash-consing). Making a node simplifies it: constants are folded, factors move outwards, roots and quotients become
// powers. So 1/√(x² + y²) differentiated is −x (x² + y²)^(−3/2) with one power. Coefficients may be such as are
// compared up to rounding (ad/formula/coefficient.hpp), for formulas that are multiplied out.
//
// Differentiation walks back from an output and adds nodes for the chain rule (reverse mode). All partial derivatives
// of one output cost a few times its nodes, and can be differentiated again. A function w = f(a) has a *slope* node
// z = f′(a), which is all that series need: w˙ = z a˙ (ad/series/sweep.hpp).

#include <algorithm>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "qdot/ad/formula/analytic_function.hpp"

namespace qdot::formula {

enum class Kind : std::uint8_t { constant, variable, affine, product, quotient, power, function };

// The number that decides which nodes there are: of a plain number itself.
constexpr double decisive(double x) { return x; }
template <std::floating_point Number>
constexpr Number power_of(Number x, double exponent) {
  return std::pow(x, exponent);
}
// Whether power_of and value_of are to be asked for; without them what is constant is computed with the rest.
template <class Coefficient>
constexpr bool can_be_raised(const Coefficient&, double) {
  return true;
}
template <class Coefficient>
constexpr bool has_known_value(const Coefficient&) {
  return true;
}

/// One operation. Arguments a and b are made before it, so the order of making is an order of computing.
template <class Coefficient>
struct BasicNode {
  Kind kind = Kind::constant;
  Function function = Function::none;
  int a = -1;  ///< argument, or the variable's index
  int b = -1;  ///< second argument; −1 if there is none
  Coefficient ca = 0.0, cb = 0.0;
  Coefficient c = 0.0;  ///< the constant, the affine offset, or the exponent
  Domain domain = Domain::everything;  ///< outside of which what was written down has no value (ad/formula/domains.hpp)
};

/// A formula of any number of outputs; nodes are named by their numbers.
///
/// @tparam Coefficient  double, or Coefficient of ad/formula/coefficient.hpp
template <class Coefficient>
class BasicGraph {
 public:
  using Node = BasicNode<Coefficient>;

  constexpr const std::vector<Node>& nodes() const noexcept { return nodes_; }
  constexpr const Node& operator[](int x) const { return nodes_[static_cast<std::size_t>(x)]; }

  /// A node of another graph, whose arguments have the same numbers here.
  constexpr int copy_of(const Node& node) { return made(node); }
  constexpr void set_domain(int x, Domain domain) { nodes_[static_cast<std::size_t>(x)].domain = domain; }

  constexpr int constant(Coefficient c) { return made({.kind = Kind::constant, .c = c}); }
  constexpr int variable(int index) { return made({.kind = Kind::variable, .a = index}); }
  constexpr bool is_constant(int x, double c) const { return (*this)[x].kind == Kind::constant && decisive((*this)[x].c) == c; }

  constexpr int sum(int x, int y) { return combination(x, 1.0, y, 1.0); }
  constexpr int difference(int x, int y) { return combination(x, 1.0, y, -1.0); }
  [[gnu::noinline]] constexpr int scaled(int x, Coefficient factor) {
    if (decisive(factor) == 1.0) return x;
    if (decisive(factor) == 0.0) return constant(0.0);
    const Node& node = (*this)[x];
    if (node.kind == Kind::constant) return constant(factor * node.c);
    if (node.kind != Kind::affine || node.b >= 0) return made({.kind = Kind::affine, .a = x, .ca = factor});
    const Coefficient ca = factor * node.ca, c = factor * node.c;
    if (decisive(ca) == 1.0 && decisive(c) == 0.0) return node.a;
    return made({.kind = Kind::affine, .a = node.a, .ca = ca, .c = c});
  }

  [[gnu::noinline]] constexpr int product(int x, int y) {
    if (is_plain(x) && is_plain(y)) return made({.kind = Kind::product, .a = std::min(x, y), .b = std::max(x, y)});
    Term tx = term(x), ty = term(y);
    if (tx.node < 0) return scaled(y, tx.offset);
    if (ty.node < 0) return scaled(x, ty.offset);
    if (decisive(tx.offset) != 0.0) tx = {x, 1.0, 0.0};
    if (decisive(ty.offset) != 0.0) ty = {y, 1.0, 0.0};
    const Coefficient factor = tx.factor * ty.factor;
    const Power px = as_power(tx.node), py = as_power(ty.node);
    if (px.base == py.base && (px.exponent != 1.0 || py.exponent != 1.0))
      return scaled(power(px.base, px.exponent + py.exponent), factor);
    return scaled(made({.kind = Kind::product, .a = std::min(tx.node, ty.node), .b = std::max(tx.node, ty.node)}), factor);
  }

  [[gnu::noinline]] constexpr int quotient(int x, int y) {
    Term tx = term(x), ty = term(y);
    if (ty.node < 0 && can_be_raised(ty.offset, -1.0)) return scaled(x, 1.0 / ty.offset);
    if (tx.node < 0) return scaled(power(y, -1.0), tx.offset);
    if (decisive(tx.offset) != 0.0) tx = {x, 1.0, 0.0};
    if (ty.node < 0 || decisive(ty.offset) != 0.0) ty = {y, 1.0, 0.0};
    const Coefficient factor = tx.factor / ty.factor;
    const Power px = as_power(tx.node), py = as_power(ty.node);
    if (px.base == py.base) return scaled(power(px.base, px.exponent - py.exponent), factor);
    if (py.exponent != 1.0) return scaled(product(tx.node, power(py.base, -py.exponent)), factor);
    return scaled(made({.kind = Kind::quotient, .a = tx.node, .b = ty.node}), factor);
  }

  /// xᵉ. Positive whole powers are products, which are right at x = 0.
  [[gnu::noinline]] constexpr int power(int x, double exponent) {
    if (exponent == 0.0) return constant(1.0);
    if (exponent == 1.0) return x;
    const Term t = term(x);
    if (t.node < 0 && can_be_raised(t.offset, exponent)) return constant(power_of(t.offset, exponent));
    if (t.node < 0) return made({.kind = Kind::power, .a = x, .c = exponent});
    const bool whole = is_whole(exponent);
    if (decisive(t.offset) == 0.0 && decisive(t.factor) != 1.0 && (whole || decisive(t.factor) > 0.0) && can_be_raised(t.factor, exponent))
      return scaled(power(t.node, exponent), power_of(t.factor, exponent));
    const Power p = as_power(x);
    if (p.exponent != 1.0 && (whole || !is_whole(p.exponent))) return power(p.base, p.exponent * exponent);
    if (whole && exponent > 0.0) {
      const int half = power(x, static_cast<double>(static_cast<int>(exponent) / 2));
      const int square = product(half, half);
      return static_cast<int>(exponent) % 2 == 0 ? square : product(square, x);
    }
    return made({.kind = Kind::power, .a = x, .c = exponent});
  }

  constexpr int function(Function f, int x, int y = -1) {
    if ((*this)[x].kind == Kind::constant && has_known_value((*this)[x].c) && (y < 0 || (*this)[y].kind == Kind::constant))
      return constant(value_of(f, (*this)[x].c, y < 0 ? Coefficient(0.0) : (*this)[y].c));
    return made({.kind = Kind::function, .function = f, .a = x, .b = y});
  }

  /// ∂w/∂a of a function node w.
  constexpr int slope(int w) {
    const Node node = (*this)[w];
    const int x = node.a;
    const auto affine_square = [&](int u, double factor) {  // 1 + factor u²
      const int square = scaled(product(u, u), factor);
      return sum(square, constant(1.0));
    };
    const auto square_plus = [&](int u, int other) {  // u² + other
      const int square = product(u, u);
      return sum(square, other);
    };
    switch (node.function) {
      case Function::sin: return function(Function::cos, x);
      case Function::cos: return scaled(function(Function::sin, x), -1.0);
      case Function::tan: return affine_square(w, 1.0);
      case Function::asin: return power(affine_square(x, -1.0), -0.5);
      case Function::acos: return scaled(power(affine_square(x, -1.0), -0.5), -1.0);
      case Function::atan: return power(affine_square(x, 1.0), -1.0);
      case Function::atan2: return quotient(node.b, square_plus(x, product(node.b, node.b)));
      case Function::hypot: return quotient(x, w);
      case Function::exp: return w;
      case Function::expm1: return sum(w, constant(1.0));
      case Function::log: return power(x, -1.0);
      case Function::log1p: return power(sum(constant(1.0), x), -1.0);
      case Function::sinh: return function(Function::cosh, x);
      case Function::cosh: return function(Function::sinh, x);
      case Function::tanh: return affine_square(w, -1.0);
      case Function::asinh: return power(affine_square(x, 1.0), -0.5);
      case Function::acosh: return power(square_plus(x, constant(-1.0)), -0.5);
      case Function::atanh: return power(affine_square(x, -1.0), -1.0);
      case Function::cbrt: return scaled(power(w, -2.0), 1.0 / 3.0);
      case Function::erf: return scaled(function(Function::exp, scaled(product(x, x), -1.0)), two_over_root_pi);
      case Function::erfc: return scaled(function(Function::exp, scaled(product(x, x), -1.0)), -two_over_root_pi);
      case Function::none: break;
    }
    return constant(1.0);
  }

  /// ∂w/∂b of atan2(a, b) and hypot(a, b).
  constexpr int second_slope(int w) {
    const Node node = (*this)[w];
    if (node.function == Function::hypot) return quotient(node.b, w);
    const int square = product(node.b, node.b);
    return scaled(quotient(node.a, sum(product(node.a, node.a), square)), -1.0);
  }

  /// factor·node + offset; node −1 for a constant.
  struct Term {
    int node;
    Coefficient factor, offset;
  };
  /// A node without the factor and the offset that it has.
  constexpr Term term(int x) const {
    const Node& node = (*this)[x];
    if (node.kind == Kind::constant) return {-1, 0.0, node.c};
    if (node.kind == Kind::affine && node.b < 0) return {node.a, node.ca, node.c};
    return {x, 1.0, 0.0};
  }

  /// Whether a node depends on one of these variables, for each of the nodes up to `last`; if there are ends, otherwise than through these.
  constexpr std::vector<char> dependence(int last, std::span<const int> variables, std::span<const int> ends = {}) const {
    std::vector<char> depends(static_cast<std::size_t>(last) + 1, 0);
    for (const int x : variables)
      if (x <= last) depends[static_cast<std::size_t>(x)] = 1;
    for (std::size_t w = 0; w < depends.size(); ++w) {
      const Node& node = nodes_[w];
      if (node.kind == Kind::constant || node.kind == Kind::variable) continue;
      if (depends[static_cast<std::size_t>(node.a)] != 0 || (node.b >= 0 && depends[static_cast<std::size_t>(node.b)] != 0))
        depends[w] = std::find(ends.begin(), ends.end(), static_cast<int>(w)) == ends.end();
    }
    return depends;
  }

  /// Whether a node is an output or an argument of what leads to one; −1 is no output.
  constexpr std::vector<char> needed_for(std::span<const int> outputs) const {
    std::vector<char> needed(nodes_.size(), 0);
    for (const int x : outputs)
      if (x >= 0) needed[static_cast<std::size_t>(x)] = 1;
    for (std::size_t w = needed.size(); w-- > 0;) {
      const Node& node = nodes_[w];
      if (needed[w] == 0 || node.kind == Kind::constant || node.kind == Kind::variable) continue;
      needed[static_cast<std::size_t>(node.a)] = 1;
      if (node.b >= 0) needed[static_cast<std::size_t>(node.b)] = 1;
    }
    return needed;
  }

  /// ∂output/∂x for each of the variables x, as nodes.
  [[gnu::noinline]] constexpr std::vector<int> gradient(int output, std::span<const int> variables) {
    return gradient(output, variables, std::vector<char>(static_cast<std::size_t>(output) + 1, 1));
  }

  /// ∂output/∂x for each variable, where it is known which nodes depend on them: the others are left out.
  [[gnu::noinline]] constexpr std::vector<int> gradient(int output, std::span<const int> variables, const std::vector<char>& depends) {
    const int zero = constant(0.0);
    std::vector<int> adjoint(static_cast<std::size_t>(output) + 1, -1);
    adjoint.back() = constant(1.0);
    const auto leads_on = [&](int x) { return x >= 0 && depends[static_cast<std::size_t>(x)] != 0; };
    const auto add = [&](int x, int contribution) {
      int& sum_so_far = adjoint[static_cast<std::size_t>(x)];
      sum_so_far = sum_so_far < 0 ? contribution : sum(sum_so_far, contribution);
    };
    for (int w = output; w >= 0; --w)
      if (const int bar = adjoint[static_cast<std::size_t>(w)]; bar >= 0 && bar != zero) pass_back(w, bar, leads_on, add);
    std::vector<int> result;
    for (const int x : variables)
      result.push_back(x <= output && adjoint[static_cast<std::size_t>(x)] >= 0 ? adjoint[static_cast<std::size_t>(x)] : zero);
    return result;
  }

  /// The chain rule from node w, whose share in a derivative is the node `bar`, to its arguments: add(argument, share) for those that lead on.
  template <class LeadsOn, class Add>
  constexpr void pass_back(int w, int bar, const LeadsOn& leads_on, const Add& add) {
    const Node node = (*this)[w];
    switch (node.kind) {
      case Kind::affine:
        if (leads_on(node.a)) add(node.a, scaled(bar, node.ca));
        if (leads_on(node.b)) add(node.b, scaled(bar, node.cb));
        break;
      case Kind::product:
        if (leads_on(node.a)) add(node.a, product(bar, node.b));
        if (leads_on(node.b)) add(node.b, product(bar, node.a));
        break;
      case Kind::quotient: {
        const int share = quotient(bar, node.b);
        if (leads_on(node.a)) add(node.a, share);
        if (leads_on(node.b)) add(node.b, scaled(product(share, w), -1.0));
        break;
      }
      case Kind::power:
        if (leads_on(node.a)) add(node.a, product(bar, scaled(power(node.a, exponent_of(node) - 1.0), node.c)));
        break;
      case Kind::function:
        if (leads_on(node.a)) add(node.a, product(bar, slope(w)));
        if (leads_on(node.b)) add(node.b, product(bar, second_slope(w)));
        break;
      default: break;
    }
  }

 private:
  static constexpr double two_over_root_pi = 1.12837916709551257390;

  struct Power {
    int base;
    double exponent;
  };

  // Nothing to be taken out of it.
  constexpr bool is_plain(int x) const {
    const Kind kind = (*this)[x].kind;
    return kind == Kind::variable || kind == Kind::product || kind == Kind::quotient || kind == Kind::function;
  }
  constexpr Power as_power(int x) const {
    const Node& node = (*this)[x];
    return node.kind == Kind::power ? Power{node.a, exponent_of(node)} : Power{x, 1.0};
  }

  // fx·x + fy·y in its simplest form.
  [[gnu::noinline]] constexpr int combination(int x, Coefficient fx, int y, Coefficient fy) {
    const Term tx = term(x), ty = term(y);
    int a = tx.node, b = ty.node;
    Coefficient ca = fx * tx.factor, cb = fy * ty.factor;
    const Coefficient c = fx * tx.offset + fy * ty.offset;
    if (a == b) {
      ca += cb;
      b = -1;
    }
    if (b >= 0 && decisive(cb) == 0.0) b = -1;
    if (a < 0 || decisive(ca) == 0.0) {
      a = b;
      ca = cb;
      b = -1;
    }
    if (a < 0) return constant(c);
    if (b < 0 && decisive(ca) == 1.0 && decisive(c) == 0.0) return a;
    if (b < 0) return made({.kind = Kind::affine, .a = a, .ca = ca, .c = c});
    if (a > b) {
      std::swap(a, b);
      std::swap(ca, cb);
    }
    return made({.kind = Kind::affine, .a = a, .b = b, .ca = ca, .cb = cb, .c = c});
  }

  static constexpr bool is_whole(double x) {
    return x >= -1e9 && x <= 1e9 && x == static_cast<double>(static_cast<int>(x));
  }
  static constexpr double exponent_of(const Node& node) { return decisive(node.c); }

  // The number of this node, old if there is one like it: a table of numbers, in which those of one hash stand behind each other.
  [[gnu::noinline]] constexpr int made(const Node& node) {
    if (2 * (nodes_.size() + 1) > places_.size()) {
      places_.assign(places_.empty() ? 64 : 4 * places_.size(), -1);
      nodes_.reserve(places_.size() / 2);
      for (std::size_t i = 0; i < nodes_.size(); ++i) places_[place_of(nodes_[i])] = static_cast<int>(i);
    }
    const std::size_t place = place_of(node);
    if (places_[place] < 0) {
      places_[place] = static_cast<int>(nodes_.size());
      nodes_.push_back(node);
    }
    return places_[place];
  }

  // Where the number of a node like this one stands, or would.
  constexpr std::size_t place_of(const Node& node) const {
    const double ca = decisive(node.ca), cb = decisive(node.cb), c = decisive(node.c);
    constexpr std::uint64_t odd = 0x9E3779B97F4A7C15u;  // 2⁶⁴/golden ratio
    const std::uint64_t numbers = std::bit_cast<std::uint64_t>(0.25 * ca + 0.125 * cb + 0.5 * c + 0.0);  // −0 as 0
    const std::uint64_t names = static_cast<std::uint64_t>(static_cast<std::int64_t>(node.a) * 65599 + node.b) * 1024 +
                                static_cast<std::uint64_t>(node.kind) * 32 + static_cast<std::uint64_t>(node.function);
    const std::uint64_t h = (names * odd ^ (numbers >> 17) ^ numbers) * odd;
    const std::size_t mask = places_.size() - 1;
    for (std::size_t place = static_cast<std::size_t>(h >> 32) & mask;; place = (place + 1) & mask) {
      const int number = places_[place];
      if (number < 0) return place;
      const Node& other = nodes_[static_cast<std::size_t>(number)];
      if (other.a == node.a && other.b == node.b && other.kind == node.kind && other.function == node.function && decisive(other.ca) == ca &&
          decisive(other.cb) == cb && decisive(other.c) == c)
        return place;
    }
  }

  std::vector<Node> nodes_;
  std::vector<int> places_;
};

using Node = BasicNode<double>;
using Graph = BasicGraph<double>;

#ifdef QDOT_COMPILED
extern template class BasicGraph<double>;
#endif

}  // namespace qdot::formula
