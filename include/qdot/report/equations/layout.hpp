#pragma once
// SPDX-License-Identifier: MIT
//
// From nodes and terms to formulas as a book has them.
//
// A node of a graph (ad/formula/graph.hpp) is laid out as its functor wrote it, which suits a Lagrangian. A sum of terms
// (ad/formula/velocity_polynomial.hpp), which is what equations are derived as, is arranged:
//
//     (m₁ + m₂) l₁          terms that differ in parameters only are one
//     M + m sin² θ          for M + m − m cos² θ
//     (I₁ − I₃) φ̇² …        squares of velocities first, then products of two, then one, then none
//     g (m r + ½ M L)       terms with the same velocities give to the outside what they share
//
// Factors: number, parameters (inertias, gravity, others), sums, coordinates, velocities, functions; "φ̇² sin θ", because sin θ φ̇² might be the sine
// of a product.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "qdot/ad/formula/graph.hpp"
#include "qdot/report/equations/expression.hpp"
#include "qdot/report/equations/flat_terms.hpp"

namespace qdot::report::detail {

class FormulaLayout : public FlatTerms {
 public:
  using FlatTerms::collected;

  /// Variables of the graph are q, q̇, t, q̈ and the parameters.
  FormulaLayout(Graph& graph, std::vector<std::string> coordinates, std::vector<std::string> parameters)
      : FlatTerms(graph, static_cast<int>(coordinates.size())), q_(std::move(coordinates)), p_(std::move(parameters)) {}

  /// One more parameter, as a multiplier of a constraint is.
  void name_parameter(std::string name) { p_.push_back(std::move(name)); }

  /// As it was written, but in order.
  Expression of_node(int node) const { return of_sum(in_order(summands(node))); }

  /// Squares of velocities first, and so on; of two terms alike in that, the one of the first coordinate.
  FlatSum in_order(const FlatSum& terms) const {
    FlatSum sum;
    for (const FlatTerm& t : terms) {
      const auto like = std::find_if(sum.begin(), sum.end(), [&](const FlatTerm& x) { return x.factors == t.factors; });
      if (like == sum.end()) {
        sum.push_back(t);
      } else {
        like->number += t.number;
      }
    }
    std::stable_sort(sum.begin(), sum.end(), [&](const FlatTerm& x, const FlatTerm& y) { return reading_order(x) < reading_order(y); });
    if (!sum.empty() && sum[0].number < 0.0) {
      const auto positive = std::find_if(sum.begin(), sum.end(), [](const FlatTerm& t) { return t.number > 0.0; });
      if (positive != sum.end()) std::rotate(sum.begin(), positive, sum.end());
    }
    return sum;
  }

