#pragma once
// SPDX-License-Identifier: MIT
//
// Coriolis and centrifugal terms, as formulas.
//
// Lagrange's equations are M q̈ + c = Q − ∂V/∂q with
//
//     c_i = d/dt ∂T/∂q̇_i − ∂T/∂q_i   at q̈ = 0 .
//
// As it stands that is a walk back through T for p = ∂T/∂q̇, another for ∂T/∂q and one forwards for ṗ, and much of what they find cancels. But most
// kinetic energies are sums of squares and products k u w of velocities, u = Ẋ for some function X(q, t) that nobody has to know. Of such a rate
// d/dt ∂u/∂q̇_i = ∂u/∂q_i (Lagrange's lemma, by which d'Alembert's principle becomes his equations). So the product contributes
//
//     c_i = k (∂u/∂q̇_i ẇ + ∂w/∂q̇_i u̇)   at q̈ = 0 ,
//
// masses times accelerations along each coordinate: one walk forwards for all u̇ and one back. Chains of links need half of the operations.
//
// That u is a rate is seen where it is a sum of f(φ) φ̇, with φ any formula of q and t: l cos(θ) θ̇, cos(α + β) (α̇ + β̇), ẋ; and where it is made of X by
// the chain rule, as velocities of places are. What is not, like the r θ̇ of polar coordinates, is differentiated as it stands.

#include <algorithm>
#include <cstddef>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/ad/formula/coefficient.hpp"
#include "qdot/mechanics/derive/derived_equations.hpp"
#include "qdot/mechanics/derive/rates_of_nodes.hpp"

namespace qdot::detail {

// What its numbers are.
template <class Graph>
using FactorOf = std::remove_cvref_t<decltype(std::declval<const Graph&>()[0].c)>;

/// c as nodes. Variables are q, q̇, t.
template <class Graph>
class CoriolisTerms {
 public:
  constexpr CoriolisTerms(RatesOfNodes<Graph>& rates, int n)
      : graph_(rates.graph()), rates_(rates), q_(variables_of(graph_, 0, n)), qdot_(variables_of(graph_, n, n)), n_(n) {}

  constexpr std::vector<int> of(int T) {
    begin(T);
    rates_.remember(rated());
    return terms();
  }

 private:
  // What T consists of.
  constexpr void begin(int T) {
    tell_kinds(T);
    moves_ = graph_.dependence(T, qdot_);
    const int rest = without_products(T);
    if (graph_[rest].kind == formula::Kind::constant) return;
    p_ = graph_.gradient(rest, qdot_, graph_.dependence(rest, qdot_));
    along_q_ = graph_.gradient(rest, q_, graph_.dependence(rest, q_));
  }
  // Whose rates are needed.
  constexpr std::vector<int> rated() const {
    std::vector<int> nodes = p_;
    for (const Product& x : products_) nodes.push_back(x.u), nodes.push_back(x.w);
    return nodes;
  }
  constexpr std::vector<int> terms() {
    std::vector<int> c = terms_of_products();
    for (std::size_t i = 0; i < p_.size(); ++i) c[i] = graph_.sum(c[i], graph_.difference(rates_.of(p_[i]), along_q_[i]));
    return c;
  }

  // What a node is: a formula of q and t, and then of which node alone; f(φ) φ̇ of a node φ; another rate; or none of these.
  enum class Is : unsigned char { constant, position, rate_of_one, rate, other };
  struct Known {
    Is is = Is::other;
    int base = -1;  // φ
  };

  static constexpr std::size_t at(int x) { return static_cast<std::size_t>(x); }
  constexpr bool is_time(const Known& k) const { return k.is == Is::position && graph_[k.base].kind == formula::Kind::variable && graph_[k.base].a == 2 * n_; }
  constexpr bool is_rate(const Known& k) const { return k.is == Is::constant || k.is == Is::rate_of_one || k.is == Is::rate || is_time(k); }

