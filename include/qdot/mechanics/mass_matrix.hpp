#pragma once
// SPDX-License-Identifier: MIT
//
// The mass matrix, M = ∂²T/∂q̇∂q̇.
//
// p = M q̇ for kinetic energies of second degree, and ½ q̇ᵀM q̇ is then T. What it means when M is singular is told in mechanics/equations/solve.hpp.

#include <type_traits>

#include "qdot/mechanics/mass_and_rhs.hpp"

namespace qdot {

/// Mass matrix M(q, q̇) = ∂²T/∂q̇∂q̇ at a state.
///
/// Of a system, or a scene, whose T holds the terms of its effects. Exact to rounding, by the shortest way (mass_and_rhs.hpp).
///
/// @param q     generalized coordinates, n      [units of the model]
/// @param qdot  generalized velocities, n       [those units per unit time]
/// @return      n×n, symmetric; positive definite wherever T is a true kinetic energy
/// @throws      DimensionError  when n is known at run time and a size disagrees
template <HasEnergies Model, class Q = Coordinates<Model>, class Qdot = Coordinates<Model>>
auto mass_matrix(const Model& model, const Q& q, const Qdot& qdot, typename Q::Scalar t = typename Q::Scalar(0)) {
  using S = typename Q::Scalar;
  constexpr int n = Model::dof_at_compile_time;
  const auto& system = model.system();
  detail::require_sizes(system, q, qdot);
  if constexpr (std::is_same_v<S, double>) {
    Matrix<double, n> M = detail::zeros<Matrix<double, n>>(q.size(), q.size());
    if (detail::with_mass_and_rhs<n>(system.energies(), Vector<double, n>(q), Vector<double, n>(qdot), t, detail::MassTo<n>{M}, system.kept_lines()))
      return M;
  }
  if constexpr (std::is_same_v<S, double>) return detail::general_mass_matrix<n>(system.energies(), Vector<double, n>(q), Vector<double, n>(qdot), t);
  else return detail::kinetic_hessian<n>(system.energies(), Vector<S, n>(q), Vector<S, n>(qdot), t);
}
/// M at a State.
template <HasEnergies Model>
Matrix<double, Model::dof_at_compile_time> mass_matrix(const Model& model, const State<Model::dof_at_compile_time>& state) {
  return mass_matrix(model, state.q, state.qdot, state.t);
}

}  // namespace qdot
