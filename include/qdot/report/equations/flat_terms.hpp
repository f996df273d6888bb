#pragma once
// SPDX-License-Identifier: MIT
//
// Products and sums of nodes, flat: a list of terms, number · Π nodeᵉ.
//
// This is what one has in mind when arranging a formula: which factors a term has, and which of them others share. Nodes that are not products
// themselves (variables, functions, sums, roots) are the factors. Terms that are alike are added up, with two rules of trigonometry:
//
//     c X − c X cos² u  =  c X sin² u ,        sin u sin v + cos u cos v  =  cos(u − v)      and those like it.
//
// Variables of the graph are q, q̇, t, q̈ and the parameters, in this order.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <map>
#include <utility>
#include <vector>

#include "qdot/ad/formula/coefficient.hpp"
#include "qdot/ad/formula/velocity_polynomial.hpp"

namespace qdot::report::detail {

/// number · Π nodeᵉ.
struct FlatTerm {
  double number = 1.0;
  std::map<int, double> factors = {};
};
using FlatSum = std::vector<FlatTerm>;

/// What can be said and done with flat terms of a graph.
class FlatTerms {
 public:
  using Graph = formula::BasicGraph<formula::Coefficient>;

  FlatTerms(Graph& graph, int n) : graph_(graph), n_(n) {}

  /// The summands of a node, the node times a number.
  FlatSum summands(int node, double factor = 1.0) const {
    const auto& w = graph_[node];
    if (w.kind == formula::Kind::affine && w.b < 0 && number(w.c) == 0.0) return summands(w.a, factor * number(w.ca));
    FlatSum sum;
    if (w.kind == formula::Kind::affine) {
      sum = summands(w.a, factor * number(w.ca));
      if (w.b >= 0)
        for (FlatTerm& t : summands(w.b, factor * number(w.cb))) sum.push_back(std::move(t));
      if (number(w.c) != 0.0) sum.push_back({factor * number(w.c), {}});
      return sum;
    }
    FlatTerm t{factor, {}};
    collect_factors(node, 1.0, t);
    if (t.number != 0.0) sum.push_back(std::move(t));
    return sum;
  }

  /// Terms as they are.
  FlatSum terms(const formula::Polynomial& p, const formula::MonomialTable& monomials) const {
    FlatSum sum;
    for (const formula::Term& term : p) {
      FlatTerm t{number(term.c), {}};
      const formula::Monomial& m = monomials[term.monomial];
      for (int i = 0; i < m.count; ++i) collect_factors(m.factor[i].atom, m.factor[i].exponent, t);
      for (const int v : {term.a, term.b})
        if (v >= 0) collect_factors(velocity(v), 1.0, t);
      sum.push_back(std::move(t));
    }
    return sum;
  }

  /// Multiplies sums of parameters out, or all sums, and adds up what is alike.
  FlatSum collected(const FlatSum& sum, bool all_sums) const {
    std::map<std::map<int, double>, double> all;
    FlatSum open = sum;
    constexpr std::size_t too_long = 300;
    while (!open.empty()) {
      if (all_sums && all.size() + open.size() > too_long) return collected(sum, false);
      FlatTerm t = std::move(open.back());
      open.pop_back();
      const auto parameter_sum = std::find_if(t.factors.begin(), t.factors.end(), [&](const auto& f) {
        return f.second == 1.0 && (is_sum_of_parameters(f.first) || (all_sums && graph_[f.first].kind == formula::Kind::affine));
      });
      if (parameter_sum == t.factors.end()) {
        all[t.factors] += t.number;
        continue;
      }
      const int node = parameter_sum->first;
      t.factors.erase(parameter_sum);
      for (const FlatTerm& part : summands(node)) open.push_back(product(t, part));
    }
    FlatSum result;
    for (const auto& [factors, number] : all)
      if (std::abs(number) > 1e-14) result.push_back({number, factors});
    squares_in_place(result);
    angles_in_place(result);
    return result;
  }

