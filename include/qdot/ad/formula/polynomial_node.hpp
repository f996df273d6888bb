#pragma once
// SPDX-License-Identifier: MIT
//
// A sum of terms (ad/formula/velocity_polynomial.hpp) as nodes of a graph, arranged so that few operations are left.
//
//     2 m r ṙ φ̇ s + 2 m r g s      →      2m · (r s · (ṙ φ̇ + g))
//
// What all terms have in common goes outside: atoms, velocities, a coefficient up to its sign. Terms with the same velocities are kept together,
// then those that share an atom. A sum that occurs twice, even with another factor, is then the same node, because the nodes of a graph
// are made once.

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "qdot/ad/formula/coefficient.hpp"
#include "qdot/ad/formula/graph.hpp"
#include "qdot/ad/formula/velocity_polynomial.hpp"

namespace qdot::formula {

/// Makes them.
class PolynomialNodes {
 public:
  /// Velocity k is variable first_velocity + k of the graph_.
  constexpr PolynomialNodes(BasicGraph<Coefficient>& graph, MonomialTable& monomials, int first_velocity)
      : graph_(graph), monomials_(monomials), first_velocity_(first_velocity) {}

  /// The node of a sum.
  constexpr int node_of(const Polynomial& terms) {
    Polynomial p = terms;
    if (p.empty()) return graph_.constant(0.0);
    const Monomial common = common_atoms(p);
    const auto [velocity, other] = common_velocities(p);
    int outside = graph_.constant(1.0);
    int divisor = -1;
    if (common.count > 0) {
      int inverse_of_common = 0;
      for (int i = 0; i < common.count; ++i) {
        const int atom = common.factor[i].atom, e = common.factor[i].exponent;
        inverse_of_common = monomials_.product(inverse_of_common, monomials_.atom(atom, -e));
        if (e > 0) {
          outside = graph_.product(outside, graph_.power(atom, e));
        } else {
          const int power = graph_.power(atom, -e);
          divisor = divisor < 0 ? power : graph_.product(divisor, power);
        }
      }
      for (Term& t : p) t.monomial = monomials_.product(t.monomial, inverse_of_common);
    }
    if (velocity >= 0) {
      const int velocities = node_of_velocities(velocity, other);
      outside = graph_.product(outside, velocities);
      divide_by_velocities(p, velocity, other);
    }
    const Coefficient factor = taken_out(p);
    const int sum = sum_node(p);
    const int whole = graph_.product(outside, sum);
    return graph_.scaled(divisor < 0 ? whole : graph_.quotient(whole, divisor), factor);
  }

 private:
  // The powers of atoms that all terms have in common.
  constexpr Monomial common_atoms(const Polynomial& p) const {
    Monomial common = monomials_[p[0].monomial];
    for (const Term& t : p) {
      const Monomial& m = monomials_[t.monomial];
      int kept = 0;
      for (int i = 0; i < common.count; ++i) {
        const int x = common.factor[i].exponent, y = m.exponent_of(common.factor[i].atom);
        const int e = x > 0 && y > 0 ? std::min(x, y) : x < 0 && y < 0 ? std::max(x, y) : 0;
        if (e != 0) common.factor[kept++] = {common.factor[i].atom, e};
      }
      common.count = kept;
    }
    return common;
  }

  // The velocities that all terms have in common: two, one and −1, or −1 twice.
  static constexpr std::pair<int, int> common_velocities(const Polynomial& p) {
    int velocity = p[0].a, other = p[0].b;
    for (const Term& t : p) {
      if (other >= 0 && (t.a != velocity || t.b != other)) {
        if (t.a == other || t.b == other) velocity = other;
        other = -1;
      }
      if (velocity >= 0 && t.a != velocity && t.b != velocity) velocity = -1;
    }
    return {velocity, other};
  }

  static constexpr void divide_by_velocities(Polynomial& p, int velocity, int other) {
    for (Term& t : p) {
      if (other >= 0) {
        t.a = t.b = -1;
      } else {
        t.a = t.a == velocity ? t.b : t.a;
        t.b = -1;
      }
    }
  }

