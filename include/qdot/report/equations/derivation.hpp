#pragma once
// SPDX-License-Identifier: MIT
//
// Lagrange's equations with letters, ready to be written down.
//
// T and V with letters (report/equations/parameter_letters.hpp) go through the same derivation by terms that the compiler uses
// (mechanics/derive/by_terms.hpp): parameters are variables that nothing is differentiated by. Where T is no quadratic form that can be multiplied
// out, p, M and r are derivatives of the graph, as they come:
//
//     p = ∂L/∂q̇ ,   M = ∂p/∂q̇ ,   r = ∂L/∂q − (∂p/∂q) q̇ − ∂p/∂t       (mechanics/derive/derivatives_of_graph.hpp).
//
// q̈ is given where it can be solved by hand: a coordinate that is coupled to no other, or one whose diagonal entry is a single term and is
// eliminated. Two that are left are solved by Cramer's rule. An eliminated q̈ is given by those that are solved for. With constraints φ = 0 the rows
// have the reactions Jᵀλ on their right, and q̈ is not given.

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "qdot/mechanics/derive/by_terms.hpp"
#include "qdot/mechanics/derive/derivatives_of_graph.hpp"
#include "qdot/report/equations/expression.hpp"
#include "qdot/report/equations/layout.hpp"
#include "qdot/report/equations/parameter_letters.hpp"

namespace qdot::report {

/// left = right
struct Equation {
  Expression left, right;
};

/// The equations of a system as formulas.
struct EquationsOfMotion {
  Expression L = {};
  std::vector<Expression> p = {};
  std::vector<std::vector<Expression>> M = {};  // lower triangle
  std::vector<Expression> r = {};
  std::vector<Equation> rows = {};         // of M q̈ = r + Jᵀλ, divided by the parameters that all terms of a row have in common
  std::vector<Equation> qddot = {};        // empty where there is no closed form, or one too long to read
  std::vector<Equation> constraints = {};  // φ = 0
};

namespace detail {

class EquationDerivation {
  using Polynomial = formula::Polynomial;

 public:
  /// @param letters     T, V and the rows of constraints
  /// @param parameters  names of all of them; what is no letter does not appear
  EquationDerivation(const ParameterLetters& letters, std::vector<std::string> coordinates, const std::vector<std::string>& parameters)
      : n_(static_cast<int>(coordinates.size())), d_(n_), layout_(d_.graph, coordinates, parameters), names_(std::move(coordinates)) {
    const int first = 3 * n_ + 1;
    for (std::size_t j = 0; j < parameters.size(); ++j) d_.graph.variable(first + static_cast<int>(j));
    outputs_ = letters.written(d_.graph, first);
    for (std::size_t k = 2; k < outputs_.size(); ++k) {
      const std::string number = outputs_.size() > 3 ? std::to_string(k - 1) : "";
      lambda_.push_back(d_.graph.variable(first + static_cast<int>(parameters.size() + lambda_.size())));
      layout_.name_parameter("lambda" + number);
    }
  }

  /// T = … and V = …
  std::vector<Equation> energies() {
    const FlatSum T = kinetic_summands();
    return {{symbol_expression("T"), layout_.of_sum(layout_.in_order(T))},
            {symbol_expression("V"), layout_.of_sum(layout_.in_order(layout_.summands(outputs_[1])))}};
  }

  EquationsOfMotion equations() {
    EquationsOfMotion e;
    const int T = outputs_[0], V = outputs_[1];
    FlatSum L = kinetic_summands();
    for (FlatTerm& t : layout_.summands(V, -1.0)) L.push_back(std::move(t));
    e.L = layout_.of_sum(layout_.in_order(L));
    write_flat(T, V);
    write_reactions();
    for (int i = 0; i < n_; ++i) {
      e.p.push_back(layout_.arranged(p_[at(i)]));
      e.r.push_back(layout_.arranged(r_[at(i)]));
      e.M.emplace_back();
      for (int j = 0; j <= i; ++j) e.M.back().push_back(layout_.arranged(M_[entry(i, j)]));
      e.rows.push_back(row(i));
    }
    if (lambda_.empty()) solve(e);
    constexpr int readable = 120;
    if (std::any_of(e.qddot.begin(), e.qddot.end(), [](const Equation& a) { return size_of(a.right) > readable; })) e.qddot.clear();
    for (std::size_t k = 2; k < outputs_.size(); ++k) e.constraints.push_back({layout_.of_node(outputs_[k]), number_expression(0.0)});
    return e;
  }