  /// Multiplies sums of parameters out and adds up what is alike; other sums, too, where that is shorter to read.
  FlatSum collected(const FlatSum& sum) const {
    FlatSum as_is = collected(sum, false), spread = collected(sum, true);
    constexpr std::size_t many = 40;
    return spread.size() <= many && size_of(arranged_terms(spread)) < size_of(arranged_terms(as_is)) ? spread : as_is;
  }
  /// Arranged as in a book; see above.
  Expression arranged(const FlatSum& sum) const { return arranged_terms(collected(sum)); }
  Expression arranged_terms(const FlatSum& terms) const {
    if (terms.empty()) return number_expression(0.0);
    const auto part_of = [&](const FlatTerm& t, auto belongs) {
      FlatTerm part;
      for (const auto& f : t.factors)
        if (belongs(f.first)) part.factors.insert(f);
      return part;
    };
    const auto groups_by = [&](const FlatSum& from, auto belongs) {
      std::vector<std::pair<FlatTerm, FlatSum>> groups;
      for (const FlatTerm& t : from) {
        const FlatTerm key = part_of(t, belongs);
        auto g = std::find_if(groups.begin(), groups.end(), [&](const auto& group) { return group.first.factors == key.factors; });
        if (g == groups.end()) g = groups.insert(groups.end(), {key, {}});
        g->second.push_back(product(t, key, -1.0));
      }
      return groups;
    };
    auto by_velocity = groups_by(terms, [&](int node) { return is_velocity(node); });
    std::sort(by_velocity.begin(), by_velocity.end(), [&](const auto& x, const auto& y) { return velocity_order(x.first) < velocity_order(y.first); });
    std::vector<Expression> summands;
    for (const auto& [velocities, inside] : by_velocity) {
      FlatTerm shared = inside.size() > 1 ? common(inside) : FlatTerm{};
      if (inside.size() > 1 && velocities.factors.empty() && !worth_it(shared)) shared = {};
      std::vector<std::pair<FlatTerm, FlatSum>> alike = groups_by(quotients(inside, shared), [&](int node) { return !is_parameter(node); });
      std::sort(alike.begin(), alike.end(), [&](const auto& x, const auto& y) { return order(x) < order(y); });
      std::vector<Expression> parts;
      for (const auto& [rest, coefficients] : alike) {
        const bool alone = alike.size() == 1;
        const FlatTerm base = alone ? product(product(rest, shared), velocities) : rest;
        parts.push_back(with_coefficients(coefficients, base));
      }
      if (parts.size() == 1) {
        summands.push_back(parts[0]);
      } else if (velocities.factors.empty() && !worth_it(shared)) {
        summands.insert(summands.end(), parts.begin(), parts.end());
      } else {
        summands.push_back(product_of(product(shared, velocities), {as_sum(parts)}));
      }
    }
    return as_sum(summands);
  }

  /// Σ of flat terms in their order.
  Expression of_sum(const FlatSum& sum) const {
    std::vector<Expression> parts;
    for (const FlatTerm& t : sum) parts.push_back(product_of(t, {}));
    return as_sum(parts);
  }

  /// A term times sums.
  ///
  /// @param rank  where the sums go; see place()
  Expression product_of(const FlatTerm& t, std::vector<Expression> sums, int rank = 3) const {
    Expression e{.number = t.number};
    std::vector<std::pair<int, double>> factors(t.factors.begin(), t.factors.end());
    std::stable_sort(factors.begin(), factors.end(), [&](const auto& x, const auto& y) { return place(x.first) < place(y.first); });
    std::size_t next = 0;
    const auto add = [&](std::vector<Expression>& to, int node, double exponent) {
      Expression x = of_atom(node);
      to.push_back(exponent == 1.0 ? std::move(x) : Expression{.kind = Expression::Kind::power, .number = exponent, .parts = {std::move(x)}});
    };
    const auto add_until = [&](int last) {
      for (; next < factors.size() && place(factors[next].first).first <= last; ++next)
        add(factors[next].second > 0.0 ? e.parts : e.divisors, factors[next].first, std::abs(factors[next].second));
    };
    add_until(rank - 1);
    for (Expression& s : sums) {
      if (s.kind == Expression::Kind::product) {
        e.number *= s.number;
        e.parts.insert(e.parts.end(), s.parts.begin(), s.parts.end());
        e.divisors.insert(e.divisors.end(), s.divisors.begin(), s.divisors.end());
      } else {
        e.parts.push_back(std::move(s));
      }
    }
    add_until(100);
    distribute_number(e);
    return e.number == 1.0 && e.parts.size() == 1 && e.divisors.empty() ? Expression(e.parts[0]) : e;
  }

  static Expression as_sum(const std::vector<Expression>& parts) {
    if (parts.empty()) return number_expression(0.0);
    if (parts.size() == 1) return parts[0];
    Expression sum{.kind = Expression::Kind::sum};
    for (const Expression& part : parts) {
      if (part.kind == Expression::Kind::sum) {
        sum.parts.insert(sum.parts.end(), part.parts.begin(), part.parts.end());
      } else {
        sum.parts.push_back(part);
      }
    }
    return sum;
  }


