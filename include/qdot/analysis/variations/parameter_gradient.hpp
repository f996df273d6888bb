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

// Memory for the tapes of one call after the other: asked of the system for each, it would cost as much as what is written to it.
struct GradientTapes {
  using First = Dual<double, 1, AlongTime>;
  using Both = Dual<First, 1, AlongVirtual>;

  template <class N>
  struct Kept {
    Tape<N> tape{0, 0};
    std::vector<N> adjoint{};
  };
  Kept<First> first{};
  Kept<Both> both{};
};

template <class EnergiesOf, int n, int m>
Eigen::VectorXd parameter_gradient(const EnergiesOf& energies_of, const Vector<double, m>& p, const Vector<double, n>& q, const Vector<double, n>& qdot,
                                   const Vector<double, n>& qddot, const Vector<double, n>& u, double t, GradientTapes& tapes) {
  using First = GradientTapes::First;
  using Both = GradientTapes::Both;
  using OfNumbers = std::remove_cvref_t<decltype(energies_of(p))>;
  const auto first = [](double value, double along) {
    First number(value);
    number.tangent[0] = along;
    return number;
  };
  const auto both = [&first](double value, double along_time, double along_virtual) {
    Both number(first(value, along_time));
    number.tangent[0] = First(along_virtual);
    return number;
  };
  Eigen::VectorXd slopes = Eigen::VectorXd::Zero(p.size());
  const auto add = [&]<class N>(GradientTapes::Kept<N>& kept, const N& time, const auto& q_of, const auto& qdot_of, const auto& lagrangian, const auto& share) {
    using R = Reverse<N>;
    auto& [tape, adjoint] = kept;
    tape.nodes.clear();
    Vector<R, m> variables(p.size());
    for (Eigen::Index j = 0; j < p.size(); ++j) variables[j] = tape.variable(j, N(p[j]));
    const auto energies = energies_of(variables);
    const WithSignatureOf<std::remove_cvref_t<decltype(energies)>, OfNumbers, n> seen{energies};
    Vector<R, n> x(q.size()), v(q.size());
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      x[i] = R(q_of(i));
      v[i] = R(qdot_of(i));
    }
    const R L = lagrangian(seen, x, v, R(time));
    if (L.node < 0) return;
    tape.sweep(L, adjoint);
    for (Eigen::Index j = 0; j < p.size(); ++j) slopes[j] += share(adjoint[static_cast<std::size_t>(j)]);
  };
  add(tapes.first, first(t, 0.0), [&](Eigen::Index i) { return first(q[i], u[i]); }, [&](Eigen::Index i) { return first(qdot[i], 0.0); },
      [](const auto& seen, const auto& x, const auto& v, const auto& time) {
        auto L = kinetic<n>(seen, x, v, time);
        L -= potential<n>(seen, x, time);
        return L;
      },
      [](const First& slope) { return slope.tangent[0]; });
  add(tapes.both, both(t, 1.0, 0.0), [&](Eigen::Index i) { return both(q[i], qdot[i], 0.0); }, [&](Eigen::Index i) { return both(qdot[i], qddot[i], u[i]); },
      [](const auto& seen, const auto& x, const auto& v, const auto& time) { return kinetic<n>(seen, x, v, time); },
      [](const Both& slope) { return -slope.tangent[0].tangent[0]; });
  return slopes;
}

}  // namespace qdot::detail
