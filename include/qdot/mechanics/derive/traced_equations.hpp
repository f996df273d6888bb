#pragma once
// SPDX-License-Identifier: MIT
//
// Lagrange's equations of many coordinates, most of which do not meet.
//
// T and V of a lattice, of a net or of a tree of bodies are sums of terms with a few coordinates each. Written down as a graph
// (mechanics/derive/recorded_energies.hpp) they can be differentiated where they stand,
//
//     p = ∂T/∂q̇ ,    r = Q − ∂V/∂q − c                     a walk back for each, and one forwards (coriolis_terms.hpp)
//     M_ij = ∂p_i/∂q̇_j                                     a walk for each row, through what p_i is made of
//     φ = 0:  J = ∂φ/∂q ,    J q̈ = γ = −d/dt (J q̇ + ∂φ/∂t) at q̈ = 0
//     a = 0:  J = ∂a/∂q̇ ,    J q̈ = γ = −d/dt a             at q̈ = 0
//
// and what is not there is not found: rows of M and J have entries where coordinates meet. The work is that of the terms, a hundred nanoseconds or
// so for an operation, once for a run.
//
// Derivatives of the equations at given q̈ and λ, for implicit methods, are more of the same graph:
//
//     ∂(r − M q̈ + Jᵀλ)  and  ∂(γ − J q̈)  along q, q̇ and the effects' states.

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "qdot/ad/formula/local_gradient.hpp"
#include "qdot/error.hpp"
#include "qdot/mechanics/derive/coriolis_terms.hpp"
#include "qdot/mechanics/derive/rates_of_nodes.hpp"
#include "qdot/mechanics/derive/recorded_energies.hpp"

namespace qdot::detail {

/// Entries of a sparse matrix, row by row; what an entry is, a node or where its value stands, is up to the user.
struct SparseEntries {
  struct Entry {
    int column, what;
  };
  std::vector<std::size_t> starts{0};
  std::vector<Entry> entries;

  std::size_t rows() const { return starts.size() - 1; }
  std::span<const Entry> row(std::size_t i) const { return {entries.data() + starts[i], entries.data() + starts[i + 1]}; }
  void end_row() { starts.push_back(entries.size()); }
  std::vector<int> nodes() const {
    std::vector<int> all;
    for (const Entry& e : entries) all.push_back(e.what);
    return all;
  }
};

/// What must hold of a node's value x for the functors to have one: x − value is in the domain.
struct Requirement {
  int node;
  formula::Domain domain;
  double value = 0.0;

  bool holds(double x) const { return is_in(domain, x - value); }
};

/// The equations of one object as nodes. Variables are q, q̇, t, the effects' states z, then q̈ and λ.
///
/// @tparam Number  of the graph's coefficients
template <class Number = double>
class TracedEquations {
 public:
  RecordedMotion motion;
  SparseEntries mass;  // lower triangle
  std::vector<int> right, zdot;
  SparseEntries J;
  std::vector<int> phi, velocity, gamma;  // of each row; phi is −1 of what restricts velocities only
  std::vector<Requirement> requirements;  // slopes of a logarithm are numbers where it is none, and so is a square of a root
  bool mass_is_diagonal = true, mass_is_constant = true;
  formula::MachineCodeBegins begins{};  // of their lines

  /// Variables for n coordinates and `states` states of effects.
  TracedEquations(Eigen::Index n, Eigen::Index states) {
    formula::Recording& r = motion.recording;
    motion.q = new_variables(r, 0, n);
    motion.qdot = new_variables(r, n, n);
    motion.t = r.graph.variable(static_cast<int>(2 * n));
    motion.z = new_variables(r, 2 * n + 1, states);
  }

  std::size_t n() const { return motion.q.size(); }
  std::size_t states() const { return motion.z.size(); }
  std::size_t rows() const { return gamma.size(); }
  formula::BasicGraph<Number>& graph() { return motion.recording.graph; }

