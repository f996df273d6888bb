#pragma once
// SPDX-License-Identifier: MIT
//
// q̈ of small systems with its derivatives, and the slopes of their equations at q̈ that are known, as straight-line code.
//
// A motion with accelerations a satisfies X L = 0 when D, the derivative along the motion in the scalar of
// ad/lagrange/euler_lagrange.hpp, includes them:
//
//     D = q̇·∂/∂q + a·∂/∂q̇ + ∂/∂t ,      X L = ∂L/∂q − D ∂L/∂q̇ = rhs − M a .
//
// That scalar needs nothing but a velocity's rate, a_i instead of zero. It then finds X L without second derivatives in q̇, and by the
// implicit function theorem
//
//     ∂q̈/∂(q, q̇) = M⁻¹ ∂(X L)/∂(q, q̇)      at fixed a = q̈ .
//
// So the scalar is evaluated a second time with dual numbers inside (ad/lagrange/paired_dual.hpp) and without its Hessian; the compiler merges what both
// passes have in common.

#include <utility>

#include <Eigen/Core>

#include "qdot/ad/lagrange/paired_dual.hpp"
#include "qdot/mechanics/equations/straight_line.hpp"

namespace qdot::detail {

// A row of derivatives along q and q̇, and what else there is. Not one of Eigen's: what it makes of eight entries g++ does not always see through.
template <int columns>
struct SlopeRow {
  double entry[columns];

  [[gnu::always_inline]] double& operator[](Eigen::Index j) { return entry[j]; }
  [[gnu::always_inline]] double operator[](Eigen::Index j) const { return entry[j]; }
  [[gnu::always_inline]] friend SlopeRow operator*(const SlopeRow& a, double b) {
    SlopeRow product;
    unroll<columns>([&](auto j) __attribute__((always_inline)) { product.entry[j] = a.entry[j] * b; });
    return product;
  }
  [[gnu::always_inline]] friend SlopeRow operator*(double a, const SlopeRow& b) { return b * a; }
  [[gnu::always_inline]] SlopeRow& operator-=(const SlopeRow& b) {
    unroll<columns>([&](auto j) __attribute__((always_inline)) { entry[j] -= b.entry[j]; });
    return *this;
  }
  [[gnu::always_inline]] friend SlopeRow operator-(SlopeRow a, const SlopeRow& b) { return a -= b; }
};

// The columns of n such rows; false where a number is not finite.
template <int n, class Row>
bool columns_written(const Row* rows, double* d_q, double* d_qdot) {
  double zero = 0.0;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      d_q[i + n * j] = rows[i][j];
      d_qdot[i + n * j] = rows[i][n + j];
    }
    double sum = 0.0;
    for (int j = 0; j < 2 * n; ++j) sum += rows[i][j];
    zero += sum - sum;
  }
  return zero == 0.0;
}

// Largest n for this way: a chain of 4 takes some seconds to compile.
inline constexpr int straight_line_jacobian_limit = 4;

// The scalar of Lagrange's equations without its Hessian.
template <int n, class Number>
using LagrangeResidual = EulerLagrange<n, Number, std::make_integer_sequence<int, n>, std::integer_sequence<int>>;

// Rotations would take the compiler minutes. A number with a bit above those of all components stands for them, and what follows from it is dropped.
inline constexpr ComponentMask of_rotation = bit(1, 63);
template <int n, int pairs, class Is, class K>
struct MovingPositions<EulerLagrange<n, PairedDual<pairs>, Is, K>> {
  using S = EulerLagrange<n, PairedDual<pairs>, Is, K>;
  static constexpr bool known = false, is_only_way = false;
  [[gnu::always_inline]] static S in_a_rotation() {
    S left_out(0.0);
    left_out.g_mask = of_rotation;
    return left_out;
  }
};

