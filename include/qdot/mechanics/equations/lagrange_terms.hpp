#pragma once
// SPDX-License-Identifier: MIT
//
// The terms of Lagrange's equations, straight from T and V by dual numbers.
//
//     M q̈ + D p = ∂L/∂q,      p = ∂L/∂q̇,   M = ∂p/∂q̇,   D = q̇·∂/∂q + ∂/∂t .
//
// D is the derivative along the motion with q̇ held: a *directional* derivative, one perturbation and not n. So is each
// column of M, the derivative of p where nothing changes but one q̇_j. One kind of number is enough for all of them,
//
//     Dual<Dual<S, 1>, n> : ε inside along D or q̇_j, ε_i outside along q̇_i for p, along q_i for ∂T/∂q and ∂V/∂q ,
//
// and T and V are compiled once. (A gradient alone, which symplectic methods ask for, takes Dual<S, n>.) What the
// signatures exclude is not evaluated: T(qdot) has ∂T/∂q = 0. At known accelerations the residual of the equations
// needs no Hessian: M q̈ + D p is the derivative of p along (q̇, q̈, 1). The exact Jacobian of q̈ is made that way
// (acceleration_jacobian.hpp), and so is inverse dynamics.

#include <algorithm>
#include <type_traits>

#include "qdot/ad/derivatives.hpp"
#include "qdot/mechanics/system.hpp"

namespace qdot::detail {

// Scalars D without derivatives.
template <class D, class S, int n>
Vector<D, n> constants(const Vector<S, n>& values) {
  Vector<D, n> x(values.size());
  for (Eigen::Index i = 0; i < values.size(); ++i) x[i] = D(values[i]);
  return x;
}

template <class S, int n>
using TermDual = Dual<Dual<S, 1>, directions_for<n>>;

// ∂T/∂q − ∂V/∂q, n entries, by numbers D: Dual<S, …>, or TermDual where T and V are asked on those anyway.
template <int n, class D, class E, class S>
Vector<S, n> gradient_by(const E& e, const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) {
  Vector<S, n> g(q.size());
  for (Eigen::Index first = 0; first < q.size(); first += D::directions) {
    const Vector<D, n> x = seeded<D>(q, first);
    D L = -potential<n>(e, x, D(t));
    if constexpr (kinetic_signature<E, n>() != KineticSignature::velocity)
      if (kinetic_energy_takes_q<n>(e)) L += kinetic<n>(e, x, constants<D>(qdot), D(t));
    const Eigen::Index end = std::min<Eigen::Index>(q.size(), first + D::directions);
    for (Eigen::Index i = first; i < end; ++i) {
      const typename D::Scalar& slope = L.tangent[static_cast<std::size_t>(i - first)];
      if constexpr (std::is_same_v<typename D::Scalar, S>) g[i] = slope;
      else g[i] = slope.value;
    }
  }
  return g;
}
template <int n, class E, class S>
Vector<S, n> lagrangian_gradient(const E& e, const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) {
  return gradient_by<n, Dual<S, directions_for<n>>>(e, q, qdot, t);
}

// Where in (q, q̇, t) a derivative is taken along: velocities, accelerations, the rate of time.
template <class S, int n>
struct Along {
  Vector<S, n> q, qdot;
  S t;
};

// The derivative of p = ∂T/∂q̇ along a direction.
template <int n, class E, class S>
Vector<S, n> momenta_rate(const E& e, const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t, const Along<S, n>& along) {
  using D = TermDual<S, n>;
  using Inner = typename D::Scalar;
  Vector<S, n> rate(q.size());
  Vector<D, n> x(q.size()), v(q.size());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    x[i].value.value = q[i];
    x[i].value.tangent[0] = along.q[i];
    v[i].value.value = qdot[i];
    v[i].value.tangent[0] = along.qdot[i];
  }
  D time(t);
  time.value.tangent[0] = along.t;
  for (Eigen::Index first = 0; first < q.size(); first += D::directions) {
    const Eigen::Index end = std::min<Eigen::Index>(q.size(), first + D::directions);
    for (Eigen::Index i = first; i < end; ++i) v[i].tangent[static_cast<std::size_t>(i - first)] = Inner(S(1));
    const D T = kinetic<n>(e, x, v, time);
    for (Eigen::Index i = first; i < end; ++i) {
      rate[i] = T.tangent[static_cast<std::size_t>(i - first)].tangent[0];
      v[i].tangent[static_cast<std::size_t>(i - first)] = Inner(S(0));
    }
  }
  return rate;
}