 private:
  FlatSum kinetic_summands() {
    by_terms_ = d_.terms(outputs_[0], outputs_[1]);
    has_terms_ = d_.is_possible;
    FlatSum T = layout_.summands(outputs_[0]);
    if (!has_terms_) return T;  // multiplied out where that is much shorter, as of a chain's sum of squares
    const FlatSum out = layout_.collected(flat(by_terms_.kinetic));
    return 3 * size_of(layout_.of_sum(out)) < 2 * size_of(layout_.of_sum(T)) ? out : T;
  }

  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  static std::size_t entry(int i, int j) { return at(i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i); }
  FlatSum flat(const Polynomial& p) const { return layout_.terms(p, d_.monomials()); }
  FlatTerm factor(int node) const { return {1.0, {{node, 1.0}}}; }

  // p, M and r as terms.
  void write_flat(int T, int V) {
    p_.resize(at(n_));
    if (has_terms_) {
      for (const Polynomial& m : by_terms_.mass) M_.push_back(flat(m));
      for (const Polynomial& r : by_terms_.right) r_.push_back(flat(r));
      for (const formula::Term& t : by_terms_.kinetic)
        for (const auto& [i, other] : {std::pair(t.a, t.b), std::pair(t.b, t.a)}) {
          if (i < 0) continue;
          const FlatSum slope = flat({formula::Term{t.c, t.monomial, other, -1}});
          p_[at(i)].insert(p_[at(i)].end(), slope.begin(), slope.end());
        }
      return;
    }
    const qdot::detail::GraphEquations e = qdot::detail::equations_by_graph(d_.graph, n_, T, V);
    for (int i = 0; i < n_; ++i) p_[at(i)] = layout_.summands(e.p[at(i)]);
    for (const int node : e.mass) M_.push_back(node < 0 ? FlatSum{} : layout_.summands(node));
    for (const int node : e.right) r_.push_back(layout_.summands(node));
  }

  // Jᵀλ, J = ∂φ/∂q, or ∂a/∂q̇ of a constraint on velocities.
  void write_reactions() {
    reactions_.resize(at(n_));
    std::vector<int> q, v;
    for (int i = 0; i < n_; ++i) {
      q.push_back(d_.graph.variable(i));
      v.push_back(d_.graph.variable(n_ + i));
    }
    for (std::size_t k = 0; k < lambda_.size(); ++k) {
      const int phi = outputs_[k + 2];
      const bool of_velocities = d_.graph.dependence(phi, v).back() != 0;
      const std::vector<int> J = d_.graph.gradient(phi, of_velocities ? v : q);
      for (int i = 0; i < n_; ++i)
        for (const FlatTerm& t : layout_.summands(J[at(i)])) reactions_[at(i)].push_back(layout_.product(t, factor(lambda_[k])));
    }
  }

  FlatSum accelerated(const FlatSum& mass, int j) const {
    FlatSum sum;
    for (const FlatTerm& t : mass) sum.push_back(layout_.product(t, factor(layout_.acceleration(j))));
    return sum;
  }