// rhs − M a and its derivatives at fixed a.
template <int n, class E>
[[gnu::flatten]] inline LagrangeResidual<n, PairedDual<n>> residual_of(const E& e, const double* q, const double* qdot, const double* a, double t) {
  using N = PairedDual<n>;
  using S = LagrangeResidual<n, N>;
  Vector<S, n> x;
  Vector<S, n> v;
  S* const positions = x.data();
  S* const velocities = v.data();
  unroll<n>([&](auto i) __attribute__((always_inline)) {
    const N velocity = N::template variable<i>(qdot[i], 0.0, 1.0);
    positions[i] = S::template coordinate<i>(N::template variable<i>(q[i], 1.0, 0.0), velocity);
    velocities[i] = S::template velocity<i>(velocity);
    velocities[i].rate = N(a[i]);
    velocities[i].has_rate = 1;
  });
  return lagrangian_of<n>(e, x, v, S::time(N(t)));
}

// The residual and its derivatives; false where they are left to records.
template <int n, class E>
[[gnu::always_inline]] inline bool residual_written(const E& e, const AtState& at, const double* a, PairedDual<n>* rows) {
  const LagrangeResidual<n, PairedDual<n>> residual = residual_of<n>(e, at.q, at.qdot, a, at.t);
  if (residual.g_mask & of_rotation) return false;
  unroll<n>([&](auto i) __attribute__((always_inline)) { rows[i] = residual.template x<i>(); });
  return true;
}

// A use of M and r: q̈, ∂q̈/∂q and ∂q̈/∂q̇ by columns.
template <int n, class E>
struct JacobianTo {
  const E& e;
  double *qddot, *d_q, *d_qdot;

  [[gnu::always_inline]] bool packed(const AtState& at, double* M, double* r, ComponentMask present) const {
    double factor[n * (n + 1) / 2];
    unroll<n*(n + 1) / 2>([&](auto k) __attribute__((always_inline)) { factor[k] = M[k]; });
    if (!solved_in_place<n>(factor, r, singular_pivot<double>(n), present)) return false;
    PairedDual<n> columns[n];
    if (!residual_written<n>(e, at, r, columns)) return false;
    unroll<n>([&](auto i) __attribute__((always_inline)) { columns[i].value = 0.0; });
    solved_in_place<n>(M, columns, 0.0, present);
    double sum = -0.0;
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      qddot[i] = r[i];
      unroll<n>([&](auto j) __attribute__((always_inline)) {
        const Pair pair = columns[i].template pair<j>();
        d_q[i + n * j] = pair[0];
        d_qdot[i + n * j] = pair[1];
        sum += pair[0] + pair[1];
      });
      sum += r[i];
    });
    return is_finite(sum);
  }
};

template <int n, class E>
[[gnu::flatten, gnu::noinline]] bool straight_line_jacobian(const E& e, const double* q, const double* qdot, double t, double* qddot,
                                                            double* d_q, double* d_qdot) {
  return straight_line_equations<n>(e, AtState{q, qdot, t}, JacobianTo<n, E>{e, qddot, d_q, d_qdot});
}

// A use of M and r: M, and the derivatives of r − M a.
template <int n, class E, class Row>
struct SlopesTo {
  const E& e;
  const double* a;
  double* M_out;
  Row* rows;

  [[gnu::always_inline]] bool packed(const AtState& at, const double* M, const double*, ComponentMask) const {
    PairedDual<n> residual[n];
    if (!residual_written<n>(e, at, a, residual)) return false;
    unroll<n*(n + 1) / 2>([&](auto k) __attribute__((always_inline)) { M_out[k] = M[k]; });
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      unroll<n>([&](auto j) __attribute__((always_inline)) {
        const Pair pair = residual[i].template pair<j>();
        rows[i][j] = pair[0];
        rows[i][n + j] = pair[1];
      });
    });
    return true;
  }
};

template <int n, class E, class Row>
[[gnu::flatten, gnu::noinline]] bool straight_line_slopes(const E& e, const double* q, const double* qdot, const double* a, double t, double* M,
                                                          Row* rows) {
  return straight_line_equations<n>(e, AtState{q, qdot, t}, SlopesTo<n, E, Row>{e, a, M, rows});
}

}  // namespace qdot::detail
