#pragma once
// SPDX-License-Identifier: MIT
//
// Lagrange's equations in closed form, derived as one derives them on paper.
//
// The operations of T and V are a graph (ad/formula/graph.hpp), and T, multiplied out, is a polynomial in the velocities with coefficients that are
// products of functions of the position (ad/formula/velocity_polynomial.hpp):
//
//     T = Σ c μ(q) q̇_a q̇_b  + …
//
// Then, term by term and with like terms added up,
//
//     M_ij = ∂²T/∂q̇_i∂q̇_j ,      r_i = ∂T/∂q_i − (d/dt ∂T/∂q̇_i at q̈ = 0) − ∂V/∂q_i ,      M q̈ = r .
//
// What an expert would see is seen: terms that cancel are gone, and cos² + sin² is 1.

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "qdot/ad/formula/polynomial_node.hpp"
#include "qdot/ad/formula/velocity_polynomial.hpp"
#include "qdot/mechanics/derive/derived_equations.hpp"

namespace qdot::detail {

/// Derives them.
class DerivationByTerms {
 public:
  using Coefficient = formula::Coefficient;
  using Polynomial = formula::Polynomial;
  using Term = formula::Term;
  using Node = formula::BasicNode<Coefficient>;
  using Graph = formula::BasicGraph<Coefficient>;

  Graph graph;
  bool is_possible = true;  // false: T is no quadratic form that can be multiplied out, or not worth it

  // Variables are q, q̇ and t.
  constexpr explicit DerivationByTerms(int n) : n_(n) {
    for (int i = 0; i < 2 * n + 1; ++i) graph.variable(i);
  }

  /// T, M and r as sums of terms, for code that prints them.
  struct Terms {
    Polynomial kinetic;
    std::vector<Polynomial> mass, right;  // lower triangle, row by row
  };
  constexpr Terms terms(int T, int V) {
    Terms e{.kinetic = {}, .mass = std::vector<Polynomial>(at(n_ * (n_ + 1) / 2)), .right = std::vector<Polynomial>(at(n_))};
    if (is_possible) e.kinetic = polynomial_of(T);
    if (is_possible) simplify(e.kinetic);
    if (is_possible) derive(T, V, e.mass, e.right);
    is_possible = is_possible && monomials_.is_complete();
    return e;
  }
  constexpr const formula::MonomialTable& monomials() const { return monomials_; }

  /// x − y z / pivot, for elimination.
  constexpr Polynomial reduced(const Polynomial& x, const Polynomial& y, const Polynomial& z, const Term& pivot) {
    Term factor = inverse(pivot);
    factor.c = -factor.c;
    const Polynomial l = formula::product_of(y, {factor}, monomials_);
    Polynomial p = formula::sum_of(x, formula::product_of(l, z, monomials_));
    simplify(p);
    return p;
  }

  /// M, r, and r − M a differentiated at fixed a.
  constexpr DerivedJacobian jacobian_by_terms(int T, int V) {
    DerivedJacobian jacobian;
    std::vector<Polynomial> M(at(n_ * (n_ + 1) / 2)), r(at(n_));
    if (is_possible) derive(T, V, M, r);
    if (!is_possible) return jacobian;
    for (const Polynomial& p : M) jacobian.mass.push_back(p.empty() ? -1 : node_of(p));
    for (const Polynomial& p : r) jacobian.right.push_back(node_of(p));
    differentiate(graph, n_, jacobian);
    is_possible = monomials_.is_complete();
    return jacobian;
  }

 private:
  static constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }
  static constexpr std::size_t entry(int i, int j) { return at(i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i); }

  constexpr void simplify(Polynomial& p) {
    formula::simplify_squares(p, monomials_, [this](int atom) {
      const Node& node = graph[atom];
      return node.kind == formula::Kind::function && node.function == formula::Function::sin ? graph.function(formula::Function::cos, node.a) : -1;
    });
  }

  constexpr int node_of(const Polynomial& p) { return formula::PolynomialNodes(graph, monomials_, n_).node_of(p); }