  // A row of M q̈ = r + Jᵀλ, divided by what is common to all of it and can't be zero: numbers and parameters.
  Equation row(int i) const {
    FlatSum left;
    for (int j = 0; j < n_; ++j)
      for (FlatTerm& t : accelerated(M_[entry(i, j)], j)) left.push_back(std::move(t));
    const FlatSum right = layout_.collected(r_[at(i)]);
    FlatSum all = layout_.collected(left);
    all.insert(all.end(), right.begin(), right.end());
    all.insert(all.end(), reactions_[at(i)].begin(), reactions_[at(i)].end());
    FlatTerm shared = layout_.common(all);
    std::erase_if(shared.factors, [&](const auto& f) { return !layout_.is_parameter(f.first); });
    std::vector<Expression> sides;
    if (!right.empty() || reactions_[at(i)].empty()) sides.push_back(layout_.arranged(layout_.quotients(right, shared)));
    if (!reactions_[at(i)].empty()) sides.push_back(layout_.of_sum(layout_.quotients(reactions_[at(i)], shared)));
    return {layout_.arranged(layout_.quotients(left, shared)), layout_.as_sum(sides)};
  }

  Expression acceleration(int i) const { return symbol_expression(names_[at(i)], 2); }

  // Σ above / Σ below.
  Expression quotient(const FlatSum& above, const FlatSum& below) const {
    const FlatSum divisor = layout_.collected(below), sum = layout_.collected(above);
    if (sum.empty()) return number_expression(0.0);
    if (divisor.size() == 1) {
      Expression each = layout_.arranged(layout_.quotients(sum, divisor[0])), one = over_one_line(sum, shared_with(sum, divisor[0]), divisor[0]);
      return size_of(one) < size_of(each) ? one : each;
    }
    const FlatTerm over = layout_.common(divisor);
    Expression e = over_one_line(sum, layout_.common(sum), over);
    if (e.kind != Expression::Kind::product) e = {.parts = {e}};
    e.divisors.push_back(layout_.arranged(layout_.quotients(divisor, over)));
    return e;
  }

  // What all terms have in common, of functions and coordinates only those that the divisor has, too.
  FlatTerm shared_with(const FlatSum& sum, const FlatTerm& divisor) const {
    FlatTerm shared = layout_.common(sum);
    std::erase_if(shared.factors, [&](const auto& f) { return !layout_.is_parameter(f.first) && !divisor.factors.contains(f.first); });
    return shared;
  }
  Expression over_one_line(const FlatSum& sum, const FlatTerm& shared, const FlatTerm& divisor) const {
    const FlatTerm outside = layout_.product(shared, divisor, -1.0);
    const FlatSum inside = layout_.quotients(sum, shared);
    if (inside.size() == 1) return layout_.product_of(layout_.product(outside, inside[0]), {});
    return layout_.product_of(outside, {layout_.arranged(inside)});
  }

  bool is_alone(int i, const std::vector<Polynomial>& M, const std::vector<int>& kept) const {
    return std::all_of(kept.begin(), kept.end(), [&](int j) { return j == i || M[entry(i, j)].empty(); });
  }

  // q̈ where it can be solved for as by hand.
  void solve(EquationsOfMotion& e) {
    if (!has_terms_) return solve_uncoupled(e);
    Elimination s{by_terms_.mass, by_terms_.right, {}, std::vector<Expression>(at(n_))};
    for (int i = 0; i < n_; ++i) s.kept.push_back(i);
    for (;;) {
      take_uncoupled(s);
      const int k = pivot_of(s);
      if (k < 0) break;
      if (!eliminate(s, k)) return;
    }
    if (s.kept.size() == 2 && !solve_by_cramer(s)) return;
    if (!s.kept.empty()) return;
    for (int i = 0; i < n_; ++i) e.qddot.push_back({acceleration(i), s.found[at(i)]});
  }

  // Of a diagonal M.
  void solve_uncoupled(EquationsOfMotion& e) {
    for (int i = 0; i < n_; ++i)
      for (int j = 0; j < i; ++j)
        if (!layout_.collected(M_[entry(i, j)]).empty()) return;
    for (int i = 0; i < n_; ++i) e.qddot.push_back({acceleration(i), quotient(r_[at(i)], M_[entry(i, i)])});
  }

  // M q̈ = r in the coordinates that are kept, and q̈ of those that are not.
  struct Elimination {
    std::vector<Polynomial> M, r;
    std::vector<int> kept;
    std::vector<Expression> found;

    void take(int i, Expression x) {
      found[at(i)] = std::move(x);
      std::erase(kept, i);
    }
  };

