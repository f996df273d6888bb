#pragma once
// SPDX-License-Identifier: MIT
//
// The energies at a state, and what h = q̇·∂T/∂q̇ − T + V does when a component of the state changes.
//
// Of few coordinates h is evaluated beside the state, once for each component. Of many that would cost n² terms, so T and V go on a tape, on numbers with a
// derivative along q̇, and one sweep back brings all slopes:
//
//     ∂h/∂q̇ = M q̇ = D p ,     ∂h/∂q = D ∂T/∂q − ∂T/∂q + ∂V/∂q ,      D along q̇, p = ∂T/∂q̇ .

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <vector>

#include "qdot/ad/dual.hpp"
#include "qdot/mechanics/equations/banded_equations.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot::detail {

// h by one evaluation of T along q̇ and one of V.
struct EnergyAt {
  double T = 0.0, V = 0.0, h = 0.0;

  double size() const { return std::abs(T) + std::abs(V); }
};
template <class System>
[[gnu::noinline]] EnergyAt energy_at(const System& system, double t, const Eigen::VectorXd& y) {
  constexpr int n = System::dof_at_compile_time;
  using D = Dual<double, 1>;
  const Eigen::Index dof = system.dof();
  Vector<D, n> x(dof), v(dof);
  for (Eigen::Index i = 0; i < dof; ++i) {
    x[i] = D(y[i]);
    v[i] = D(y[dof + i]);
    v[i].tangent[0] = y[dof + i];
  }
  const D T = kinetic<n>(system.energies(), x, v, D(t));
  const double V = potential<n>(system.energies(), x, D(t)).value;
  return {T.value, V, T.tangent[0] - T.value + V};
}

// |∂h/∂y|, 2n. Numbers are made of Real, so that programs of few coordinates make none of them.
template <class Real = double, class System>
  requires(System::dof_at_compile_time == Dynamic)
Eigen::VectorXd energy_slopes(const System& system, double t, const Eigen::VectorXd& y) {
  using N = Dual<Real, 1>;
  const Eigen::Index n = system.dof();
  Tape<N> tape(2 * n, 14 * n);
  TapedState<N> state(tape, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    state.q[i].value = N(y[i]);
    state.qdot[i].value = N(y[n + i]);
    state.qdot[i].value.tangent[0] = y[n + i];
  }
  std::vector<N> of_T, of_V;
  tape.sweep(kinetic<Dynamic>(system.energies(), state.q, state.qdot, Reverse<N>(t)), of_T);
  tape.sweep(potential<Dynamic>(system.energies(), state.q, Reverse<N>(t)), of_V);
  Eigen::VectorXd slopes(2 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const N &along_q = of_T[static_cast<std::size_t>(i)], &along_qdot = of_T[static_cast<std::size_t>(n + i)];
    slopes[i] = std::abs(along_q.tangent[0] - along_q.value + of_V[static_cast<std::size_t>(i)].value);
    slopes[n + i] = std::abs(along_qdot.tangent[0]);
  }
  return slopes;
}

}  // namespace qdot::detail