 private:
  // −2 (½ a − b) is −(a − 2 b).
  static void distribute_number(Expression& e) {
    const double size = std::abs(e.number);
    if (size == 1.0 || !whole_number(size)) return;
    for (Expression& sum : e.parts) {
      if (sum.kind != Expression::Kind::sum) continue;
      bool has_fractions = false, becomes_whole = true;
      for (const Expression& part : sum.parts) {
        const double number = part.kind == Expression::Kind::product ? part.number : 1.0;
        has_fractions = has_fractions || !whole_number(number);
        becomes_whole = becomes_whole && std::abs(number * size - std::round(number * size)) <= 1e-14 * size;
      }
      if (!has_fractions || !becomes_whole) continue;
      for (Expression& part : sum.parts) {
        if (part.kind != Expression::Kind::product) part = {.parts = {part}};
        part.number = std::round(part.number * size);
        if (part.number == 1.0 && part.parts.size() == 1 && part.divisors.empty()) part = Expression(part.parts[0]);
      }
      e.number /= size;
      return;
    }
  }

  static bool worth_it(const FlatTerm& shared) { return !shared.factors.empty(); }

  // (m₁ + m₂) times a term.
  Expression with_coefficients(const FlatSum& coefficients, const FlatTerm& term) const {
    if (coefficients.size() == 1) return product_of(product(term, coefficients[0]), {});
    const FlatTerm shared = common(coefficients);
    FlatSum inside = quotients(coefficients, shared);
    std::stable_sort(inside.begin(), inside.end(), [&](const FlatTerm& x, const FlatTerm& y) {
      return std::pair(x.number < 0.0, places(x)) < std::pair(y.number < 0.0, places(y));
    });
    int rank = 3;
    for (const FlatTerm& t : inside)
      for (const auto& f : t.factors) rank = std::min(rank, place(f.first).first + 1);
    return product_of(product(term, shared), {of_sum(inside)}, rank);
  }