  FlatTerm product(const FlatTerm& x, const FlatTerm& y, double power_of_y = 1.0) const {
    FlatTerm t{x.number * std::pow(y.number, power_of_y), x.factors};
    for (const auto& [node, e] : y.factors)
      if ((t.factors[node] += power_of_y * e) == 0.0) t.factors.erase(node);
    return t;
  }

  /// What all terms have in common; its number is one that leaves a first coefficient of one where all are alike.
  FlatTerm common(const FlatSum& sum, bool negative_exponents = true) const {
    FlatTerm t = sum.empty() ? FlatTerm{} : sum[0];
    bool alike = true;
    for (const FlatTerm& other : sum) {
      alike = alike && std::abs(std::abs(other.number) - std::abs(t.number)) <= 1e-14 * std::abs(t.number);
      for (auto f = t.factors.begin(); f != t.factors.end();) {
        const auto found = other.factors.find(f->first);
        const double e = found == other.factors.end() ? 0.0 : found->second;
        f->second = e > 0.0 && f->second > 0.0 ? std::min(e, f->second) : e < 0.0 && f->second < 0.0 && negative_exponents ? std::max(e, f->second) : 0.0;
        f = f->second == 0.0 ? t.factors.erase(f) : std::next(f);
      }
    }
    const bool negative = std::all_of(sum.begin(), sum.end(), [](const FlatTerm& x) { return x.number < 0.0; });
    t.number = (negative ? -1.0 : 1.0) * (alike ? std::abs(t.number) : 1.0);
    return t;
  }

  FlatSum quotients(const FlatSum& sum, const FlatTerm& divisor) const {
    FlatSum result;
    for (const FlatTerm& t : sum) result.push_back(product(t, divisor, -1.0));
    return result;
  }

  int velocity(int i) const { return graph_.variable(n_ + i); }
  int acceleration(int i) const { return graph_.variable(2 * n_ + 1 + i); }
  bool is_parameter(int node) const { return graph_[node].kind == formula::Kind::variable && graph_[node].a > 3 * n_; }

 protected:
  static double number(const formula::Coefficient& c) { return c.value; }

  bool is_velocity(int node) const {
    const auto& w = graph_[node];
    return w.kind == formula::Kind::variable && is_rate(w.a);
  }
  bool is_rate(int variable) const { return variable >= n_ && variable <= 3 * n_ && variable != 2 * n_; }
  bool is_sum_of_parameters(int node) const {
    const auto& w = graph_[node];
    return w.kind == formula::Kind::affine && is_made_of_parameters(node);
  }
  bool is_made_of_parameters(int node) const {
    const auto& w = graph_[node];
    if (w.kind == formula::Kind::constant) return true;
    if (w.kind == formula::Kind::variable) return is_parameter(node);
    return is_made_of_parameters(w.a) && (w.b < 0 || is_made_of_parameters(w.b));
  }

  void collect_factors(int node, double exponent, FlatTerm& t) const {
    const auto& w = graph_[node];
    const bool whole = exponent == std::round(exponent);
    switch (w.kind) {
      case formula::Kind::constant: t.number *= std::pow(number(w.c), exponent); return;
      case formula::Kind::product:
        if (!whole) break;
        collect_factors(w.a, exponent, t);
        collect_factors(w.b, exponent, t);
        return;
      case formula::Kind::quotient:
        if (!whole) break;
        collect_factors(w.a, exponent, t);
        collect_factors(w.b, -exponent, t);
        return;
      case formula::Kind::power: return whole || !whole_number(number(w.c)) ? collect_factors(w.a, exponent * number(w.c), t) : add_factor(node, exponent, t);
      case formula::Kind::affine:
        if (!whole || w.b >= 0 || number(w.c) != 0.0) break;
        t.number *= std::pow(number(w.ca), exponent);
        collect_factors(w.a, exponent, t);
        return;
      default: break;
    }
    add_factor(node, exponent, t);
  }
  static bool whole_number(double x) { return x == std::round(x); }
  static void add_factor(int node, double exponent, FlatTerm& t) {
    if ((t.factors[node] += exponent) == 0.0) t.factors.erase(node);
  }

