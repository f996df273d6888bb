#pragma once
// SPDX-License-Identifier: MIT
//
// Sums of terms  c · a^i b^j … · q̇_k q̇_l .
//
// A kinetic energy is a quadratic form in the velocities. Its coefficients are products of *atoms*: nodes of a graph that depend on
// the position alone, such as q₀, cos q₁ or a length √(x² + y²). Written as a sum of such terms, what an expert does on paper can be done
// by rule:
//
//     like terms are added,                      0.5 q̇₀² + 0.5 q̇₀²  =  q̇₀²
//     cos² + sin² of one angle is 1,             c cos²u X + c sin²u X  =  c X
//     derivatives follow from those of atoms.
//
// A sum that is an atom, like x₁ − x₀, is not multiplied out: (x₁ − x₀)² loses no digits, x₁² − 2 x₀ x₁ + x₀² does.
// Sums of velocities are: of (ẋ₁ − ẋ₀)² as many digits are lost as both velocities are larger than their difference, squared. Where a mass
// depends on the position, that costs q̈ a relative error of 3·10⁻¹³ at a ratio of 2000, and 3·10⁻¹⁰ at two million.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "qdot/ad/formula/coefficient.hpp"

namespace qdot::formula {

/// A product of powers of atoms; factors in the order of their atoms.
struct Monomial {
  static constexpr int most_factors = 10;
  struct Factor {
    int atom = 0, exponent = 0;
  };
  int count = 0;
  Factor factor[most_factors] = {};

  constexpr int exponent_of(int atom) const {
    for (int i = 0; i < count; ++i)
      if (factor[i].atom == atom) return factor[i].exponent;
    return 0;
  }
  friend constexpr bool operator==(const Monomial& x, const Monomial& y) {
    if (x.count != y.count) return false;
    for (int i = 0; i < x.count; ++i)
      if (x.factor[i].atom != y.factor[i].atom || x.factor[i].exponent != y.factor[i].exponent) return false;
    return true;
  }
};

/// All monomials of a derivation, by number; 0 is the empty product.
class MonomialTable {
 public:
  constexpr MonomialTable() { number_of(Monomial{}); }

  constexpr const Monomial& operator[](int m) const { return all_[static_cast<std::size_t>(m)]; }
  /// False after a product had too many factors.
  constexpr bool is_complete() const { return is_complete_; }

  constexpr int atom(int node, int exponent = 1) {
    Monomial m;
    m.count = 1;
    m.factor[0] = {node, exponent};
    return number_of(m);
  }

  constexpr int product(int x, int y) {
    if (x == 0) return y;
    if (y == 0) return x;
    const Monomial a = (*this)[x], b = (*this)[y];
    Monomial r;
    int i = 0, j = 0;
    while (i < a.count || j < b.count) {
      Monomial::Factor f;
      if (j == b.count || (i < a.count && a.factor[i].atom < b.factor[j].atom)) {
        f = a.factor[i++];
      } else if (i == a.count || b.factor[j].atom < a.factor[i].atom) {
        f = b.factor[j++];
      } else {
        f = {a.factor[i].atom, a.factor[i].exponent + b.factor[j].exponent};
        ++i;
        ++j;
      }
      if (f.exponent == 0) continue;
      if (r.count == Monomial::most_factors) {
        is_complete_ = false;
        return 0;
      }
      r.factor[r.count++] = f;
    }
    return number_of(r);
  }

  constexpr int power(int x, int exponent) {
    Monomial m = (*this)[x];
    for (int i = 0; i < m.count; ++i) m.factor[i].exponent *= exponent;
    return number_of(m);
  }

 private:
  constexpr int number_of(const Monomial& m) {
    if (2 * (all_.size() + 1) > places_.size()) {
      places_.assign(places_.empty() ? 64 : 2 * places_.size(), -1);
      for (std::size_t i = 0; i < all_.size(); ++i) places_[place_of(all_[i])] = static_cast<int>(i);
    }
    const std::size_t place = place_of(m);
    if (places_[place] < 0) {
      places_[place] = static_cast<int>(all_.size());
      all_.push_back(m);
    }
    return places_[place];
  }
  constexpr std::size_t place_of(const Monomial& m) const {
    std::uint64_t h = 0;
    for (int i = 0; i < m.count; ++i)
      h = (h ^ static_cast<std::uint64_t>(64 * m.factor[i].atom + m.factor[i].exponent + 32) ^ (h >> 29)) * 0x9E3779B97F4A7C15u;
    std::size_t place = static_cast<std::size_t>(h >> 33) & (places_.size() - 1);
    while (places_[place] >= 0 && !(all_[static_cast<std::size_t>(places_[place])] == m)) place = (place + 1) & (places_.size() - 1);
    return place;
  }

