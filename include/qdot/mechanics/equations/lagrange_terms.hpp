#pragma once
// SPDX-License-Identifier: MIT
//
// The terms of Lagrange's equations, straight from T and V by dual numbers.
//
// With L = T − V, Lagrange's equations d/dt(∂L/∂q̇) = ∂L/∂q read, after the product rule,
//
//     M q̈ + D p = ∂L/∂q,      p = ∂L/∂q̇,   M = ∂p/∂q̇,   D = q̇·∂/∂q + ∂/∂t .
//
// D is the derivative along the motion with q̇ held: a *directional* derivative, one perturbation
// and not n. So three sets of derivatives are enough, none of them a full Hessian:
//
//     ∂T/∂q, ∂V/∂q     Dual<S, n> seeded in q
//     p and D p        Dual<Dual<S, 1>, n>: ε inside along D, ε_i outside along q̇_i
//     M                Dual<Dual<S, n>, n> seeded in q̇ twice
//
// What the signatures exclude is not evaluated: T(qdot) has ∂T/∂q = 0 and D p = 0.
//
// When the accelerations are known, the residual of the equations needs no Hessian at all: M q̈ + D p is
// the derivative of p along (q̇, q̈, 1). That is how the exact Jacobian of q̈ is made
// (equations_of_motion.hpp), and what inverse dynamics is.

#include <algorithm>

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

// ∂T/∂q − ∂V/∂q, n entries.
template <int n, class E, class S>
Vector<S, n> lagrangian_gradient(const E& e, const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) {
  using D = Dual<S, directions_for<n>>;
  Vector<S, n> g(q.size());
  for (Eigen::Index first = 0; first < q.size(); first += D::directions) {
    const Vector<D, n> x = seeded<D>(q, first);
    D L = -potential<n>(e, x, D(t));
    if constexpr (kinetic_signature<E, n>() != KineticSignature::velocity) {
      L += kinetic<n>(e, x, constants<D>(qdot), D(t));
    }
    const Eigen::Index end = std::min<Eigen::Index>(q.size(), first + D::directions);
    for (Eigen::Index i = first; i < end; ++i) g[i] = L.tangent[static_cast<std::size_t>(i - first)];
  }
  return g;
}

// p = ∂T/∂q̇ and its derivative along (q̇, a, 1).
template <class S, int n>
struct MomentaAndRate {
  Vector<S, n> p;
  Vector<S, n> rate;
};

template <int n, class E, class S>
MomentaAndRate<S, n> momenta_and_rate(const E& e, const Vector<S, n>& q, const Vector<S, n>& qdot,
                                      const Vector<S, n>& a, const S& t) {
  using Along = Dual<S, 1>;
  using D = Dual<Along, directions_for<n>>;
  MomentaAndRate<S, n> r{Vector<S, n>(q.size()), Vector<S, n>(q.size())};
  Vector<D, n> x(q.size());
  Vector<D, n> v(q.size());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    x[i].value.value = q[i];
    x[i].value.tangent[0] = qdot[i];
    v[i].value.value = qdot[i];
    v[i].value.tangent[0] = a[i];
  }
  D time(Along::variable(t, 0));
  for (Eigen::Index first = 0; first < q.size(); first += D::directions) {
    const Eigen::Index end = std::min<Eigen::Index>(q.size(), first + D::directions);
    for (Eigen::Index i = first; i < end; ++i) v[i].tangent[static_cast<std::size_t>(i - first)] = Along(S(1));
    const D T = kinetic<n>(e, x, v, time);
    for (Eigen::Index i = first; i < end; ++i) {
      const Along& p = T.tangent[static_cast<std::size_t>(i - first)];
      r.p[i] = p.value;
      r.rate[i] = p.tangent[0];
      v[i].tangent[static_cast<std::size_t>(i - first)] = Along(S(0));
    }
  }
  return r;
}

// M = ∂²T/∂q̇∂q̇, n×n.
template <int n, class E, class S>
Matrix<S, n> kinetic_hessian(const E& e, const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) {
  using Inner = Dual<S, directions_for<n>>;
  using D = Dual<Inner, directions_for<n>>;
  Matrix<S, n> M(q.size(), q.size());
  const Eigen::Index size = q.size();
  const Vector<D, n> x = constants<D>(q);
  Vector<D, n> v = constants<D>(qdot);
  constexpr Eigen::Index width = D::directions;
  for (Eigen::Index row = 0; row < size; row += width) {
    const Eigen::Index row_end = std::min<Eigen::Index>(size, row + width);
    for (Eigen::Index column = 0; column <= row; column += width) {
      const Eigen::Index column_end = std::min<Eigen::Index>(size, column + width);
      for (Eigen::Index i = row; i < row_end; ++i) v[i].tangent[static_cast<std::size_t>(i - row)] = Inner(S(1));
      for (Eigen::Index j = column; j < column_end; ++j) v[j].value.tangent[static_cast<std::size_t>(j - column)] = S(1);
      const D T = kinetic<n>(e, x, v, D(Inner(t)));
      for (Eigen::Index i = row; i < row_end; ++i)
        for (Eigen::Index j = column; j < std::min<Eigen::Index>(column_end, i + 1); ++j)
          M(i, j) = M(j, i) = T.tangent[static_cast<std::size_t>(i - row)].tangent[static_cast<std::size_t>(j - column)];
      for (Eigen::Index i = row; i < row_end; ++i) v[i].tangent[static_cast<std::size_t>(i - row)] = Inner(S(0));
      for (Eigen::Index j = column; j < column_end; ++j) v[j].value.tangent[static_cast<std::size_t>(j - column)] = S(0);
    }
  }
  return M;
}

// ∂L/∂q − D p: everything in Lagrange's equations but M q̈.
template <int n, class E, class S>
Vector<S, n> lagrange_rhs(const E& e, const Vector<S, n>& q, const Vector<S, n>& qdot, const S& t) {
  Vector<S, n> r = lagrangian_gradient<n>(e, q, qdot, t);
  if constexpr (kinetic_signature<E, n>() != KineticSignature::velocity) {
    Vector<S, n> held(q.size());
    for (Eigen::Index i = 0; i < q.size(); ++i) held[i] = S(0);
    const Vector<S, n> rate = momenta_and_rate<n>(e, q, qdot, held, t).rate;
    for (Eigen::Index i = 0; i < q.size(); ++i) r[i] -= rate[i];
  }
  return r;
}

// d/dt(∂L/∂q̇) − ∂L/∂q at given accelerations: zero on a motion, the applied force otherwise.
template <int n, class E, class S>
Vector<S, n> lagrange_residual(const E& e, const Vector<S, n>& q, const Vector<S, n>& qdot, const Vector<S, n>& qddot,
                               const S& t) {
  Vector<S, n> r = momenta_and_rate<n>(e, q, qdot, qddot, t).rate;
  r -= lagrangian_gradient<n>(e, q, qdot, t);
  return r;
}

}  // namespace qdot::detail
