#pragma once
// SPDX-License-Identifier: MIT
//
// Lagrange's equations of many coordinates, most of which do not meet.
//
//     p = ∂T/∂q̇ ,    r = Q − ∂V/∂q − c                     a walk back for each, and one forwards (coriolis_terms.hpp)
//     M_ij = ∂p_i/∂q̇_j                                     a walk for each row, through what p_i is made of
//     φ = 0:  J = ∂φ/∂q ,    J q̈ = γ = −d/dt (J q̇ + ∂φ/∂t) at q̈ = 0
//     a = 0:  J = ∂a/∂q̇ ,    J q̈ = γ = −d/dt a             at q̈ = 0
//     ∂(r − M q̈ + Jᵀλ)  and  ∂(γ − J q̈)                    along q, q̇ and the effects' states, for implicit methods
//
// T and V of a lattice, a net or a tree of bodies are sums of terms with a few coordinates each. Written down as a
// graph (mechanics/derive/recorded_energies.hpp), they are differentiated where they stand. Rows of M and J have
// entries only where coordinates meet. The work is that of the terms, a hundred nanoseconds or so for an operation,
// once for a run. Derivatives of the equations at given q̈ and λ are more of the same graph.

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "qdot/error.hpp"
#include "qdot/mechanics/derive/free_turns.hpp"
#include "qdot/mechanics/derive/recorded_energies.hpp"

namespace qdot::formula {
template <class Coefficient>
class LocalGradient;  // of ad/formula/local_gradient.hpp
}  // namespace qdot::formula

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

/// The equations of one object as nodes. Variables are q, q̇, t, the effects' states z, then q̈, parameters and λ.
///
/// @tparam Number  of the graph's coefficients
template <class Number>
class TracedEquations {
 public:
  RecordedMotion motion;
  SparseEntries mass;  // lower triangle
  std::vector<int> right, zdot;
  bool finds_free_turns = false;      // whether derive() looks for these
  std::vector<FreeTurn> free_turns;
  std::vector<int> apart;  // where there are some: the right side without the torques of rotations that are followed
  SparseEntries J;
  std::vector<int> phi, velocity, gamma;  // of each row; phi is −1 of what restricts velocities only
  std::vector<formula::Guard> guards;     // of the branch that was recorded
  std::vector<Requirement> requirements;  // slopes of a logarithm are numbers where it is none, and so is a square of a root
  bool mass_is_diagonal = true, mass_is_constant = true;
  formula::MachineCodeBegins begins{};  // of their lines
  std::vector<int> parameters;          // those of T and V that are variables

  /// Variables for n coordinates, `states` states of effects and some parameters.
  TracedEquations(Eigen::Index n, Eigen::Index states, Eigen::Index parameter_count = 0) {
    formula::Recording& r = motion.recording;
    motion.q = new_variables(r, 0, n);
    motion.qdot = new_variables(r, n, n);
    motion.t = r.graph.variable(static_cast<int>(2 * n));
    motion.z = new_variables(r, 2 * n + 1, states);
    parameters = new_variables(r, 3 * n + 1 + states, parameter_count);
  }

  /// Of what has been recorded with such variables, without states of effects.
  explicit TracedEquations(RecordedMotion recorded, Eigen::Index parameter_count = 0) : motion(std::move(recorded)) {
    parameters = new_variables(motion.recording, 3 * static_cast<Eigen::Index>(n()) + 1, parameter_count);
  }

  std::size_t n() const { return motion.q.size(); }
  std::size_t states() const { return motion.z.size(); }
  std::size_t rows() const { return gamma.size(); }
  formula::BasicGraph<Number>& graph() { return motion.recording.graph; }
  const formula::BasicGraph<Number>& graph() const { return motion.recording.graph; }

  /// Derives everything from what the functors returned: T, V, then Q and ż if there are forces, then the rows of constraints.
  ///
  /// @param holonomic  for each row, whether it is φ or a
  void derive(bool has_forces, const std::vector<char>& holonomic);

  /// What implicit methods ask for: rows along q, then q̇, then z, then parameters, of r − M q̈ + Jᵀλ, of γ − J q̈, and of ż.
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
  SparseEntries rows_of(formula::LocalGradient<Number>& gradient, const std::vector<int>& outputs);
  void require_domains();  // of all that the functors have written down, needed or not
  void derive_mass();
  void derive_rows(const std::vector<int>& rows, const std::vector<char>& holonomic);
};

}  // namespace qdot::detail

#ifdef QDOT_COMPILED
namespace qdot::detail {
extern template void TracedEquations<double>::derive(bool, const std::vector<char>&);
extern template TracedEquations<double>::Slopes TracedEquations<double>::slopes();
}  // namespace qdot::detail
#else
#include "qdot/mechanics/derive/traced_equations.ipp"
#endif