  std::vector<Monomial> all_;
  std::vector<int> places_;
  bool is_complete_ = true;
};

/// coefficient · monomial · q̇_a q̇_b, a ≥ b; −1 where there is no velocity.
struct Term {
  Coefficient c;
  int monomial = 0;
  int a = -1, b = -1;

  constexpr std::int64_t key() const { return (static_cast<std::int64_t>(monomial) * 1024 + a + 1) * 1024 + b + 1; }
};

/// A sum of terms in the order of their keys, no two alike.
using Polynomial = std::vector<Term>;

// Adds terms that are alike, and puts all in order.
constexpr void collect(Polynomial& p) {
  std::sort(p.begin(), p.end(), [](const Term& x, const Term& y) { return x.key() < y.key(); });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < p.size();) {
    Term t = p[i];
    const std::int64_t key = t.key();
    for (++i; i < p.size() && p[i].key() == key; ++i) t.c = t.c + p[i].c;
    if (decisive(t.c) != 0.0) p[kept++] = t;
  }
  p.resize(kept);
}

/// x + factor·y.
constexpr Polynomial sum_of(const Polynomial& x, const Polynomial& y, const Coefficient& factor = 1.0) {
  Polynomial r;
  r.reserve(x.size() + y.size());
  std::size_t i = 0, j = 0;
  while (i < x.size() || j < y.size()) {
    if (j == y.size() || (i < x.size() && x[i].key() < y[j].key())) {
      r.push_back(x[i++]);
    } else if (i == x.size() || y[j].key() < x[i].key()) {
      r.push_back(y[j++]);
      r.back().c = factor * r.back().c;
    } else {
      Term t = x[i++];
      t.c = t.c + factor * y[j++].c;
      if (decisive(t.c) != 0.0) r.push_back(t);
    }
  }
  return r;
}

/// factor·x.
constexpr Polynomial scaled(const Polynomial& x, const Coefficient& factor) {
  Polynomial r = x;
  for (Term& t : r) t.c = factor * t.c;
  return r;
}

/// Highest power of velocities in it.
constexpr int degree_of(const Polynomial& p) {
  int degree = 0;
  for (const Term& t : p) degree = std::max(degree, t.b >= 0 ? 2 : t.a >= 0 ? 1 : 0);
  return degree;
}

/// x·y; the degrees must not add up to more than 2.
constexpr Polynomial product_of(const Polynomial& x, const Polynomial& y, MonomialTable& monomials) {
  Polynomial r;
  r.reserve(x.size() * y.size());
  for (const Term& s : x)
    for (const Term& t : y) {
      Term u{s.c * t.c, monomials.product(s.monomial, t.monomial), -1, -1};
      int velocity[4] = {s.a, s.b, t.a, t.b}, found[2] = {-1, -1}, count = 0;
      for (const int v : velocity)
        if (v >= 0 && count < 2) found[count++] = v;
      u.a = std::max(found[0], found[1]);
      u.b = std::min(found[0], found[1]);
      r.push_back(u);
    }
  collect(r);
  return r;
}

/// Puts 1 for cos² + sin² of one angle, wherever both occur with like coefficients.
///
/// @param cosine_of  of an atom that is a sine, the node of the cosine of the same angle; otherwise −1
template <class CosineOf>
constexpr void simplify_squares(Polynomial& p, MonomialTable& monomials, const CosineOf& cosine_of) {
  const auto found = [&p](const Term& like) -> std::size_t {
    const std::int64_t key = like.key();
    std::size_t first = 0, last = p.size();
    while (first < last) {
      const std::size_t middle = (first + last) / 2;
      if (p[middle].key() < key) {
        first = middle + 1;
      } else {
        last = middle;
      }
    }
    return first < p.size() && p[first].key() == key ? first : p.size();
  };
  for (bool again = true; again;) {
    again = false;
    Polynomial ones;
    for (std::size_t i = 0; i < p.size(); ++i) {
      const Monomial& m = monomials[p[i].monomial];
      int sine = -1, cosine = -1;
      for (int f = 0; f < m.count && cosine < 0; ++f)
        if (m.factor[f].exponent >= 2) cosine = cosine_of(sine = m.factor[f].atom);
      if (cosine < 0 || decisive(p[i].c) == 0.0) continue;
      Term one = p[i], other = p[i];
      one.monomial = monomials.product(one.monomial, monomials.atom(sine, -2));
      other.monomial = monomials.product(one.monomial, monomials.atom(cosine, 2));
      const std::size_t j = found(other);
      if (j == p.size() || !are_alike(p[i].c, p[j].c)) continue;
      p[i].c = p[j].c = 0.0;
      ones.push_back(one);
      again = true;
    }
    if (again) {
      for (const Term& one : ones) p.push_back(one);
      collect(p);
    }
  }
}

}  // namespace qdot::formula
