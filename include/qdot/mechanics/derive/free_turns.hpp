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
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "qdot/mechanics/derive/coriolis_terms.hpp"

namespace qdot::detail {

/// Most coordinates among which free turns are looked for: only so many have lines to q̈ (mechanics/derive/solved_rates.hpp).
inline constexpr std::size_t most_free_coordinates = 8;
/// W is taken for regular above this.
inline constexpr double regular_turning = 1e-6;

/// A free turn as nodes.
struct FreeTurn {
  std::vector<int> own, p;         // coordinates, by number and as nodes
  std::vector<int> inverse;        // V, row by row
  int regular;                     // not zero where W has full rank
  std::array<int, 9> inertia;      // I, row by row
  std::array<int, 3> torque;       // τ
  std::optional<double> along{};   // κ
};

/// Finds the free turns of a T whose Coriolis terms are known.
template <class Graph>
class FreeTurns {
 public:
  FreeTurns(Graph& graph, int n, int T) : graph_(graph), n_(n), T_(T), qdot_(variables_of(graph, n, n)) {}

  [[gnu::cold]] std::vector<FreeTurn> of(const CoriolisTerms<Graph>& terms) {
    std::vector<FreeTurn> found;
    for (const auto& followed : terms.followed())
      if (auto turn = terms.is_whole(followed) ? free_turn(followed, terms.momenta_of_rest()) : std::nullopt) found.push_back(std::move(*turn));
    return found;
  }

 private:
  static std::size_t at(int x) { return static_cast<std::size_t>(x); }
  bool is_zero(int x) const { return graph_.is_constant(x, 0.0); }

  // Whether nodes depend on these variables otherwise than by Ω.
  std::vector<char> beside(int last, std::span<const int> variables, const std::array<int, 3>& omega) const {
    std::vector<char> depends(at(last) + 1, 0);
    for (const int x : variables)
      if (x <= last) depends[at(x)] = 1;
    for (int w = 0; w <= last; ++w) {
      const auto& node = graph_[w];
      if (node.kind == formula::Kind::constant || node.kind == formula::Kind::variable || std::ranges::find(omega, w) != omega.end()) continue;
      if (depends[at(node.a)] != 0 || (node.b >= 0 && depends[at(node.b)] != 0)) depends[at(w)] = 1;
    }
    return depends;
  }
  bool moves_beside(int w, const std::array<int, 3>& omega) const { return beside(w, qdot_, omega)[at(w)] != 0; }

  template <class Followed>
  std::optional<FreeTurn> free_turn(const Followed& followed, const std::vector<int>& momenta_of_rest) {
    const auto& turning = *followed.turning;
    FreeTurn turn{.own = {}, .p = {}, .inverse = turning.inverse, .regular = turning.regular, .inertia = {}, .torque = followed.torque};
    std::vector<int> rates;
    for (const auto& [p, rate] : turning.coordinates) {
      const auto &x = graph_[p], &v = graph_[rate];
      if (x.kind != formula::Kind::variable || v.kind != formula::Kind::variable || x.a >= n_ || v.a != n_ + x.a) return {};
      if (std::ranges::find(turn.own, x.a) != turn.own.end()) return {};
      turn.own.push_back(x.a);
      turn.p.push_back(p);
      rates.push_back(rate);
    }
    for (const int i : turn.own)
      if (!momenta_of_rest.empty() && graph_.dependence(momenta_of_rest[at(i)], qdot_).back() != 0) return {};
    for (std::size_t a = 0; a < 3; ++a) {
      const int momentum = followed.momentum[a];
      if (momentum >= 0 && moves_beside(momentum, followed.base)) return {};
      const std::vector<int> row = momentum < 0 ? std::vector<int>(3, graph_.constant(0.0))
                                                : graph_.gradient(momentum, followed.base, graph_.dependence(momentum, followed.base));
      for (std::size_t b = 0; b < 3; ++b) turn.inertia[3 * a + b] = graph_.scaled(row[b], 1.0 / followed.factor[b]);
    }
    if (!is_of_length(turn, rates, followed.base)) return {};
    return turn;
  }