  // Takes the coordinates that are coupled to no other one.
  void take_uncoupled(Elimination& s) const {
    for (const int i : std::vector<int>(s.kept))
      if (is_alone(i, s.M, s.kept)) s.take(i, quotient(flat(s.r[at(i)]), flat(s.M[entry(i, i)])));
  }

  // The last of the coordinates that are eliminated most easily: their diagonal entry is a single term. −1 where there is none.
  int pivot_of(const Elimination& s) const {
    int best = -1, best_cost = 0;
    for (const int k : s.kept) {
      if (s.M[entry(k, k)].size() != 1) continue;
      int cost = is_constant(s.M[entry(k, k)][0]) ? 0 : 100;
      for (const int i : s.kept) cost += !s.M[entry(i, k)].empty();
      if (best < 0 || cost <= best_cost) {
        best = k;
        best_cost = cost;
      }
    }
    return best;
  }

  // Eliminates coordinate k; false where a right-hand side becomes too long.
  bool eliminate(Elimination& s, int k) {
    const formula::Term pivot = s.M[entry(k, k)][0];
    FlatSum right = flat(s.r[at(k)]);
    std::erase(s.kept, k);
    for (const int i : s.kept) {
      if (s.M[entry(i, k)].empty()) continue;
      for (const int j : s.kept)
        if (j <= i) s.M[entry(i, j)] = d_.reduced(s.M[entry(i, j)], s.M[entry(i, k)], s.M[entry(j, k)], pivot);
      s.r[at(i)] = d_.reduced(s.r[at(i)], s.M[entry(i, k)], s.r[at(k)], pivot);
      if (s.r[at(i)].size() > longest) return false;
      for (FlatTerm t : accelerated(flat(s.M[entry(i, k)]), i)) {
        t.number = -t.number;
        right.push_back(std::move(t));
      }
    }
    s.take(k, quotient(right, flat({pivot})));
    return true;
  }

  // Solves for the two coordinates that are kept; false where a right-hand side becomes too long.
  bool solve_by_cramer(Elimination& s) const {
    const int i = s.kept[0], j = s.kept[1];
    const Polynomial &a = s.M[entry(i, i)], &b = s.M[entry(i, j)], &c = s.M[entry(j, j)];
    const FlatSum determinant = difference_of_products(a, c, b, b);
    if (s.r[at(i)].size() * c.size() > longest) return false;
    s.take(i, quotient(difference_of_products(s.r[at(i)], c, s.r[at(j)], b), determinant));
    s.take(j, quotient(difference_of_products(s.r[at(j)], a, s.r[at(i)], b), determinant));
    return true;
  }

  // a b − c d
  FlatSum difference_of_products(const Polynomial& a, const Polynomial& b, const Polynomial& c, const Polynomial& d) const {
    FlatSum sum;
    const auto add_product = [&](const Polynomial& x, const Polynomial& y, double sign) {
      for (const FlatTerm& s : flat(x))
        for (const FlatTerm& t : flat(y)) {
          sum.push_back(layout_.product(s, t));
          sum.back().number *= sign;
        }
    };
    add_product(a, b, 1.0);
    add_product(c, d, -1.0);
    return sum;
  }

  // Made of parameters alone.
  bool is_constant(const formula::Term& t) const {
    for (const FlatTerm& flat_term : flat({t}))
      for (const auto& f : layout_.collected({flat_term}))
        for (const auto& part : f.factors)
          if (!layout_.is_parameter(part.first)) return false;
    return true;
  }

  static constexpr std::size_t longest = 40;  // terms of a right-hand side

  int n_;
  qdot::detail::DerivationByTerms d_;
  FormulaLayout layout_;
  std::vector<std::string> names_;
  std::vector<int> outputs_;
  qdot::detail::DerivationByTerms::Terms by_terms_;
  bool has_terms_ = false;
  std::vector<FlatSum> p_, M_, r_, reactions_;
  std::vector<int> lambda_;
};

}  // namespace detail
}  // namespace qdot::report