// n numbers that are zero.
template <class S, int n>
Vector<S, n> no_motion(Eigen::Index size) {
  Vector<S, n> none(size);
  for (Eigen::Index i = 0; i < size; ++i) none[i] = S(0);
  return none;
}

// M = ∂²T/∂q̇∂q̇, n×n. Column j is the rate of p where nothing changes but q̇_j.
template <int n, class E, class S>
Matrix<S, n> kinetic_hessian(const E& e, const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) {
  Matrix<S, n> M(q.size(), q.size());
  Along<S, n> along{no_motion<S, n>(q.size()), no_motion<S, n>(q.size()), S(0)};
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    along.qdot[j] = S(1);
    const Vector<S, n> column = momenta_rate<n>(e, q, qdot, t, along);
    along.qdot[j] = S(0);
    for (Eigen::Index i = j; i < q.size(); ++i) M(i, j) = M(j, i) = column[i];
  }
  return M;
}

// d/dt(∂L/∂q̇) − ∂L/∂q at given accelerations: zero on a motion, the applied force otherwise.
template <int n, class E, class S>
Vector<S, n> lagrange_residual(const E& e, const Vector<S, n>& q, const Vector<S, n>& qdot, const Vector<S, n>& qddot, const S& t) {
  Vector<S, n> r = gradient_by<n, TermDual<S, n>>(e, q, qdot, t);
  const Vector<S, n> rate = momenta_rate<n>(e, q, qdot, t, {qdot, qddot, S(1)});
  for (Eigen::Index i = 0; i < q.size(); ++i) r[i] = rate[i] - r[i];
  return r;
}

// ∂L/∂q − D p: everything in Lagrange's equations but M q̈.
template <int n, class E, class S>
Vector<S, n> lagrange_rhs(const E& e, const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) {
  Vector<S, n> r = gradient_by<n, TermDual<S, n>>(e, q, qdot, t);
  if constexpr (kinetic_signature<E, n>() != KineticSignature::velocity) {
    if (!kinetic_energy_takes_q<n>(e)) return r;
    const Vector<S, n> rate = momenta_rate<n>(e, q, qdot, t, {qdot, no_motion<S, n>(q.size()), S(1)});
    for (Eigen::Index i = 0; i < q.size(); ++i) r[i] -= rate[i];
  }
  return r;
}

// These terms of numbers for rare evaluations, by the duals of Jacobians, which carry one derivative more than is needed. So T and V are compiled for
// one kind of dual and not for two.
using Spare = Dual<double, 1>;

template <int rows, int columns>
Matrix<double, rows, columns> values_of(const Matrix<Spare, rows, columns>& x) {
  Matrix<double, rows, columns> values(x.rows(), x.cols());
  for (Eigen::Index k = 0; k < x.size(); ++k) values.data()[k] = x.data()[k].value;
  return values;
}
template <int n, class E>
Matrix<double, n> general_mass_matrix(const E& e, const Vector<double, n>& q, const Vector<double, n>& qdot, double t) {
  return values_of<n, n>(kinetic_hessian<n>(e, constants<Spare>(q), constants<Spare>(qdot), Spare(t)));
}
template <int n, class E>
Vector<double, n> general_rhs(const E& e, const Vector<double, n>& q, const Vector<double, n>& qdot, double t) {
  return values_of<n, 1>(lagrange_rhs<n>(e, constants<Spare>(q), constants<Spare>(qdot), Spare(t)));
}
template <int n, class E>
Vector<double, n> general_gradient(const E& e, const Vector<double, n>& q, const Vector<double, n>& qdot, double t) {
  return values_of<n, 1>(gradient_by<n, TermDual<Spare, n>>(e, constants<Spare>(q), constants<Spare>(qdot), Spare(t)));
}

}  // namespace qdot::detail
