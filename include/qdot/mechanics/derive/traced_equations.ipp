#pragma once
// SPDX-License-Identifier: MIT
//
// From what functors wrote down to sparse equations: the work of TracedEquations (mechanics/derive/traced_equations.hpp).
//
// Each row of M and J is a gradient of a node that depends on few variables (ad/formula/local_gradient.hpp). The velocity terms of all rows
// come from one walk through the graph (mechanics/derive/coriolis_terms.hpp).
//
// Programs that link qdot::compiled do not read this file: the library has it.

#include <cstddef>
#include <utility>
#include <vector>

#include "qdot/ad/formula/local_gradient.hpp"
#include "qdot/mechanics/derive/coriolis_terms.hpp"
#include "qdot/mechanics/derive/rates_of_nodes.hpp"
#include "qdot/mechanics/derive/traced_equations.hpp"

namespace qdot::detail {

template <class Number>
[[gnu::cold]] SparseEntries TracedEquations<Number>::rows_of(formula::LocalGradient<Number>& gradient, const std::vector<int>& outputs) {
  SparseEntries all;
  for (const int output : outputs) {
    for (const auto& [j, node] : gradient.of(output))
      if (!is_zero(node)) all.entries.push_back({j, node});
    all.end_row();
    require_short();
  }
  return all;
}

template <class Number>
[[gnu::cold]] void TracedEquations<Number>::require_domains() {
  const auto& nodes = graph().nodes();
  for (std::size_t w = 0; w < nodes.size(); ++w)
    if (nodes[w].domain != formula::Domain::everything) requirements.push_back({static_cast<int>(w), nodes[w].domain});
  for (const auto& assumption : motion.recording.assumptions) requirements.push_back({assumption.node, formula::Domain::nonzero, assumption.value});
}

template <class Number>
[[gnu::cold]] void TracedEquations<Number>::derive_mass() {
  formula::LocalGradient<Number> gradient(graph(), motion.qdot);
  for (std::size_t i = 0; i < n(); ++i) {
    for (const auto& [j, derivative] : gradient.of(motion.p[i], static_cast<int>(i) + 1)) {
      if (static_cast<std::size_t>(j) > i || is_zero(derivative)) continue;
      const int node = without_squares(graph(), derivative);
      mass.entries.push_back({j, node});
      mass_is_diagonal = mass_is_diagonal && static_cast<std::size_t>(j) == i;
      mass_is_constant = mass_is_constant && graph()[node].kind == formula::Kind::constant;
    }
    mass.end_row();
    require_short();
  }
}

template <class Number>
[[gnu::cold]] void TracedEquations<Number>::derive_rows(const std::vector<int>& rows, const std::vector<char>& holonomic) {
  formula::BasicGraph<Number>& g = graph();
  formula::LocalGradient<Number> along_q(g, motion.q), along_qdot(g, motion.qdot), along_t(g, {motion.t});
  for (std::size_t k = 0; k < rows.size(); ++k) {
    int c = rows[k];
    const auto& slopes = (holonomic[k] ? along_q : along_qdot).of(c);
    if (holonomic[k]) {
      phi.push_back(c);
      const auto& explicitly = along_t.of(c);
      c = explicitly.empty() ? g.constant(0.0) : explicitly[0].second;
      for (const auto& [j, w] : slopes) c = g.sum(c, g.product(w, motion.qdot[static_cast<std::size_t>(j)]));
    } else {
      phi.push_back(-1);
    }
    velocity.push_back(c);
    for (const auto& [j, w] : slopes)
      if (!is_zero(w)) J.entries.push_back({j, w});
    J.end_row();
    require_short();
  }
}

template <class Number>
[[gnu::cold]] void TracedEquations<Number>::derive(bool has_forces, const std::vector<char>& holonomic) {
  formula::BasicGraph<Number>& g = graph();
  require_domains();
  const std::vector<int>& found = motion.returned;
  const int T = found[0], work = g.scaled(found[1], -1.0);
  motion.p = g.gradient(T, motion.qdot, g.dependence(T, motion.qdot));
  right = g.gradient(work, motion.q, g.dependence(work, motion.q));
  std::size_t next = 2;
  if (has_forces) {
    for (std::size_t i = 0; i < n(); ++i) right[i] = g.sum(right[i], found[next++]);
    for (std::size_t i = 0; i < states(); ++i) zdot.push_back(found[next++]);
  }
  std::vector<int> rows(found.begin() + static_cast<std::ptrdiff_t>(next), found.end());
  derive_mass();
  derive_rows(rows, holonomic);
  RatesOfNodes<formula::BasicGraph<Number>> rates(g, static_cast<int>(n()));
  CoriolisTerms<formula::BasicGraph<Number>> coriolis(rates, static_cast<int>(n()), motion.recording.turnings);
  const std::vector<int> terms = coriolis.of(T);
  if (finds_free_turns) free_turns = FreeTurns<formula::BasicGraph<Number>>(g, static_cast<int>(n()), T).of(coriolis);
  for (std::size_t i = 0; i < n(); ++i) {
    if (!free_turns.empty()) apart.push_back(g.difference(right[i], coriolis.apart()[i]));
    right[i] = g.difference(right[i], terms[i]);
  }
  rates.remember(velocity);
  for (const int c : velocity) gamma.push_back(g.scaled(rates.of(c), -1.0));
}

template <class Number>
[[gnu::cold]] typename TracedEquations<Number>::Slopes TracedEquations<Number>::slopes() {
  formula::BasicGraph<Number>& g = graph();
  const int first = static_cast<int>(2 * n() + 1 + states());
  std::vector<int> a, lambda;
  for (std::size_t i = 0; i < n(); ++i) a.push_back(g.variable(first + static_cast<int>(i)));
  for (std::size_t k = 0; k < rows(); ++k) lambda.push_back(g.variable(first + static_cast<int>(n() + parameters.size() + k)));
  std::vector<int> residual = right, below = gamma;
  const auto subtract = [&](int& from, int x, int y) { from = g.difference(from, g.product(x, y)); };
  for (std::size_t i = 0; i < n(); ++i)
    for (const auto& [j, m] : mass.row(i)) {
      subtract(residual[i], m, a[static_cast<std::size_t>(j)]);
      if (static_cast<std::size_t>(j) != i) subtract(residual[static_cast<std::size_t>(j)], m, a[i]);
    }
  for (std::size_t k = 0; k < rows(); ++k)
    for (const auto& [j, w] : J.row(k)) {
      const auto column = static_cast<std::size_t>(j);
      residual[column] = g.sum(residual[column], g.product(w, lambda[k]));
      subtract(below[k], w, a[column]);
    }
  std::vector<int> state = motion.q;
  state.insert(state.end(), motion.qdot.begin(), motion.qdot.end());
  state.insert(state.end(), motion.z.begin(), motion.z.end());
  state.insert(state.end(), parameters.begin(), parameters.end());
  formula::LocalGradient<Number> gradient(g, state);
  return {rows_of(gradient, residual), rows_of(gradient, below), rows_of(gradient, zdot)};
}

}  // namespace qdot::detail
