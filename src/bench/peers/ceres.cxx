// SPDX-License-Identifier: MIT
//
// Lagrange's equations by nested jets of Ceres, the cheapest way that we know of: three seeds, no full Hessian, and Eigen's LLT of
// fixed size.
#include <ceres/jet.h>

#include <Eigen/Cholesky>

#include "bench/peers/peer.hpp"

namespace {

using ceres::Jet;

// Jets take no plain number for a constant when they are nested.
template <class S>
struct Constant {
  static S of(double x) { return S(x); }
};
template <class S, int n>
struct Constant<Jet<S, n>> {
  static Jet<S, n> of(double x) {
    Jet<S, n> r;
    r.a = Constant<S>::of(x);
    for (int i = 0; i < n; ++i) r.v[i] = Constant<S>::of(0.0);
    return r;
  }
};

template <int n, class S>
S kinetic(const S* q, const S* qdot) {
  S vx = Constant<S>::of(0.0), vy = vx, sum = vx;
  const S half = Constant<S>::of(0.5);
  for (int k = 0; k < n; ++k) {
    vx += cos(q[k]) * qdot[k];
    vy += sin(q[k]) * qdot[k];
    sum += half * (vx * vx + vy * vy);
  }
  return sum;
}
template <int n, class S>
S potential(const S* q) {
  S y = Constant<S>::of(0.0), sum = y;
  const S g = Constant<S>::of(9.81);
  for (int k = 0; k < n; ++k) {
    y -= cos(q[k]);
    sum += g * y;
  }
  return sum;
}

template <int n>
void chain(const double* q, const double* qdot, double* qddot) {
  using Column = Eigen::Matrix<double, n, 1>;
  Eigen::Matrix<double, n, n> M;
  Column r;
  {  // ∂L/∂q
    using J = Jet<double, n>;
    J x[n], v[n];
    for (int i = 0; i < n; ++i) {
      x[i] = J(q[i], i);
      v[i] = J(qdot[i]);
    }
    r = (kinetic<n>(x, v) - potential<n>(x)).v;
  }
  {  // the derivative of ∂T/∂q̇ along q̇
    using Along = Jet<double, 1>;
    using J = Jet<Along, n>;
    J x[n], v[n];
    for (int i = 0; i < n; ++i) {
      x[i] = Constant<J>::of(q[i]);
      x[i].a.v[0] = qdot[i];
      v[i] = Constant<J>::of(qdot[i]);
      v[i].v[i] = Along(1.0);
    }
    const J T = kinetic<n>(x, v);
    for (int i = 0; i < n; ++i) r[i] -= T.v[i].v[0];
  }
  {  // ∂²T/∂q̇∂q̇
    using Inner = Jet<double, n>;
    using J = Jet<Inner, n>;
    J x[n], v[n];
    for (int i = 0; i < n; ++i) {
      x[i] = Constant<J>::of(q[i]);
      v[i] = Constant<J>::of(qdot[i]);
      v[i].a.v[i] = 1.0;
      v[i].v[i] = Inner(1.0);
    }
    const J T = kinetic<n>(x, v);
    for (int i = 0; i < n; ++i) M.row(i) = T.v[i].v;
  }
  Eigen::Map<Column>{qddot} = M.llt().solve(r);
}

}  // namespace

extern "C" ChainAcceleration acceleration_of_chain(int n) {
  return of_links<1, 2, 4, 8>(n, []<int links>() -> ChainAcceleration { return chain<links>; });
}
