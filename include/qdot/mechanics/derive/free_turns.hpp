#pragma once
// SPDX-License-Identifier: MIT
//
// Bodies whose rotation has no part in the inertia of anything else, solved for by their angular accelerations.
//
// Where T contains the velocities ṗ of a rotation by Ω = W(p) ṗ alone, Lagrange's equations of p are Wᵀ times Euler's,
//
//     Wᵀ (I α + τ) = X ,   α = W p̈ ,   τ = I Ω̇ + Ω × I Ω at p̈ = 0 ,   X the forces on p ,
//
// and I is constant where M = WᵀIW is not. So unknowns are exchanged before M is eliminated (mechanics/derive/solution_lines.hpp): p̈ = V α with the
// W V = 1 that each rotation knows (mechanics/equations/known_rotation.hpp). Of a quaternion, where W p = 0,
//
//     p̈ = V α + μ p ,     and μ has the inertia that T gives to |p|, ½ κ (p·ṗ)², or none: then a constraint must decide it.
//
// Multiplied by Vᵀ and pᵀ these equations are M, r and J of the unknowns (α, μ), with zeros where there are none.

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "qdot/mechanics/derive/coriolis_terms.hpp"

namespace qdot::detail {

/// W is taken for regular above this.
inline constexpr double regular_turning = 1e-6;

/// A free turn as nodes.
struct FreeTurn {
  const formula::Recording::Turning* turning;  // in the recording of the equations
  std::array<int, 3> torque;                   // τ
  std::array<int, 9> inertia{};                // I, row by row
  double along = 0.0;                          // κ; 0 where there is none

  std::size_t size() const { return turning->coordinates.size(); }
  int p(std::size_t c) const { return turning->coordinates[c].first; }
  /// The number of coordinate p_c.
  template <class Graph>
  std::size_t own(const Graph& graph, std::size_t c) const {
    return static_cast<std::size_t>(graph[p(c)].a);
  }
};

/// Finds the free turns of a T whose Coriolis terms are known.
template <class Graph>
class FreeTurns {
 public:
  FreeTurns(Graph& graph, int n, int T) : graph_(graph), n_(n), T_(T), qdot_(variables_of(graph, n, n)) {}

  [[gnu::cold]] std::vector<FreeTurn> of(const CoriolisTerms<Graph>& terms) {
    std::vector<FreeTurn> found;
    for (const auto& followed : terms.followed()) {
      FreeTurn turn{followed.turning, followed.torque};
      if (terms.is_whole(followed) && is_free(followed, terms.momenta_of_rest(), turn)) found.push_back(turn);
    }
    return found;
  }

 private:
  static std::size_t at(int x) { return static_cast<std::size_t>(x); }
  bool is_zero(int x) const { return graph_.is_constant(x, 0.0); }

  // Whether a rotation is free; then the turn has its I and κ.
  template <class Followed>
  bool is_free(const Followed& followed, const std::vector<int>& momenta_of_rest, FreeTurn& turn) {
    std::vector<int> rates;
    for (const auto& [p, rate] : turn.turning->coordinates) {
      const auto &x = graph_[p], &v = graph_[rate];
      if (x.kind != formula::Kind::variable || v.kind != formula::Kind::variable || x.a >= n_ || v.a != n_ + x.a) return false;
      if (std::ranges::find(rates, rate) != rates.end()) return false;
      if (!momenta_of_rest.empty() && graph_.dependence(momenta_of_rest[at(x.a)], qdot_).back() != 0) return false;
      rates.push_back(rate);
    }
    for (std::size_t a = 0; a < 3; ++a) {
      const int momentum = followed.momentum[a];
      if (momentum >= 0 && graph_.dependence(momentum, qdot_, followed.base).back() != 0) return false;
      const std::vector<int> row = momentum < 0 ? std::vector<int>(3, graph_.constant(0.0))
                                                : graph_.gradient(momentum, followed.base, graph_.dependence(momentum, followed.base));
      for (std::size_t b = 0; b < 3; ++b) turn.inertia[3 * a + b] = graph_.scaled(row[b], 1.0 / followed.factor[b]);
    }
    return is_of_length(turn, rates, followed.base);
  }