  // A function of the position as one term.
  constexpr Term term_of(int node) {
    const Node& w = graph[node];
    switch (w.kind) {
      case formula::Kind::constant: return {w.c};
      case formula::Kind::affine:
        if (w.b < 0 && decisive(w.c) == 0.0) return times(term_of(w.a), {w.ca});
        break;
      case formula::Kind::product: {
        const int a = w.a, b = w.b;
        return times(term_of(a), term_of(b));
      }
      case formula::Kind::quotient: {
        const int a = w.a, b = w.b;
        return times(term_of(a), inverse(term_of(b)));
      }
      case formula::Kind::power: {
        const double e = decisive(w.c);
        if (e == static_cast<double>(static_cast<int>(e)) && e >= -8.0) {
          Term t = term_of(w.a);
          t.c = formula::power_of(t.c, e);
          t.monomial = monomials_.power(t.monomial, static_cast<int>(e));
          return t;
        }
        break;
      }
      default: break;
    }
    return {1.0, monomials_.atom(node)};
  }
  constexpr Term times(const Term& x, const Term& y) { return {x.c * y.c, monomials_.product(x.monomial, y.monomial), x.a, x.b}; }
  constexpr Term inverse(const Term& x) { return {1.0 / x.c, monomials_.power(x.monomial, -1)}; }

  // x₁ − x₀ − l, and sums of such.
  constexpr bool is_sum_of_coordinates(int node) const {
    const Node& w = graph[node];
    if (w.kind == formula::Kind::variable) return true;
    return w.kind == formula::Kind::affine && is_sum_of_coordinates(w.a) && (w.b < 0 || is_sum_of_coordinates(w.b));
  }

  // A node in terms, with sums as sums, but for those of coordinates.
  constexpr Polynomial terms_of(int node) {
    const Node w = graph[node];
    if (w.kind != formula::Kind::affine || (w.b >= 0 && is_sum_of_coordinates(node))) {
      const Term t = term_of(node);
      Polynomial one;
      if (decisive(t.c) != 0.0) one.push_back(t);
      return one;
    }
    Polynomial p = formula::scaled(terms_of(w.a), w.ca);
    if (w.b >= 0) p = formula::sum_of(p, terms_of(w.b), w.cb);
    if (decisive(w.c) != 0.0) p = formula::sum_of(p, {Term{w.c}});
    return p;
  }

  // What a node is as a polynomial in the velocities.
  constexpr Polynomial polynomial_of(int output) {
    std::vector<Polynomial> of(at(output) + 1);
    std::vector<int> velocities;
    for (int i = 0; i < n_; ++i) velocities.push_back(graph.variable(n_ + i));
    const std::vector<char> needed = graph.needed_for(std::span<const int>(&output, 1)), moves = graph.dependence(output, velocities);
    for (int w = 0; w <= output && is_possible; ++w) {
      if (needed[at(w)] == 0) continue;
      const Node node = graph[w];
      Polynomial& p = of[at(w)];
      if (moves[at(w)] == 0) {
        const Term t = term_of(w);
        if (decisive(t.c) != 0.0) p.push_back(t);
        continue;
      }
      switch (node.kind) {
        case formula::Kind::variable: p = {Term{1.0, 0, node.a - n_}}; break;
        case formula::Kind::affine:
          p = formula::scaled(of[at(node.a)], node.ca);
          if (node.b >= 0) p = formula::sum_of(p, of[at(node.b)], node.cb);
          if (decisive(node.c) != 0.0) p = formula::sum_of(p, {Term{node.c}});
          break;
        case formula::Kind::product:
          if (degree_of(of[at(node.a)]) + degree_of(of[at(node.b)]) > 2) is_possible = false;
          else p = formula::product_of(of[at(node.a)], of[at(node.b)], monomials_);
          break;
        case formula::Kind::quotient:
          if (moves[at(node.b)] != 0) is_possible = false;
          else p = formula::product_of(of[at(node.a)], {inverse(term_of(node.b))}, monomials_);
          break;
        default: is_possible = false;
      }
    }
    if (!is_possible) return {};
    return of[at(output)];
  }

  // Derivatives of a function of the position; variable n is the time.
  struct Derivative {
    int variable;
    Polynomial value;
  };
  using Derivatives = std::vector<Derivative>;

  constexpr void add(Derivatives& sum, const Derivatives& other, const Term& factor) {
    for (const Derivative& d : other) {
      const Polynomial p = formula::product_of(d.value, {factor}, monomials_);
      std::size_t i = 0;
      while (i < sum.size() && sum[i].variable != d.variable) ++i;
      if (i == sum.size()) sum.push_back({d.variable, {}});
      sum[i].value = formula::sum_of(sum[i].value, p);
    }
  }