  // Whether T beside Ω is none of the own velocities, or one of (p·ṗ)².
  bool is_of_length(FreeTurn& turn, const std::vector<int>& rates, const std::array<int, 3>& omega) {
    const std::vector<int> slopes = graph_.gradient(T_, rates, beside(T_, rates, omega));
    if (std::ranges::all_of(slopes, [&](int x) { return is_zero(x); })) return true;
    if (turn.own.size() != 4) return false;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::vector<int> row = graph_.gradient(slopes[i], qdot_, beside(slopes[i], qdot_, omega));
      for (int j = 0; j < n_; ++j) {
        const auto place = std::ranges::find(turn.own, j);
        const auto column = static_cast<std::size_t>(place - turn.own.begin());
        if (column == turn.own.size() ? !is_zero(row[at(j)]) : !is_multiple(row[at(j)], turn, i, column)) return false;
      }
    }
    return true;
  }
  // Whether an entry of M is κ p_i p_j, with the κ of all.
  bool is_multiple(int entry, FreeTurn& turn, std::size_t i, std::size_t j) {
    const int product = graph_.product(turn.p[i], turn.p[j]);
    const auto& node = graph_[entry];
    const bool is_scaled = node.kind == formula::Kind::affine && node.b < 0 && node.a == product && formula::decisive(node.c) == 0.0;
    if (!is_scaled && entry != product) return false;
    const double kappa = is_scaled ? formula::decisive(node.ca) : 1.0;
    if (!turn.along) turn.along = kappa;
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
      for (std::size_t u = 0; u < turn.own.size(); ++u) {
        int right = along(turn, u, apart_.data());
        if (u < 3) right = graph_.difference(right, turn.torque[u]);
        e.right[at(turn.own[u])] = right;
      }
      const std::size_t n = e.right.size();
      for (std::size_t k = 0; k < e.J.size(); k += n) {
        std::vector<int> row;
        for (std::size_t u = 0; u < turn.own.size(); ++u) row.push_back(none_if_zero(along(turn, u, e.J.data() + k)));
        for (std::size_t u = 0; u < row.size(); ++u) e.J[k + at(turn.own[u])] = row[u];
      }
    }
  }

  /// q̈ from the unknowns, as numbers of which number(node) is one.
  template <class Numbers, class ToNumber>
  [[gnu::cold]] void leave(Numbers& numbers, std::vector<int>& x, const ToNumber& number) const {
    for (const FreeTurn& turn : turns_) {
      std::vector<int> qddot;
      for (std::size_t c = 0; c < turn.own.size(); ++c) {
        int sum = none;
        for (std::size_t u = 0; u < turn.own.size(); ++u) {
          const int way = entry(turn, c, u), unknown = x[at(turn.own[u])];
          if (graph_.is_constant(way, 0.0) || unknown == none) continue;
          const bool is_one = graph_.is_constant(way, 1.0);
          if (sum == none) sum = is_one ? unknown : numbers.product(unknown, number(way));
          else sum = is_one ? numbers.sum(sum, unknown) : numbers.plus_product(sum, unknown, number(way));
        }
        qddot.push_back(sum);
      }
      for (std::size_t c = 0; c < qddot.size(); ++c) x[at(turn.own[c])] = qddot[c];
    }
  }
  /// What leave() reads.
  std::vector<int> read() const {
    std::vector<int> nodes;
    for (const FreeTurn& turn : turns_)
      for (std::size_t c = 0; c < turn.own.size(); ++c)
        for (std::size_t u = 0; u < turn.own.size(); ++u)
          if (const int way = entry(turn, c, u); !graph_.is_constant(way, 0.0) && !graph_.is_constant(way, 1.0)) nodes.push_back(way);
    return nodes;
  }

 private:
  static constexpr int none = -1;
  static std::size_t at(int x) { return static_cast<std::size_t>(x); }
  int none_if_zero(int node) const { return graph_.is_constant(node, 0.0) ? none : node; }

  // V, with p as its last column.
  static int entry(const FreeTurn& turn, std::size_t c, std::size_t u) { return u < 3 ? turn.inverse[3 * c + u] : turn.p[c]; }
  // Column u times entries of all coordinates. Products that are met again are counted, for E(p) p = 0.
  int along(const FreeTurn& turn, std::size_t u, const int* entries) {
    std::vector<std::pair<int, double>> terms;
    for (std::size_t c = 0; c < turn.own.size(); ++c) {
      if (entries[turn.own[c]] == none) continue;
      int product = graph_.product(entry(turn, c, u), entries[turn.own[c]]);
      double factor = 1.0;
      if (const auto node = graph_[product]; node.kind == formula::Kind::affine && node.b < 0 && formula::decisive(node.c) == 0.0)
        product = node.a, factor = formula::decisive(node.ca);
      const auto met = std::ranges::find(terms, product, &std::pair<int, double>::first);
      if (met == terms.end()) terms.emplace_back(product, factor);
      else met->second += factor;
    }
    int sum = graph_.constant(0.0);
    for (const auto& [product, factor] : terms) sum = graph_.sum(sum, graph_.scaled(product, factor));
    return sum;
  }
  void enter_mass(EquationsOfRates& e, const FreeTurn& turn) {
    for (std::size_t u = 0; u < turn.own.size(); ++u)
      for (std::size_t w = 0; w <= u; ++w) e.mass_at(at(turn.own[u]), at(turn.own[w])) = u < 3 ? none_if_zero(turn.inertia[3 * u + w]) : none;
    if (!turn.along) return;
    int length = graph_.constant(0.0);
    for (const int p : turn.p) length = graph_.sum(length, graph_.product(p, p));
    e.mass_at(at(turn.own[3]), at(turn.own[3])) = graph_.scaled(graph_.product(length, length), *turn.along);
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
        decided_.emplace_back(c, graph_.quotient(e.gamma[k], e.J[k * n + c]));
        erase(e, c, k);
        break;
      }
    }
  }
  /// What is put back.
  std::vector<int> nodes() const {
    std::vector<int> all;
    for (const auto& [c, x] : decided_) all.push_back(x);
    return all;
  }
  template <class ToNumber>
  void put_back(std::vector<int>& x, const ToNumber& number) const {
    for (auto it = decided_.rbegin(); it != decided_.rend(); ++it) x.insert(x.begin() + static_cast<std::ptrdiff_t>(it->first), number(it->second));
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
  std::vector<std::pair<std::size_t, int>> decided_;  // the unknown's place among those that are left, and its value
};

}  // namespace qdot::detail