  // Whether T beside Ω is none of the own velocities, or one of (p·ṗ)².
  bool is_of_length(FreeTurn& turn, const std::vector<int>& rates, const std::array<int, 3>& omega) {
    const std::vector<int> slopes = graph_.gradient(T_, rates, graph_.dependence(T_, rates, omega));
    if (std::ranges::all_of(slopes, [&](int x) { return is_zero(x); })) return true;
    if (turn.size() != 4) return false;
    for (std::size_t i = 0; i < 4; ++i) {
      std::vector<int> row = graph_.gradient(slopes[i], qdot_, graph_.dependence(slopes[i], qdot_, omega));
      for (std::size_t j = 0; j < 4; ++j) {
        int& own = row[turn.own(graph_, j)];
        if (!is_multiple(own, turn, i, j)) return false;
        own = graph_.constant(0.0);
      }
      if (!std::ranges::all_of(row, [&](int x) { return is_zero(x); })) return false;
    }
    return true;
  }
  // Whether an entry of M is κ p_i p_j, with the κ of all.
  bool is_multiple(int entry, FreeTurn& turn, std::size_t i, std::size_t j) {
    const auto term = graph_.term(entry);
    if (term.node != graph_.product(turn.p(i), turn.p(j)) || formula::decisive(term.offset) != 0.0) return false;
    const double kappa = formula::decisive(term.factor);
    if (turn.along == 0.0) turn.along = kappa;
    return turn.along == kappa;
  }

  Graph& graph_;
  int n_, T_;
  std::vector<int> qdot_;
};

/// M q̈ − Jᵀλ = r, J q̈ = γ as nodes; −1 is zero.
struct EquationsOfRates {
  std::vector<int> mass, right, J, gamma;  // of M the lower triangle

  std::size_t n() const { return right.size(); }
  int& mass_at(std::size_t i, std::size_t j) { return mass[i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i]; }
};

/// Exchanges the unknowns of free turns.
template <class Graph>
class AngularUnknowns {
 public:
  /// @param apart  the right side without the torques of all rotations that are followed; those of others do not reach the own coordinates
  AngularUnknowns(Graph& graph, const std::vector<FreeTurn>& turns, const std::vector<int>& apart) : graph_(graph), turns_(turns), apart_(apart) {}

  [[gnu::cold]] void enter(EquationsOfRates& e) {
    for (const FreeTurn& turn : turns_) {
      enter_mass(e, turn);
      for (std::size_t u = 0; u < turn.size(); ++u) {
        int right = along(turn, u, apart_.data());
        if (u < 3) right = graph_.difference(right, turn.torque[u]);
        e.right[turn.own(graph_, u)] = right;
      }
      const std::size_t n = e.right.size();
      for (std::size_t k = 0; k < e.J.size(); k += n) {
        std::vector<int> row;
        for (std::size_t u = 0; u < turn.size(); ++u) row.push_back(none_if_zero(along(turn, u, e.J.data() + k)));
        for (std::size_t u = 0; u < row.size(); ++u) e.J[k + turn.own(graph_, u)] = row[u];
      }
    }
  }

  /// q̈ from the unknowns, as numbers of which number(node) is one.
  template <class Numbers, class ToNumber>
  [[gnu::cold]] void leave(Numbers& numbers, std::vector<int>& x, const ToNumber& number) const {
    for (const FreeTurn& turn : turns_) {
      std::vector<int> qddot;
      for (std::size_t c = 0; c < turn.size(); ++c) {
        int sum = none;
        for (std::size_t u = 0; u < turn.size(); ++u) {
          const int way = entry(turn, c, u), unknown = x[turn.own(graph_, u)];
          if (graph_.is_constant(way, 0.0) || unknown == none) continue;
          const bool is_one = graph_.is_constant(way, 1.0);
          if (sum == none) sum = is_one ? unknown : numbers.product(unknown, number(way));
          else sum = is_one ? numbers.sum(sum, unknown) : numbers.plus_product(sum, unknown, number(way));
        }
        qddot.push_back(sum);
      }
      for (std::size_t c = 0; c < qddot.size(); ++c) x[turn.own(graph_, c)] = qddot[c];
    }
  }
  /// What leave() reads.
  std::vector<int> read() const {
    std::vector<int> nodes;
    for (const FreeTurn& turn : turns_)
      for (std::size_t c = 0; c < turn.size(); ++c)
        for (std::size_t u = 0; u < turn.size(); ++u)
          if (const int way = entry(turn, c, u); !graph_.is_constant(way, 0.0) && !graph_.is_constant(way, 1.0)) nodes.push_back(way);
    return nodes;
  }

 private:
  static constexpr int none = -1;
  int none_if_zero(int node) const { return graph_.is_constant(node, 0.0) ? none : node; }

