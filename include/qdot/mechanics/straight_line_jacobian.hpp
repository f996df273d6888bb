#pragma once
// SPDX-License-Identifier: MIT
//
// q̈ of small systems with its derivatives, as straight-line code.
//
// A motion with accelerations a satisfies X L = 0 when D, the derivative along the motion in the scalar of
// ad/euler_lagrange.hpp, includes them:
//
//     D = q̇·∂/∂q + a·∂/∂q̇ + ∂/∂t ,      X L = ∂L/∂q − D ∂L/∂q̇ = rhs − M a .
//
// That scalar needs nothing but a velocity's rate, a_i instead of zero. It then finds X L without second derivatives in q̇, and by the
// implicit function theorem
//
//     ∂q̈/∂(q, q̇) = M⁻¹ ∂(X L)/∂(q, q̇)      at fixed a = q̈ .
//
// So the scalar is evaluated a second time with dual numbers inside (ad/paired_dual.hpp) and without its Hessian; the compiler merges what both
// passes have in common.

#include <type_traits>
#include <utility>

#include <Eigen/Core>

#include "qdot/ad/paired_dual.hpp"
#include "qdot/mechanics/straight_line.hpp"

namespace qdot::detail {

// A row of derivatives along q and q̇, and what else there is.
template <int columns>
using SlopeRow = Eigen::Array<double, columns, 1>;

// The columns of n such rows; false where a number is not finite.
template <int n, class Row>
bool columns_written(const Row* rows, double* d_q, double* d_qdot) {
  double zero = 0.0;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      d_q[i + n * j] = rows[i][j];
      d_qdot[i + n * j] = rows[i][n + j];
    }
    const double sum = rows[i].sum();
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
template <int n, class I, class K>
struct MovingPositions<EulerLagrange<n, PairedDual<n>, I, K>> {
  using S = EulerLagrange<n, PairedDual<n>, I, K>;
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

// q̈, ∂q̈/∂q and ∂q̈/∂q̇ by columns; false when this is not the way, as in straight_line_acceleration().
template <int n, class E>
[[gnu::flatten, gnu::noinline]] bool straight_line_jacobian(const E& e, const double* q, const double* qdot, double t, double* qddot,
                                                            double* d_q, double* d_qdot) {
  using N = PairedDual<n>;
  if (!may_go_straight(e)) return false;
  if (remembers_loops && keeps_a_loop<n, E>.load(std::memory_order_relaxed)) return false;
  const EulerLagrange<n> L = euler_lagrange_of<n>(e, q, qdot, t);
  if (!__builtin_constant_p(L.g_mask | L.h_mask)) {
    if (remembers_loops) keeps_a_loop<n, E>.store(true, std::memory_order_relaxed);
    return false;
  }
  double M[n * (n + 1) / 2], factor[n * (n + 1) / 2], r[n];
  unroll<n>([&](auto i) __attribute__((always_inline)) { r[i] = L.template x<i>(); });
  unroll<n*(n + 1) / 2>([&](auto k) __attribute__((always_inline)) { factor[k] = M[k] = L.template h<k>(); });
  if (!solved_in_place<n>(factor, r, singular_pivot<double>(n), L.h_mask)) return false;
  const LagrangeResidual<n, N> residual = residual_of<n>(e, q, qdot, r, t);
  if (residual.g_mask & of_rotation) return false;  // which is left to records
  N columns[n];
  unroll<n>([&](auto i) __attribute__((always_inline)) {
    columns[i] = residual.template x<i>();
    columns[i].value = 0.0;
  });
  solved_in_place<n>(M, columns, 0.0, L.h_mask);
  double sum = 0.0;
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
  return sum - sum == 0.0;
}

}  // namespace qdot::detail