  constexpr void tell_kinds(int last) {
    known_.reserve(at(last) + 1);
    rates_.remember_to(last);
    std::vector<char> is_rate_of_position(at(last) + 1, 0);
    for (int x = 0; x <= last; ++x) {
      Known known = kind_of(x);
      if (known.is == Is::other && is_rate_of_position[at(x)] != 0) known.is = Is::rate;
      if (known.is == Is::position && known.base == x && graph_[x].kind != formula::Kind::variable) {
        const int rate = rates_.of(x);
        if (rate <= last) is_rate_of_position[at(rate)] = 1;
      }
      known_.push_back(known);
    }
  }
  constexpr Known kind_of(int x) {
    const typename Graph::Node w = graph_[x];
    if (w.kind == formula::Kind::constant) return {Is::constant, -1};
    if (w.kind == formula::Kind::variable) {
      if (w.a < n_ || w.a == 2 * n_) return {Is::position, x};
      return w.a < 2 * n_ ? Known{Is::rate_of_one, q_[at(w.a - n_)]} : Known{Is::constant, -1};  // a parameter
    }
    const Known a = known_[at(w.a)], b = w.b < 0 ? Known{Is::constant, -1} : known_[at(w.b)];
    const auto is_of_position = [](const Known& k) { return k.is == Is::constant || k.is == Is::position; };
    if (a.is == Is::constant && b.is == Is::constant) return a;
    if (is_of_position(a) && is_of_position(b))
      return {Is::position, b.is == Is::constant || a.base == b.base ? a.base : a.is == Is::constant ? b.base : x};
    const bool is_alike = a.base == b.base && a.is == Is::rate_of_one && b.is == Is::rate_of_one;
    switch (w.kind) {
      case formula::Kind::affine:
        if (formula::decisive(w.c) == 0.0 && (is_alike || (w.b < 0 && a.is == Is::rate_of_one))) return a;
        return is_rate(a) && is_rate(b) ? Known{Is::rate, -1} : Known{};
      case formula::Kind::product:
        if (a.is == Is::constant && is_rate(b)) return b;
        if (b.is == Is::constant && is_rate(a)) return a;
        if (a.is == Is::position && is_rate_of(w.b, a.base)) return {Is::rate_of_one, a.base};
        if (b.is == Is::position && is_rate_of(w.a, b.base)) return {Is::rate_of_one, b.base};
        return {};
      case formula::Kind::quotient:
        if (b.is == Is::constant && is_rate(a)) return a;
        return b.is == Is::position && is_rate_of(w.a, b.base) ? Known{Is::rate_of_one, b.base} : Known{};
      default: return {};
    }
  }
  // Whether y is f(φ) φ̇.
  constexpr bool is_rate_of(int y, int phi) {
    const Known& k = known_[at(y)];
    return (k.is == Is::rate_of_one && k.base == phi) || (is_rate(k) && rates_.of(phi) == y);
  }

  // T but for products of two rates, which are listed.
  constexpr int without_products(int T) {
    std::vector<FactorOf<Graph>> factor(at(T) + 1, 0.0);
    factor[at(T)] = 1.0;
    int rest = graph_.constant(0.0);
    for (int x = T; x >= 0; --x) {
      const typename Graph::Node w = graph_[x];
      const auto k = factor[at(x)];
      if (formula::decisive(k) == 0.0) continue;
      if (w.kind == formula::Kind::affine) {
        factor[at(w.a)] += k * w.ca;
        if (w.b >= 0) factor[at(w.b)] += k * w.cb;
      } else if (w.kind == formula::Kind::product && is_rate(known_[at(w.a)]) && is_rate(known_[at(w.b)])) {
        products_.push_back({w.a, w.b, k});
      } else {
        rest = graph_.sum(rest, graph_.scaled(x, k));
      }
    }
    return rest;
  }
  // A walk back that begins with k ẇ at u and k u̇ at w.
  constexpr std::vector<int> terms_of_products() {
    const std::size_t nodes = known_.size();
    std::vector<int> adjoint(nodes, -1);
    const auto leads_on = [&](int x) { return x >= 0 && moves_[at(x)] != 0; };
    const auto add = [&](int x, int share) {
      int& sum = adjoint[at(x)];
      sum = sum < 0 ? share : graph_.sum(sum, share);
    };
    for (const Product& x : products_) {
      add(x.u, graph_.scaled(rates_.of(x.w), x.k));
      add(x.w, graph_.scaled(rates_.of(x.u), x.k));
    }
    for (int x = static_cast<int>(nodes) - 1; x >= 0; --x)
      if (const int share = adjoint[at(x)]; share >= 0 && !graph_.is_constant(share, 0.0)) graph_.pass_back(x, share, leads_on, add);
    std::vector<int> terms;
    for (const int v : qdot_) terms.push_back(at(v) < nodes && adjoint[at(v)] >= 0 ? without_equal_products(adjoint[at(v)]) : graph_.constant(0.0));
    return terms;
  }
  // A node that is k (P − P′) + d, with the same factors in another order, is d: sin·(cos·q̇²) − cos·(sin·q̇²) of a pendulum.
  constexpr int without_equal_products(int x) {
    const typename Graph::Node w = graph_[x];
    if (w.kind != formula::Kind::affine || w.b < 0 || !formula::are_alike(w.ca, w.cb * -1.0)) return x;
    return factors(w.a) == factors(w.b) ? graph_.constant(w.c) : x;
  }
  // In the order of their numbers; of many, not all are taken apart.
  constexpr std::vector<int> factors(int x) const {
    std::vector<int> found{x};
    for (std::size_t k = 0; k < found.size() && found.size() < 16;) {
      const typename Graph::Node& w = graph_[found[k]];
      if (w.kind != formula::Kind::product) {
        ++k;
        continue;
      }
      found[k] = w.a;
      found.push_back(w.b);
    }
    std::sort(found.begin(), found.end());
    return found;
  }

  struct Product {
    int u, w;
    FactorOf<Graph> k;
  };

  Graph& graph_;
  RatesOfNodes<Graph>& rates_;
  std::vector<int> q_, qdot_;
  int n_;
  std::vector<Known> known_;    // of each node that T consists of
  std::vector<char> moves_;     // whether it depends on q̇
  std::vector<Product> products_;
  std::vector<int> p_, along_q_;  // of the rest
};

}  // namespace qdot::detail
