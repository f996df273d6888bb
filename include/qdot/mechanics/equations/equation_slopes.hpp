#pragma once
// SPDX-License-Identifier: MIT
//
// M, and how the equations of motion change from state to state at accelerations that are known:
//
//     ∂(r − M a)/∂(q, q̇)      at fixed a .
//
// That is what Jacobians are made of, those of systems (acceleration_jacobian.hpp) and those of scenes, whose effects and constraints add
// rows and columns of their own before anything is solved (effects/equations/scene_jacobian.hpp). As for M and r there is one ladder:
//
//     e.slopes(q, qdot, a, t, M, rows)     what a system knows of itself: positions and masses (mechanics/places/slopes.hpp)
//     straight-line duals                  T and V of up to four coordinates, without loops and rotations (mechanics/equations/straight_line_jacobian.hpp)
//     lines that a run keeps               T and V that are formulas, of up to eight coordinates (mechanics/derive/kept_lines.hpp)
//
// False is returned where none of these is the way, or a number is not finite: then there are nested duals.

#include "qdot/mechanics/equations/straight_line_jacobian.hpp"
#include "qdot/mechanics/mass_and_rhs.hpp"

namespace qdot::detail {

// Energies that know of their slopes.
template <class E, class Row>
concept HasSlopes = requires(const E& e, const double* q, double* M, Row* rows) { e.slopes(q, q, q, 0.0, M, rows); };

// Which systems have such a ladder.
template <int n>
inline constexpr bool has_slopes = straight_line_pays && n >= 1 && n <= straight_line_limit;

// M, the packed lower triangle, and the derivatives of r − M a, of which row i has its first 2n entries written. Straight-line code is
// left out where it has been tried.
template <int n, bool try_straight = true, class E, class Row>
bool slopes_written(const E& e, const Vector<double, n>& q, const Vector<double, n>& qdot, const Vector<double, n>& a, double t, double* M,
                    Row* rows, KeptLines* kept = nullptr) {
  if constexpr (HasSlopes<E, Row>) {
    if (may_be_straight(kept) && e.slopes(q.data(), qdot.data(), a.data(), t, M, rows)) return true;
  }
  if constexpr (try_straight && !HasOwnEquations<E> && n <= straight_line_jacobian_limit) {
    if (may_be_straight(kept) && straight_line_slopes<n>(e, q.data(), qdot.data(), a.data(), t, M, rows)) return true;
  }
  return with_lines_and_slopes<n>(kept, e, AtState{q.data(), qdot.data(), t}, [&](const DerivedLines& lines) {
    return lines.template write_slopes<n>(q.data(), qdot.data(), t, M, rows, AccelerationsAre{a.data(), n});
  });
}

}  // namespace qdot::detail