  // Divides the terms by the coefficient that all have up to its sign, and returns it; one where there is none.
  static constexpr Coefficient taken_out(Polynomial& p) {
    bool same = true;
    for (const Term& t : p) same = same && (are_alike(t.c, p[0].c) || are_alike(t.c, Coefficient(-p[0].c.value)));
    if (!same) return 1.0;
    const Coefficient factor = p[0].c;
    for (Term& t : p) t.c = are_alike(t.c, factor) ? 1.0 : -1.0;
    return factor;
  }

  constexpr int node_of_monomial(int monomial) {
    const Monomial m = monomials_[monomial];
    int above = -1, below = -1;
    for (int i = 0; i < m.count; ++i) {
      const int e = m.factor[i].exponent;
      int& part = e > 0 ? above : below;
      const int factor = graph_.power(m.factor[i].atom, e > 0 ? e : -e);
      part = part < 0 ? factor : graph_.product(part, factor);
    }
    if (above < 0) above = graph_.constant(1.0);
    return below < 0 ? above : graph_.quotient(above, below);
  }
  constexpr int node_of_velocities(int a, int b) {
    if (a < 0) return graph_.constant(1.0);
    const int va = graph_.variable(first_velocity_ + a);
    if (b < 0) return va;
    const int vb = graph_.variable(first_velocity_ + b);
    return graph_.product(va, vb);
  }

  // Terms without a common factor.
  constexpr int sum_node(const Polynomial& p) {
    if (p.size() == 1) {
      const int monomial = node_of_monomial(p[0].monomial);
      const int velocities = node_of_velocities(p[0].a, p[0].b);
      return graph_.scaled(graph_.product(monomial, velocities), p[0].c);
    }
    // Terms with the same velocities are factored together, and those with one velocity in common if there are several.
    std::vector<char> done(p.size(), 0);
    std::vector<int> parts;
    for (std::size_t i = 0; i < p.size(); ++i) {
      if (done[i] != 0) continue;
      Polynomial group;
      bool squares_only = true;
      for (std::size_t j = i; j < p.size(); ++j)
        if (p[j].a == p[i].a && p[j].b != p[i].b) squares_only = false;
      for (std::size_t j = i; j < p.size(); ++j) {
        const bool belongs = p[i].a < 0 ? p[j].a < 0 : p[j].a == p[i].a && (!squares_only || p[j].b == p[i].b);
        if (done[j] != 0 || !belongs) continue;
        done[j] = 1;
        group.push_back(p[j]);
      }
      if (group.size() == p.size()) return factored(group);
      parts.push_back(node_of(group));
    }
    int sum = parts[0];
    for (std::size_t i = 1; i < parts.size(); ++i) sum = graph_.sum(sum, parts[i]);
    return sum;
  }

  // Terms with the same velocities and no common factor: the atom that most of them have goes outside of those.
  constexpr int factored(const Polynomial& p) {
    int best = -1, most = 1, sign = 1;
    for (const Term& t : p) {
      const Monomial& m = monomials_[t.monomial];
      for (int i = 0; i < m.count; ++i) {
        int count = 0;
        for (const Term& other : p) count += monomials_[other.monomial].exponent_of(m.factor[i].atom) * m.factor[i].exponent > 0;
        if (count > most) {
          most = count;
          best = m.factor[i].atom;
          sign = m.factor[i].exponent;
        }
      }
    }
    if (best < 0 || most == static_cast<int>(p.size())) {
      int sum = graph_.constant(0.0);
      for (const Term& t : p) {
        const int monomial = node_of_monomial(t.monomial);
        const int velocities = node_of_velocities(t.a, t.b);
        const int product = graph_.product(monomial, velocities);
        sum = graph_.sum(sum, graph_.scaled(product, t.c));
      }
      return sum;
    }
    Polynomial with, without;
    for (const Term& t : p) (monomials_[t.monomial].exponent_of(best) * sign > 0 ? with : without).push_back(t);
    const int first = node_of(with);
    return without.empty() ? first : graph_.sum(first, node_of(without));
  }

  BasicGraph<Coefficient>& graph_;
  MonomialTable& monomials_;
  int first_velocity_;
};

}  // namespace qdot::formula
