#pragma once
// SPDX-License-Identifier: MIT
//
// Energies and momenta of a state.
//
//     L = T − V                     the Lagrangian
//     E = T + V                     the energy
//     p = ∂L/∂q̇                     conjugate momenta; p_i is conserved where q_i does not occur in L
//     h = q̇·p − L                   Jacobi's energy function; conserved where t does not occur in L
//
// h equals E when T is quadratic in q̇ (Euler's theorem gives q̇·p = 2T). When T has terms of degree
// 1 or 0, as in a rotating frame, it is h that stays constant and not E.
//
// Every function takes a system, or a scene, and a state, as (q, qdot, t) or as one State; t may be left out where nothing depends on it. T and V of a
// scene hold the terms of its effects. q and qdot may hold duals: the results then are duals.

#include <type_traits>

#include "qdot/ad/dual.hpp"
#include "qdot/mechanics/equations/lagrange_terms.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot {

/// Kinetic energy T at a state; one evaluation of T.
///
/// @param model  from mechanical_system() or scene()
/// @param q      coordinates, n
/// @param qdot   velocities, n
/// @throws       DimensionError when n is known at run time and a size disagrees
template <HasEnergies M, class Q = Coordinates<M>, class Qdot = Coordinates<M>>
auto kinetic_energy(const M& model, const Q& q, const Qdot& qdot, typename Q::Scalar t = typename Q::Scalar(0)) {
  constexpr int n = M::dof_at_compile_time;
  using S = typename Q::Scalar;
  detail::require_sizes(model.system(), q, qdot);
  return detail::kinetic<n>(model.system().energies(), Vector<S, n>(q), Vector<S, n>(qdot), t);
}

/// Potential energy V at a configuration; one evaluation of V.
template <HasEnergies M, class Q = Coordinates<M>>
auto potential_energy(const M& model, const Q& q, typename Q::Scalar t = typename Q::Scalar(0)) {
  constexpr int n = M::dof_at_compile_time;
  using S = typename Q::Scalar;
  detail::require_sizes(model.system(), q, q);
  return detail::potential<n>(model.system().energies(), Vector<S, n>(q), t);
}

/// L = T − V at a state.
template <HasEnergies M, class Q = Coordinates<M>, class Qdot = Coordinates<M>>
auto lagrangian(const M& model, const Q& q, const Qdot& qdot, typename Q::Scalar t = typename Q::Scalar(0)) {
  using S = typename Q::Scalar;
  return S(kinetic_energy(model, q, qdot, t) - potential_energy(model, q, t));
}

/// E = T + V at a state; constant on a motion only where T is a quadratic form of q̇. Where it is not, jacobi_energy() is.
template <HasEnergies M, class Q = Coordinates<M>, class Qdot = Coordinates<M>>
auto energy(const M& model, const Q& q, const Qdot& qdot, typename Q::Scalar t = typename Q::Scalar(0)) {
  using S = typename Q::Scalar;
  return S(kinetic_energy(model, q, qdot, t) + potential_energy(model, q, t));
}

/// ∂L/∂q at a state, n entries.
template <HasEnergies M, class Q = Coordinates<M>, class Qdot = Coordinates<M>>
auto lagrangian_gradient(const M& model, const Q& q, const Qdot& qdot, typename Q::Scalar t = typename Q::Scalar(0)) {
  constexpr int n = M::dof_at_compile_time;
  using S = typename Q::Scalar;
  detail::require_sizes(model.system(), q, qdot);
  return detail::lagrangian_gradient<n>(model.system().energies(), Vector<S, n>(q), Vector<S, n>(qdot), t);
}

namespace detail {
struct SlopeByVelocity {};  // the tag of perturbations of q̇
}  // namespace detail

/// p = ∂L/∂q̇ at a state, n entries.
template <HasEnergies M, class Q = Coordinates<M>, class Qdot = Coordinates<M>>
auto conjugate_momenta(const M& model, const Q& q, const Qdot& qdot, typename Q::Scalar t = typename Q::Scalar(0)) {
  constexpr int n = M::dof_at_compile_time;
  using S = typename Q::Scalar;
  detail::require_sizes(model.system(), q, qdot);
  const Vector<S, n> at = q;
  return gradient(detail::marked<detail::SlopeByVelocity>([&](const auto& v) {
    using D = typename std::remove_cvref_t<decltype(v)>::Scalar;
    return detail::kinetic<n>(model.system().energies(), Vector<D, n>(at.template cast<D>()), v, D(t));
  }), Vector<S, n>(qdot));
}

/// h = q̇·p − L, Jacobi's energy function, which is constant on a motion of an autonomous system. One evaluation of T along q̇, whose
/// slope is q̇·p, and one of V.
template <HasEnergies M, class Q = Coordinates<M>, class Qdot = Coordinates<M>>
auto jacobi_energy(const M& model, const Q& q, const Qdot& qdot, typename Q::Scalar t = typename Q::Scalar(0)) {
  constexpr int n = M::dof_at_compile_time;
  using S = typename Q::Scalar;
  using D = Dual<S, 1>;
  detail::require_sizes(model.system(), q, qdot);
  const Vector<S, n> at = q;
  Vector<D, n> x(q.size()), v(q.size());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    x[i] = D(q[i]);
    v[i] = D(qdot[i]);
    v[i].tangent[0] = qdot[i];
  }
  const D T = detail::kinetic<n>(model.system().energies(), x, v, D(t));
  return S(T.tangent[0] - T.value + detail::potential<n>(model.system().energies(), at, t));
}

/// T at a State.
template <HasEnergies M>
double kinetic_energy(const M& model, const State<M::dof_at_compile_time>& state) {
  return kinetic_energy(model, state.q, state.qdot, state.t);
}
/// V at a State.
template <HasEnergies M>
double potential_energy(const M& model, const State<M::dof_at_compile_time>& state) {
  return potential_energy(model, state.q, state.t);
}
/// L = T − V at a State.
template <HasEnergies M>
double lagrangian(const M& model, const State<M::dof_at_compile_time>& state) {
  return lagrangian(model, state.q, state.qdot, state.t);
}
/// E = T + V at a State; where T is no quadratic form of q̇, jacobi_energy() is what a motion conserves.
template <HasEnergies M>
double energy(const M& model, const State<M::dof_at_compile_time>& state) {
  return energy(model, state.q, state.qdot, state.t);
}
/// ∂L/∂q at a State, n entries.
template <HasEnergies M>
Coordinates<M> lagrangian_gradient(const M& model, const State<M::dof_at_compile_time>& state) {
  return lagrangian_gradient(model, state.q, state.qdot, state.t);
}
/// p = ∂L/∂q̇ at a State, n entries.
template <HasEnergies M>
Coordinates<M> conjugate_momenta(const M& model, const State<M::dof_at_compile_time>& state) {
  return conjugate_momenta(model, state.q, state.qdot, state.t);
}
/// h = q̇·p − L at a State.
template <HasEnergies M>
double jacobi_energy(const M& model, const State<M::dof_at_compile_time>& state) {
  return jacobi_energy(model, state.q, state.qdot, state.t);
}

}  // namespace qdot