  constexpr Derivatives derivatives_of(int node) {
    if (at(node) < derivatives_.size() && has_derivatives_[at(node)] != 0) return derivatives_[at(node)];
    const Node w = graph[node];
    Derivatives d;
    switch (w.kind) {
      case formula::Kind::constant: break;
      case formula::Kind::variable:
        if (w.a <= 2 * n_) d = {{w.a == 2 * n_ ? n_ : w.a, {Term{1.0}}}};  // parameters that are variables stay as they are
        break;
      case formula::Kind::affine:
        add(d, derivatives_of(w.a), {w.ca});
        if (w.b >= 0) add(d, derivatives_of(w.b), {w.cb});
        break;
      case formula::Kind::product:
        add(d, derivatives_of(w.a), term_of(w.b));
        add(d, derivatives_of(w.b), term_of(w.a));
        break;
      case formula::Kind::quotient: {
        const Term over = inverse(term_of(w.b));
        add(d, derivatives_of(w.a), over);
        Term share = times(times(term_of(w.a), over), over);
        share.c = -share.c;
        add(d, derivatives_of(w.b), share);
        break;
      }
      case formula::Kind::power: {
        Term slope = term_of(graph.power(w.a, decisive(w.c) - 1.0));
        slope.c = w.c * slope.c;
        add(d, derivatives_of(w.a), slope);
        break;
      }
      case formula::Kind::function:
        add(d, derivatives_of(w.a), term_of(graph.slope(node)));
        if (w.b >= 0) add(d, derivatives_of(w.b), term_of(graph.second_slope(node)));
        break;
    }
    if (derivatives_.size() <= at(node)) {
      derivatives_.resize(2 * at(node) + 1);
      has_derivatives_.resize(2 * at(node) + 1, 0);
    }
    derivatives_[at(node)] = d;
    has_derivatives_[at(node)] = 1;
    return d;
  }

  // Of a term's monomial, times its coefficient.
  constexpr Derivatives derivatives_of(const Term& t) {
    Derivatives d;
    const formula::Monomial m = monomials_[t.monomial];
    for (int i = 0; i < m.count; ++i) {
      const Term rest{static_cast<double>(m.factor[i].exponent) * t.c, monomials_.product(t.monomial, monomials_.atom(m.factor[i].atom, -1))};
      add(d, derivatives_of(m.factor[i].atom), rest);
    }
    return d;
  }

  static constexpr void append(Polynomial& to, const Polynomial& p, double sign, int a, int b) {
    for (Term t : p) {
      if (sign < 0.0) t.c = -t.c;
      t.a = std::max(a, b);
      t.b = std::min(a, b);
      to.push_back(t);
    }
  }

  constexpr void derive(int T, int V, std::vector<Polynomial>& M, std::vector<Polynomial>& r) {
    Polynomial kinetic = polynomial_of(T);
    simplify(kinetic);
    if (kinetic.size() > 2 * at(n_) * at(n_ + 1) + 16) is_possible = false;
    if (!is_possible) return;
    for (const Term& t : kinetic) {
      const Term position{t.c, t.monomial};
      if (t.b >= 0) M[entry(t.a, t.b)].push_back(t.a == t.b ? Term{2.0 * t.c, t.monomial} : position);
      for (const Derivative& d : derivatives_of(position)) {
        if (d.variable < n_) append(r[at(d.variable)], d.value, 1.0, t.a, t.b);
        const int rate = d.variable < n_ ? d.variable : -1;  // the time's is one
        if (t.a >= 0) append(r[at(t.a)], d.value, -1.0, rate, t.b);
        if (t.b >= 0) append(r[at(t.b)], d.value, -1.0, rate, t.a);
      }
    }
    for (Polynomial& p : M) {
      formula::collect(p);
      simplify(p);
    }
    std::vector<int> q;
    for (int i = 0; i < n_; ++i) q.push_back(graph.variable(i));
    const std::vector<int> gradient = graph.gradient(V, q);
    for (int i = 0; i < n_; ++i) append(r[at(i)], terms_of(gradient[at(i)]), -1.0, -1, -1);
    for (Polynomial& p : r) {
      formula::collect(p);
      simplify(p);
    }
  }

  int n_;
  formula::MonomialTable monomials_;
  std::vector<Derivatives> derivatives_;
  std::vector<char> has_derivatives_;
};

}  // namespace qdot::detail