  // V, with p as its last column.
  static int entry(const FreeTurn& turn, std::size_t c, std::size_t u) { return u < 3 ? turn.turning->inverse[3 * c + u] : turn.p(c); }
  // Column u times entries of all coordinates. Products that are met again are counted, for E(p) p = 0.
  int along(const FreeTurn& turn, std::size_t u, const int* entries) {
    std::vector<int> products;
    std::vector<double> factors;
    for (std::size_t c = 0; c < turn.size(); ++c) {
      const int x = entries[turn.own(graph_, c)];
      if (x == none) continue;
      int product = graph_.product(entry(turn, c, u), x);
      double factor = 1.0;
      if (const auto term = graph_.term(product); term.node >= 0 && formula::decisive(term.offset) == 0.0)
        product = term.node, factor = formula::decisive(term.factor);
      const auto place = static_cast<std::size_t>(std::ranges::find(products, product) - products.begin());
      if (place == products.size()) {
        products.push_back(product);
        factors.push_back(0.0);
      }
      factors[place] += factor;
    }
    int sum = graph_.constant(0.0);
    for (std::size_t k = 0; k < products.size(); ++k) sum = graph_.sum(sum, graph_.scaled(products[k], factors[k]));
    return sum;
  }
  void enter_mass(EquationsOfRates& e, const FreeTurn& turn) {
    for (std::size_t u = 0; u < turn.size(); ++u)
      for (std::size_t w = 0; w <= u; ++w) e.mass_at(turn.own(graph_, u), turn.own(graph_, w)) = u < 3 ? none_if_zero(turn.inertia[3 * u + w]) : none;
    if (turn.along == 0.0) return;
    int length = graph_.constant(0.0);
    for (std::size_t c = 0; c < turn.size(); ++c) length = graph_.sum(length, graph_.product(turn.p(c), turn.p(c)));
    e.mass_at(turn.own(graph_, 3), turn.own(graph_, 3)) = graph_.scaled(graph_.product(length, length), turn.along);
  }

  Graph& graph_;
  const std::vector<FreeTurn>& turns_;
  const std::vector<int>& apart_;
};

/// Takes out unknowns without inertia that rows decide by themselves, J_kc x_c = γ_k: these rows act on nothing else.
template <class Graph>
class DecidedUnknowns {
 public:
  explicit DecidedUnknowns(Graph& graph) : graph_(graph) {}

  std::vector<int> divisors;  ///< J_kc, which must not be zero

  [[gnu::cold]] void take_out(EquationsOfRates& e) {
    for (std::size_t c = e.n(); c-- > 0;) {
      const std::size_t n = e.n();
      bool is_massless = true;
      for (std::size_t j = 0; j < n; ++j) is_massless = is_massless && e.mass_at(c, j) < 0;
      if (!is_massless || n == 1) continue;  // M must keep a row
      for (std::size_t k = 0; k < e.gamma.size(); ++k) {
        bool is_alone = e.J[k * n + c] >= 0;
        for (std::size_t j = 0; j < n; ++j) is_alone = is_alone && (j == c || e.J[k * n + j] < 0);
        if (!is_alone || acts_elsewhere(e, c, k)) continue;
        divisors.push_back(e.J[k * n + c]);
        places_.push_back(static_cast<int>(c));
        values_.push_back(graph_.quotient(e.gamma[k], e.J[k * n + c]));
        erase(e, c, k);
        break;
      }
    }
  }
  /// What is put back.
  const std::vector<int>& nodes() const { return values_; }
  template <class ToNumber>
  void put_back(std::vector<int>& x, const ToNumber& number) const {
    for (std::size_t k = values_.size(); k-- > 0;) x.insert(x.begin() + places_[k], number(values_[k]));
  }

 private:
  // Whether the unknown is in another row, too.
  static bool acts_elsewhere(const EquationsOfRates& e, std::size_t c, std::size_t row) {
    for (std::size_t k = 0; k < e.gamma.size(); ++k)
      if (k != row && e.J[k * e.n() + c] >= 0) return true;
    return false;
  }
  static void erase(EquationsOfRates& e, std::size_t c, std::size_t row) {
    EquationsOfRates left;
    for (std::size_t i = 0; i < e.n(); ++i) {
      if (i == c) continue;
      left.right.push_back(e.right[i]);
      for (std::size_t j = 0; j <= i; ++j)
        if (j != c) left.mass.push_back(e.mass_at(i, j));
    }
    for (std::size_t k = 0; k < e.gamma.size(); ++k) {
      if (k == row) continue;
      left.gamma.push_back(e.gamma[k]);
      for (std::size_t j = 0; j < e.n(); ++j)
        if (j != c) left.J.push_back(e.J[k * e.n() + j]);
    }
    e = std::move(left);
  }

  Graph& graph_;
  std::vector<int> places_, values_;  // of an unknown its place among those that are left, and its value
};

}  // namespace qdot::detail
