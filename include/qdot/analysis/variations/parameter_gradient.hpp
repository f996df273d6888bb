#pragma once
// SPDX-License-Identifier: MIT
//
// ∂(u·(rhs − M q̈))/∂p at fixed q, q̇, q̈ of energies that are made from many parameters, at the cost of a few evaluations of T and V.
//
// Along a displacement u of the coordinates Lagrange's equations are one number,
//
//     u·(rhs − M q̈) = ∂L/∂q·u − d/dt (∂L/∂q̇·u) ,
//
// whose second term is the mixed coefficient ε₁ε₂ of L(q + ε₁q̇, q̇ + ε₁q̈ + ε₂u, t + ε₁), and whose first is that of ε in L(q + εu, q̇, t). With a
// tape (ad/records/tape.hpp) of such dual numbers over p, one sweep backwards has its slopes in all parameters.

#include <Eigen/Core>
#include <type_traits>
#include <vector>

#include "qdot/ad/records/reverse.hpp"
#include "qdot/mechanics/equations/energy_functors.hpp"
#include "qdot/mechanics/parameter_jacobian.hpp"

namespace qdot::detail {

struct AlongTime {};
struct AlongVirtual {};

template <class EnergiesOf, int n, int m>
Eigen::VectorXd parameter_gradient(const EnergiesOf& energies_of, const Vector<double, m>& p, const Vector<double, n>& q, const Vector<double, n>& qdot,
                                   const Vector<double, n>& qddot, const Vector<double, n>& u, double t) {
  using First = Dual<double, 1, AlongTime>;
  using N = Dual<First, 1, AlongVirtual>;
  using R = Reverse<N>;
  using OfNumbers = std::remove_cvref_t<decltype(energies_of(p))>;
  const auto number = [](double value, double first, double second) {
    First inner(value);
    inner.tangent[0] = first;
    N outer(inner);
    outer.tangent[0] = First(second);
    return R(outer);
  };
  Eigen::VectorXd slopes = Eigen::VectorXd::Zero(p.size());
  const auto add = [&](bool with_potential, const auto& q_of, const auto& qdot_of, const R& time, const auto& share) {
    Tape<N> tape(p.size(), 16 * p.size());
    Vector<R, m> variables(p.size());
    for (Eigen::Index j = 0; j < p.size(); ++j) variables[j] = tape.variable(j, N(p[j]));
    const auto energies = energies_of(variables);
    const WithSignatureOf<std::remove_cvref_t<decltype(energies)>, OfNumbers, n> seen{energies};
    Vector<R, n> x(q.size()), v(q.size());
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      x[i] = q_of(i);
      v[i] = qdot_of(i);
    }
    R L = kinetic<n>(seen, x, v, time);
    if (with_potential) L = L - potential<n>(seen, x, time);
    std::vector<N> adjoint;
    tape.sweep(L, adjoint);
    for (Eigen::Index j = 0; L.node >= 0 && j < p.size(); ++j) slopes[j] += share(adjoint[static_cast<std::size_t>(j)]);
  };
  add(true, [&](Eigen::Index i) { return number(q[i], u[i], 0.0); }, [&](Eigen::Index i) { return number(qdot[i], 0.0, 0.0); }, number(t, 0.0, 0.0),
      [](const N& x) { return x.value.tangent[0]; });
  add(false, [&](Eigen::Index i) { return number(q[i], qdot[i], 0.0); }, [&](Eigen::Index i) { return number(qdot[i], qddot[i], u[i]); }, number(t, 1.0, 0.0),
      [](const N& x) { return -x.tangent[0].tangent[0]; });
  return slopes;
}

}  // namespace qdot::detail