  // Parameters first, then sums, coordinates, velocities and functions.
  std::pair<int, int> place(int node) const {
    const auto& w = graph_[node];
    if (is_parameter(node)) {
      const std::string& name = p_[static_cast<std::size_t>(w.a - 3 * n_ - 1)];
      const std::string letter = spelled(name).letter;
      const bool inertia = letter == "m" || letter == "M" || letter == "mu" || letter == "I" || letter == "J" || letter == "Theta";
      return {inertia ? 0 : letter == "g" ? 1 : 2, w.a};
    }
    if (w.kind == formula::Kind::variable)
      return w.a < n_ ? std::pair(4, w.a) : w.a == 2 * n_ ? std::pair(5, 0) : w.a > 2 * n_ ? std::pair(6, w.a) : std::pair(7, w.a);
    if (w.kind == formula::Kind::function) return {8, w.function == formula::Function::sin ? 0 : w.function == formula::Function::cos ? 1 : 2};
    if (!is_sum_of_parameters(node)) return {3, node};
    std::pair<int, int> least{3, 0};
    for (const FlatTerm& t : summands(node))
      for (const auto& f : t.factors) least = std::min(least, std::pair(place(f.first).first, node));
    return least;
  }
  std::vector<std::pair<int, int>> places(const FlatTerm& t) const {
    std::vector<std::pair<int, int>> all;
    for (const auto& f : t.factors) all.push_back(place(f.first));
    std::sort(all.begin(), all.end());
    return all;
  }
  // Of terms as they were written: those with velocities, then a number, coordinates, parameters, functions; of the last, high powers first,
  // whatever the order in which a compiler evaluated them.
  std::tuple<int, int, double> reading_order(const FlatTerm& t) const {
    double power = 0.0;
    int degree = 0, different = 0, kind = t.factors.empty() ? 0 : 2, velocity = 1000, coordinate = 1000;
    for (const auto& [node, e] : t.factors) {
      const std::vector<int> inside = variables_in(node);
      const bool moves = std::any_of(inside.begin(), inside.end(), [&](int x) { return is_rate(x); });
      if (graph_[node].kind == formula::Kind::variable && !inside.empty()) power += e;
      for (const int x : inside) (is_rate(x) ? velocity : coordinate) = std::min(is_rate(x) ? velocity : coordinate, x);
      if (moves) {
        degree += inside.size() > 1 || e >= 2.0 ? 2 : 1;
        different += inside.size() == 1 && e < 2.0;
      } else if (graph_[node].kind == formula::Kind::function) {
        kind = 3;
      } else if (!inside.empty() && kind != 3) {
        kind = 1;
      }
    }
    if (degree == 0) return {10 + kind, coordinate, -power};
    return {degree == 1 ? 2 : different > 1 ? 1 : 0, velocity, 0.0};
  }
  // Coordinates, velocities and the time in a node, in order.
  std::vector<int> variables_in(int node) const {
    const auto& w = graph_[node];
    if (w.kind == formula::Kind::constant) return {};
    if (w.kind == formula::Kind::variable) return w.a <= 3 * n_ ? std::vector<int>{w.a} : std::vector<int>{};
    std::vector<int> all = variables_in(w.a);
    if (w.b >= 0)
      for (const int v : variables_in(w.b)) all.push_back(v);
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
  }
  // Accelerations, squares, products, single velocities, nothing.
  std::pair<int, std::vector<int>> velocity_order(const FlatTerm& t) const {
    int degree = 0, squares = 0, accelerations = 0;
    std::vector<int> which;
    for (const auto& [node, e] : t.factors) {
      which.push_back(graph_[node].a);
      degree += static_cast<int>(std::abs(e));
      squares += e == 2.0;
      accelerations += graph_[node].a > 2 * n_;
    }
    return {accelerations > 0 ? -1 : squares > 0 ? 0 : degree >= 2 ? 1 : degree == 1 ? 2 : 3, which};
  }
  // Terms beside each other: with more coordinates first, then functions.
  std::tuple<int, std::vector<std::pair<int, int>>> order(const std::pair<FlatTerm, FlatSum>& group) const {
    return {group.first.factors.empty() ? 0 : 1, places(group.first)};
  }

  Expression of_atom(int node) const {
    const auto& w = graph_[node];
    switch (w.kind) {
      case formula::Kind::variable: {
        if (w.a == 2 * n_) return symbol_expression("t");
        if (w.a > 3 * n_) return {.kind = Expression::Kind::symbol, .name = p_[static_cast<std::size_t>(w.a - 3 * n_ - 1)], .is_constant = true};
        const int dots = w.a < n_ ? 0 : w.a < 2 * n_ ? 1 : 2;
        return symbol_expression(q_[static_cast<std::size_t>(dots == 0 ? w.a : dots == 1 ? w.a - n_ : w.a - 2 * n_ - 1)], dots);
      }
      case formula::Kind::function: {
        static constexpr const char* names[] = {"",   "sin",   "cos",  "tan",  "asin", "acos",  "atan",  "atan2", "hypot", "exp", "expm1",
                                                "ln", "log1p", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "cbrt",  "erf", "erfc"};
        Expression f{.kind = Expression::Kind::function, .name = names[static_cast<std::size_t>(w.function)]};
        f.parts.push_back(of_node(w.a));
        if (w.b >= 0) f.parts.push_back(of_node(w.b));
        return f;
      }
      case formula::Kind::affine: return of_node(node);
      default: {  // a power that is no product of others
        Expression e{.kind = Expression::Kind::power, .number = number(w.c), .parts = {of_node(w.a)}};
        return e;
      }
    }
  }
  std::vector<std::string> q_, p_;
};

}  // namespace qdot::report::detail
