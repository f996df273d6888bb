#pragma once
// SPDX-License-Identifier: MIT
//
// q̈ and ∂q̈/∂(q, q̇) of small scenes with forces and without constraints, in one pass of straight-line code:
//
//     M q̈ = r + Q ,      ∂q̈ = M⁻¹ (∂(r − M a) + ∂Q)      at fixed a = q̈ .
//
// By themselves q̈ and the slopes (effects/equations/scene_jacobian.hpp) would each begin with M and r. Here the slopes follow q̈ in the
// same function, as those of a system do (mechanics/equations/straight_line_jacobian.hpp), and the compiler sees that the sines are there
// already.

#include <type_traits>
#include <utility>

#include "qdot/effects/equations/forced_equations.hpp"
#include "qdot/effects/rows/traced_constraints.hpp"
#include "qdot/mechanics/equations/straight_line_jacobian.hpp"

namespace qdot::detail {

// A use of M and r: q̈, and rows of ∂Q made rows of ∂q̈.
template <int n, class E, class Row>
struct ForcedJacobianTo {
  const E& e;
  const double* Q;
  double* qddot;
  Row* rows;

  [[gnu::always_inline]] bool packed(const AtState& at, double* M, double* r, ComponentMask present) const {
    double factor[n * (n + 1) / 2];
    unroll<n*(n + 1) / 2>([&](auto k) __attribute__((always_inline)) { factor[k] = M[k]; });
    unroll<n>([&](auto i) __attribute__((always_inline)) { r[i] += Q[i]; });
    if (!solved_in_place<n>(factor, r, singular_pivot<double>(n), present)) return false;
    PairedDual<n> residual[n];
    if (!residual_written<n>(e, at, r, residual)) return false;
    double zero = 0.0;
    unroll<n>([&](auto i) __attribute__((always_inline)) {
      qddot[i] = r[i];
      zero += r[i] - r[i];
      unroll<n>([&](auto j) __attribute__((always_inline)) {
        const Pair pair = residual[i].template pair<j>();
        rows[i][j] += pair[0];
        rows[i][n + j] += pair[1];
      });
    });
    solved_in_place<n>(M, rows, 0.0, present);
    return zero == 0.0;
  }
};

// Which scenes go this way.
template <class Sc>
inline constexpr bool has_forced_jacobian = [] {
  constexpr int n = Sc::dof_at_compile_time;
  using E = std::remove_cvref_t<decltype(std::declval<const Sc&>().system().energies())>;
  return straight_line_pays && n >= 1 && n <= straight_line_jacobian_limit && Sc::has_forces && !Sc::has_constraints && !Sc::has_states &&
         Sc::SystemType::inertia == Inertia::positive_definite && !HasOwnEquations<E> &&
         std::is_same_v<E, EnergiesWithoutPotentials<Sc>>;
}();

// Scenes whose Jacobian is that of a recording in each of their phases, where functors are formulas: straight-line code has no derivatives of all there is.
template <class Sc>
inline constexpr bool has_traced_jacobian = is_recordable_scene<Sc> && Sc::dof_at_compile_time <= 64 && !has_forced_jacobian<Sc>;

// False where another way must be gone; rows may be anything then.
template <int n, class E, class Row>
[[gnu::flatten, gnu::noinline]] bool straight_line_jacobian_under_force(const E& e, const double* q, const double* qdot, double t, const double* Q,
                                                                        double* qddot, Row* rows) {
  return straight_line_equations<n>(e, AtState{q, qdot, t}, ForcedJacobianTo<n, E, Row>{e, Q, qddot, rows});
}

}  // namespace qdot::detail