  /// Derives everything from what the functors returned: T, V, then Q and ż if there are forces, then the rows of constraints.
  ///
  /// @param holonomic  for each row, whether it is φ or a
  void derive(bool has_forces, const std::vector<char>& holonomic);

  /// What implicit methods ask for: rows along q, then q̇, then z, of r − M q̈ + Jᵀλ, of γ − J q̈, and of ż.
  struct Slopes {
    SparseEntries motion, constraints, states;
  };
  Slopes slopes();

 private:
  // Where all coordinates meet in sums of sums, as in a long chain with one angle after the other, there are as many entries as pairs, and each is long.
  void require_short() {
    if (graph().nodes().size() > 1'000'000 + 200 * n()) 
      throw InvalidValue("equations that are traced must be short, but these have more than 200 operations for each coordinate; evaluate T and V as they are");
  }

  bool is_zero(int node) { return graph().is_constant(node, 0.0); }

  [[gnu::cold]] SparseEntries rows_of(formula::LocalGradient<Number>& gradient, const std::vector<int>& outputs) {
    SparseEntries all;
    for (const int output : outputs) {
      for (const auto& [j, node] : gradient.of(output))
        if (!is_zero(node)) all.entries.push_back({j, node});
      all.end_row();
      require_short();
    }
    return all;
  }

  // Of all that the functors have written down, needed or not.
  [[gnu::cold]] void require_domains() {
    const auto& nodes = graph().nodes();
    for (std::size_t w = 0; w < nodes.size(); ++w)
      if (nodes[w].domain != formula::Domain::everything) requirements.push_back({static_cast<int>(w), nodes[w].domain});
    for (const auto& assumption : motion.recording.assumptions) requirements.push_back({assumption.node, formula::Domain::nonzero, assumption.value});
  }

  [[gnu::cold]] void derive_mass() {
    formula::LocalGradient<Number> gradient(graph(), motion.qdot);
    for (std::size_t i = 0; i < n(); ++i) {
      for (const auto& [j, node] : gradient.of(motion.p[i])) {
        if (static_cast<std::size_t>(j) > i || is_zero(node)) continue;
        mass.entries.push_back({j, node});
        mass_is_diagonal = mass_is_diagonal && static_cast<std::size_t>(j) == i;
        mass_is_constant = mass_is_constant && graph()[node].kind == formula::Kind::constant;
      }
      mass.end_row();
      require_short();
    }
  }

  [[gnu::cold]] void derive_rows(const std::vector<int>& rows, const std::vector<char>& holonomic) {
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
};

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
  const std::vector<int> terms = CoriolisTerms<formula::BasicGraph<Number>>(rates, static_cast<int>(n())).of(T);
  for (std::size_t i = 0; i < n(); ++i) right[i] = g.difference(right[i], terms[i]);
  rates.remember(velocity);
  for (const int c : velocity) gamma.push_back(g.scaled(rates.of(c), -1.0));
}

template <class Number>
[[gnu::cold]] typename TracedEquations<Number>::Slopes TracedEquations<Number>::slopes() {
  formula::BasicGraph<Number>& g = graph();
  const int first = static_cast<int>(2 * n() + 1 + states());
  std::vector<int> a, lambda;
  for (std::size_t i = 0; i < n(); ++i) a.push_back(g.variable(first + static_cast<int>(i)));
  for (std::size_t k = 0; k < rows(); ++k) lambda.push_back(g.variable(first + static_cast<int>(n() + k)));
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
  formula::LocalGradient<Number> gradient(g, state);
  return {rows_of(gradient, residual), rows_of(gradient, below), rows_of(gradient, zdot)};
}

#ifdef QDOT_COMPILED
extern template void TracedEquations<double>::derive(bool, const std::vector<char>&);
extern template TracedEquations<double>::Slopes TracedEquations<double>::slopes();
#endif

}  // namespace qdot::detail
