#pragma once
// SPDX-License-Identifier: MIT
//
// How the accelerations depend on the parameters p of a model: masses, lengths, stiffnesses, gravity.
//
// The energies are made from the parameters, p ↦ (T, V), by a functor that takes the parameters as numbers or as duals alike:
//
//     template <class S> struct Pendulum { S m, l, g;  auto T(…) const;  auto V(…) const; };
//     const auto made = [](const auto& p) { return Pendulum<…Scalar of p…>{p[0], p[1], p[2]}; };
//
// As for the states (acceleration_jacobian.hpp) the solution of the linear system is not differentiated. With r = M q̈ − rhs,
// the equations of motion r(p, q̈) = 0 give
//
//     ∂q̈/∂p = −M⁻¹ ∂r/∂p   at fixed q, q̇, q̈ ,
//
// and r at fixed q̈ needs first derivatives along the motion only.

#include <algorithm>
#include <cstddef>
#include <string>
#include <type_traits>
#include <utility>

#include "qdot/mechanics/equations_of_motion.hpp"

namespace qdot {

namespace detail {

// Energies of duals with the signatures of the same energies of numbers: theirs are asked with vectors of double, which energies of
// duals need not take.
template <class OfDuals, class OfNumbers, int n>
struct WithSignatureOf {
  const OfDuals& energies;

  template <class X, class... More>
    requires(1 + sizeof...(More) == kinetic_arguments<OfNumbers, n>)
  typename X::Scalar T(const X& first, const More&... more) const {
    return energies.T(first, more...);
  }
  template <class X, class... More>
    requires(1 + sizeof...(More) == potential_arguments<OfNumbers, n>)
  typename X::Scalar V(const X& q, const More&... t) const {
    return energies.V(q, t...);
  }
};

template <template <class> class Model, class P, int... i>
auto model_of(const P& p, std::integer_sequence<int, i...>) {
  return Model<typename P::Scalar>{p[i]...};
}

struct WithRespectToParameters {};  // the tag of their perturbations

}  // namespace detail

/// q̈ and its derivatives with respect to the parameters of the model.
template <int n, int m>
struct ParameterJacobian {
  Vector<double, n> qddot;   ///< q̈, n
  Matrix<double, n, m> d_p;  ///< column j: ∂q̈/∂p_j
};

/// q̈ and ∂q̈/∂p at a state, exact, by −M⁻¹ ∂(M q̈ − rhs)/∂p at fixed q̈.
///
/// One residual of Lagrange's equations in duals for m ≤ 16, one for every 8 parameters beyond; M is factored twice, never
/// differentiated. No allocation for fixed n and m.
///
/// @param energies_of  p ↦ an object with members T and V, for a vector p of double and of duals; the object computes with
///                     the scalar of p
/// @param p            parameters, m
/// @param q, qdot      state, n each
/// @throws             as acceleration(), and NonFinite where a derivative is not finite
template <class F, int n, int m>
ParameterJacobian<n, m> acceleration_jacobian_wrt_parameters(const F& energies_of, const Vector<double, m>& p,
                                                             const Vector<double, n>& q, const Vector<double, n>& qdot,
                                                             double t = 0.0) {
  const auto plain = energies_of(p);
  using Energies = std::remove_cvref_t<decltype(plain)>;
  static_assert(detail::require_energies<Energies, n>());
  System<Energies, n> system(plain, q.size());
  system.keep(detail::KeptLines::none());
  detail::require_sizes(system, q, qdot);
  ParameterJacobian<n, m> result;
  result.qddot.resize(q.size());
  result.d_p.resize(q.size(), p.size());
  result.qddot = acceleration(system, q, qdot, t);

  using D = Dual<double, detail::directions_for<m>, detail::WithRespectToParameters>;
  const Vector<D, n> x = q.template cast<D>();
  const Vector<D, n> v = qdot.template cast<D>();
  const Vector<D, n> a = result.qddot.template cast<D>();
  for (Eigen::Index first = 0; first < p.size(); first += D::directions) {
    const auto energies = energies_of(detail::seeded<D>(p, first));
    using OfDuals = std::remove_cvref_t<decltype(energies)>;
    static_assert(!std::is_same_v<OfDuals, Energies>,
                  "qdot: the energies must compute with the scalar of the parameters that they are made from: give the struct "
                  "a template parameter for its members, template <class S> struct Pendulum { S m, l, g; … }");
    const detail::WithSignatureOf<OfDuals, Energies, n> seen{energies};
    const Vector<D, n> r = detail::lagrange_residual<n>(seen, x, v, a, D(t));
    const Eigen::Index end = std::min<Eigen::Index>(p.size(), first + D::directions);
    for (Eigen::Index j = first; j < end; ++j)
      for (Eigen::Index i = 0; i < q.size(); ++i) result.d_p(i, j) = -r[i].tangent[static_cast<std::size_t>(j - first)];
  }
  const Matrix<double, n> M = detail::kinetic_hessian<n>(plain, q, qdot, t);
  result.d_p = detail::solved_with_mass_matrix(system, M, result.d_p, t);
  detail::require_finite_derivatives(
      result.d_p, t, [&](Eigen::Index i) { return detail::sentence({"the acceleration of ", system.coordinate_name(i)}); },
      [](Eigen::Index j) { return detail::sentence({"parameter ", j}); });
  return result;
}

/// q̈ and ∂q̈/∂p of a model whose members are its parameters, in order: template <class S> struct Pendulum { S m, l, g; … }.
///
///     acceleration_jacobian_wrt_parameters<Pendulum>(p, q, qdot)
template <template <class> class Model, int n, int m>
  requires(m != Dynamic)
ParameterJacobian<n, m> acceleration_jacobian_wrt_parameters(const Vector<double, m>& p, const Vector<double, n>& q,
                                                             const Vector<double, n>& qdot, double t = 0.0) {
  return acceleration_jacobian_wrt_parameters(
      [](const auto& parameters) { return detail::model_of<Model>(parameters, std::make_integer_sequence<int, m>{}); }, p, q, qdot, t);
}

}  // namespace qdot
