#pragma once
// SPDX-License-Identifier: MIT
//
// Coriolis and centrifugal terms of M q̈ + c = Q − ∂V/∂q, as formulas:
//
//     c_i = d/dt ∂T/∂q̇_i − ∂T/∂q_i   at q̈ = 0 .
//
// As it stands that takes three walks through T, and much of what they find cancels. But most T are sums of products k u w of
// velocities, u = Ẋ for some X(q, t) that need not be known, with d/dt ∂u/∂q̇_i = ∂u/∂q_i (Lagrange's lemma). So a product adds
//
//     c_i = k (∂u/∂q̇_i ẇ + ∂w/∂q̇_i u̇)   at q̈ = 0 ,        in one walk forwards for all u̇ and one back
//
// u is recognized where it is a sum of f(φ) φ̇, with φ any formula of q and t, or is made of X by the chain rule. What is not,
// like the r θ̇ of polar coordinates, is differentiated as it stands. Chains of links need half of the operations. Angular
// velocities Ω = W(q, t) q̇ + … are no rates, but [Ω×] = RᵀṘ gives d/dt ∂Ω/∂q̇_i − ∂Ω/∂q_i = −Ω × W_i. So a T that contains Ω
// (mechanics/equations/known_rotation.hpp finds them) adds W_i · (Ω × ∂T/∂Ω), which makes Euler's equations of it, W_i · (I
// Ω̇ + Ω × I Ω).

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "qdot/ad/formula/coefficient.hpp"
#include "qdot/ad/formula/recording.hpp"
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
  using Turning = formula::Recording::Turning;
  constexpr CoriolisTerms(RatesOfNodes<Graph>& rates, int n, std::span<const Turning> turnings = {})
      : graph_(rates.graph()), rates_(rates), q_(variables_of(graph_, 0, n)), qdot_(variables_of(graph_, n, n)), n_(n), turnings_(turnings) {}

  constexpr std::vector<int> of(int T) {
    begin(T);
    rates_.remember(rated());
    return terms();
  }

  /// An angular velocity in T. momentum is ∂T/∂Ω of those entries that are no rates, −1 for zero; c_i contains W_i · torque. Of an entry that is a rate, torque
  /// is that of Ω × L alone; the rest is with the rates.
  struct Followed {
    const Turning* turning;
    std::array<int, 3> base;  // Ω = factor · base, since graphs multiply without factors
    std::array<FactorOf<Graph>, 3> factor;
    std::array<int, 3> momentum{-1, -1, -1}, torque{};
  };
  const std::vector<Followed>& followed() const { return followed_; }
  /// Whether no entry of Ω is a rate.
  bool is_whole(const Followed& f) const {
    return std::ranges::all_of(f.base, [&](int w) { return turns_[at(w)] != 0; });
  }
  /// c without those torques.
  const std::vector<int>& apart() const { return apart_; }
  /// ∂/∂q̇ of what in T is no product of velocities; empty if that is nothing.
  const std::vector<int>& momenta_of_rest() const { return p_; }

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
    apart_ = terms_of_products();
    for (std::size_t i = 0; i < p_.size(); ++i) apart_[i] = graph_.sum(apart_[i], graph_.difference(rates_.of(p_[i]), along_q_[i]));
    return followed_.empty() ? apart_ : with_torques();
  }

  // What a node is: a formula of q and t, and then of which node alone; f(φ) φ̇ of a node φ, or another rate. Or it is a sum of angular velocities and
  // rates, or none of these.
  enum class Is : unsigned char { constant, position, rate_of_one, rate, turning, other };
  struct Known {
    Is is = Is::other;
    int base = -1;  // φ
  };

  static constexpr std::size_t at(int x) { return static_cast<std::size_t>(x); }
  constexpr bool is_time(const Known& k) const { return k.is == Is::position && graph_[k.base].kind == formula::Kind::variable && graph_[k.base].a == 2 * n_; }
  constexpr bool is_rate(const Known& k) const { return k.is == Is::constant || k.is == Is::rate_of_one || k.is == Is::rate || is_time(k); }

  // A velocity for which d/dt and ∂/∂q change places, or what takes its place is known.
  constexpr bool is_velocity(const Known& k) const { return is_rate(k) || k.is == Is::turning; }

  // The angular velocities in T whose rotations are by numbers with their own rates.
  constexpr void find_turnings(int last) {
    turns_.assign(at(last) + 1, 0);
    for (const Turning& turning : turnings_) {
      const auto is_followed = [&](const std::pair<int, int>& x) { return x.first <= last && x.second <= last && rates_.of(x.first) == x.second; };
      const auto is_constant = [&](int w) { return graph_[w].kind == formula::Kind::constant; };
      const auto is_free = [&](int w) { return w <= last && (is_constant(w) || turns_[at(w)] == 0); };
      Followed f{&turning, turning.omega, {1.0, 1.0, 1.0}};
      for (std::size_t a = 0; a < 3; ++a)
        if (const auto w = graph_.term(turning.omega[a]); w.node >= 0 && formula::decisive(w.offset) == 0.0) f.base[a] = w.node, f.factor[a] = w.factor;
      const bool are_different = f.base[0] != f.base[1] && f.base[1] != f.base[2] && f.base[2] != f.base[0];
      if (!are_different || !std::ranges::all_of(turning.coordinates, is_followed) || !std::ranges::all_of(f.base, is_free)) continue;
      for (const int w : f.base) turns_[at(w)] = is_constant(w) ? 0 : 1;
      followed_.push_back(f);
    }
  }
  constexpr void tell_kinds(int last) {
    known_.reserve(at(last) + 1);
    rates_.remember_to(last);
    find_turnings(last);
    std::vector<char> is_rate_of_position(at(last) + 1, 0);
    for (int x = 0; x <= last; ++x) {
      Known known = kind_of(x);
      if (known.is == Is::other && is_rate_of_position[at(x)] != 0) known.is = Is::rate;
      if (turns_[at(x)] != 0 && known.is == Is::other) known.is = Is::turning;
      else turns_[at(x)] = 0;  // a rate, as about an axis that is fixed, is followed as such
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
        if (is_rate(a) && is_rate(b)) return {Is::rate, -1};
        return is_velocity(a) && is_velocity(b) ? Known{Is::turning, -1} : Known{};
      case formula::Kind::product:
        if (a.is == Is::constant && is_velocity(b)) return b;
        if (b.is == Is::constant && is_velocity(a)) return a;
        if (a.is == Is::position && is_rate_of(w.b, a.base)) return {Is::rate_of_one, a.base};
        if (b.is == Is::position && is_rate_of(w.a, b.base)) return {Is::rate_of_one, b.base};
        return {};
      case formula::Kind::quotient:
        if (b.is == Is::constant && is_velocity(a)) return a;
        return b.is == Is::position && is_rate_of(w.a, b.base) ? Known{Is::rate_of_one, b.base} : Known{};
      default: return {};
    }
  }
  // Whether y is f(φ) φ̇.
  constexpr bool is_rate_of(int y, int phi) {
    const Known& k = known_[at(y)];
    return (k.is == Is::rate_of_one && k.base == phi) || (is_rate(k) && rates_.of(phi) == y);
  }

  // T but for products of two velocities, which are listed.
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
      } else if (w.kind == formula::Kind::product && is_velocity(known_[at(w.a)]) && is_velocity(known_[at(w.b)])) {
        products_.push_back({w.a, w.b, k});
      } else {
        rest = graph_.sum(rest, graph_.scaled(x, k));
      }
    }
    return rest;
  }
  constexpr void add_to(std::vector<int>& adjoint, int x, int share) {
    int& sum = adjoint[at(x)];
    sum = sum < 0 ? share : graph_.sum(sum, share);
  }
  // ∂T/∂Ω of all Ω, by a walk back through sums of angular velocities.
  constexpr std::vector<int> angular_momenta() {
    std::vector<int> adjoint(known_.size(), -1);
    const auto turns = [&](int x) { return x >= 0 && known_[at(x)].is == Is::turning; };
    const auto add = [&](int x, int share) { add_to(adjoint, x, share); };
    for (const Product& x : products_) {
      if (turns(x.u)) add(x.u, graph_.scaled(x.w, x.k));
      if (turns(x.w)) add(x.w, graph_.scaled(x.u, x.k));
    }
    for (int x = static_cast<int>(known_.size()) - 1; x >= 0; --x)
      if (const int share = adjoint[at(x)]; share >= 0 && turns_[at(x)] == 0) graph_.pass_back(x, share, turns, add);
    return adjoint;
  }
  // A walk back that begins with k ẇ at u and k u̇ at w, and ends at q̇ and at Ω, where Ω × ∂T/∂Ω is added.
  constexpr std::vector<int> terms_of_products() {
    std::vector<int> adjoint(known_.size(), -1);
    for (const Product& x : products_) {
      add_to(adjoint, x.u, graph_.scaled(rates_.of(x.w), x.k));
      add_to(adjoint, x.w, graph_.scaled(rates_.of(x.u), x.k));
    }
    const std::vector<int> momenta = followed_.empty() ? std::vector<int>() : angular_momenta();
    walk_back(adjoint, true);
    for (Followed& f : followed_) {
      const std::array<int, 3>& omega = f.turning->omega;
      for (std::size_t c = 0; c < 3; ++c)
        if (const int base = f.base[c]; momenta[at(base)] >= 0) f.momentum[c] = graph_.scaled(momenta[at(base)], 1.0 / f.factor[c]);
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t a = (c + 1) % 3, b = (c + 2) % 3;
        const int base = f.base[c], share = turns_[at(base)] != 0 ? adjoint[at(base)] : -1;
        int torque = share < 0 ? graph_.constant(0.0) : graph_.scaled(share, 1.0 / f.factor[c]);
        if (f.momentum[b] >= 0) torque = graph_.sum(torque, graph_.product(omega[a], f.momentum[b]));
        if (f.momentum[a] >= 0) torque = graph_.difference(torque, graph_.product(omega[b], f.momentum[a]));
        f.torque[c] = torque;
      }
    }
    return at_velocities(adjoint);
  }
  // c: torques at Ω, walked back to q̇, are added to what is apart from them.
  constexpr std::vector<int> with_torques() {
    std::vector<int> adjoint(known_.size(), -1), c;
    for (const Followed& f : followed_)
      for (std::size_t k = 0; k < 3; ++k) add_to(adjoint, f.base[k], graph_.scaled(f.torque[k], f.factor[k]));
    walk_back(adjoint, false);
    const std::vector<int> turning = at_velocities(adjoint);
    for (std::size_t i = 0; i < turning.size(); ++i) c.push_back(graph_.sum(apart_[i], turning[i]));
    return c;
  }
  constexpr void walk_back(std::vector<int>& adjoint, bool ends_at_omega) {
    const auto leads_on = [&](int x) { return x >= 0 && moves_[at(x)] != 0; };
    const auto add = [&](int x, int share) { add_to(adjoint, x, share); };
    for (int x = static_cast<int>(adjoint.size()) - 1; x >= 0; --x) {
      const int share = adjoint[at(x)];
      if (share >= 0 && !graph_.is_constant(share, 0.0) && !(ends_at_omega && turns_[at(x)] != 0)) graph_.pass_back(x, share, leads_on, add);
    }
  }
  constexpr std::vector<int> at_velocities(const std::vector<int>& adjoint) {
    std::vector<int> all;
    for (const int v : qdot_) all.push_back(at(v) < adjoint.size() && adjoint[at(v)] >= 0 ? without_equal_products(adjoint[at(v)]) : graph_.constant(0.0));
    return all;
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
  std::vector<Known> known_;  // of each node that T consists of
  std::vector<char> moves_;   // whether it depends on q̇
  std::span<const Turning> turnings_;
  std::vector<Followed> followed_;  // those whose rotations are by numbers with their own rates
  std::vector<char> turns_;         // whether a node is an entry of one of these, and no rate
  std::vector<Product> products_;
  std::vector<int> p_, along_q_;  // of the rest
  std::vector<int> apart_;
};

}  // namespace qdot::detail