  // c X − c X cos² u is c X sin² u, and the other way round.
  void squares_in_place(FlatSum& sum) const {
    for (bool again = true; again;) {
      again = false;
      for (std::size_t i = 0; i < sum.size() && !again; ++i)
        for (const auto& [node, e] : sum[i].factors) {
          const auto& w = graph_[node];
          if (e < 2.0 || w.kind != formula::Kind::function || (w.function != formula::Function::sin && w.function != formula::Function::cos)) continue;
          FlatTerm rest = sum[i];
          if ((rest.factors[node] -= 2.0) == 0.0) rest.factors.erase(node);
          const auto other = std::find_if(sum.begin(), sum.end(), [&](const FlatTerm& t) {
            return t.factors == rest.factors && std::abs(t.number + rest.number) <= 1e-14 * std::abs(rest.number);
          });
          if (other == sum.end()) continue;
          other->factors[graph_.function(w.function == formula::Function::sin ? formula::Function::cos : formula::Function::sin, w.a)] += 2.0;
          sum.erase(sum.begin() + static_cast<std::ptrdiff_t>(i));
          again = true;
          break;
        }
    }
  }

  // sin u sin v + cos u cos v is cos(u − v), and three more like it.
  void angles_in_place(FlatSum& sum) const {
    const auto angle = [&](int node) { return graph_[node].kind == formula::Kind::function && graph_[node].b < 0 ? graph_[node].a : -1; };
    for (std::size_t i = 0; i < sum.size(); ++i) {
      std::vector<std::pair<int, bool>> circular;  // node, and whether it is a sine
      for (const auto& [node, e] : sum[i].factors)
        if (e >= 1.0 && whole_number(e) && angle(node) >= 0 &&
            (graph_[node].function == formula::Function::sin || graph_[node].function == formula::Function::cos))
          circular.push_back({node, graph_[node].function == formula::Function::sin});
      bool replaced = false;
      for (std::size_t x = 0; x < circular.size() && !replaced; ++x)
        for (std::size_t y = x + 1; y < circular.size() && !replaced; ++y) {
          auto [first, first_is_sine] = circular[x];
          auto [second, second_is_sine] = circular[y];
          int u = angle(first), v = angle(second);
          if (u == v) continue;
          if (u > v) std::swap(u, v), std::swap(first, second), std::swap(first_is_sine, second_is_sine);
          const auto other_of = [&](int a, bool is_sine) { return graph_.function(is_sine ? formula::Function::cos : formula::Function::sin, a); };
          const FlatTerm pair{1.0, {{first, 1.0}, {second, 1.0}}}, partner{1.0, {{other_of(u, first_is_sine), 1.0}, {other_of(v, second_is_sine), 1.0}}};
          FlatTerm rest = product(sum[i], pair, -1.0);
          const FlatTerm wanted = product(rest, partner);
          const auto found = std::find_if(sum.begin(), sum.end(), [&](const FlatTerm& t) {
            return t.factors == wanted.factors && std::abs(std::abs(t.number) - std::abs(wanted.number)) <= 1e-14 * std::abs(t.number);
          });
          if (found == sum.end()) continue;
          const bool alike = (found->number < 0.0) == (sum[i].number < 0.0), both = first_is_sine == second_is_sine;
          const bool minus = both ? alike : !alike;  // the angle is u − v
          const int node = graph_.function(both ? formula::Function::cos : formula::Function::sin, minus ? graph_.difference(u, v) : graph_.sum(u, v));
          // cos cos ± sin sin has the sign of cos cos, sin u cos v ± cos u sin v that of sin u cos v.
          const bool own_sign = both ? !first_is_sine : first_is_sine;
          rest.number = own_sign ? sum[i].number : found->number;
          const FlatTerm joined = product(rest, FlatTerm{1.0, {{node, 1.0}}});
          sum.erase(found);
          const auto self = std::find_if(sum.begin(), sum.end(), [&](const FlatTerm& t) { return t.factors == product(rest, pair).factors; });
          *self = joined;
          replaced = true;
        }
      if (replaced) i = static_cast<std::size_t>(-1);
    }
  }

  Graph& graph_;
  int n_;
};

}  // namespace qdot::report::detail
