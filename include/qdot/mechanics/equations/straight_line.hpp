#pragma once
// SPDX-License-Identifier: MIT
//
// M and r of small systems at the speed of equations derived by hand.
//
// One pass of T and V on the scalar of ad/lagrange/euler_lagrange.hpp gives M and r = X L = ∂L/∂q − D ∂L/∂q̇, and M q̈ = r. When the
// functors are straight-line code for the compiler (entries q[0], q[1], … or qdot::unroll), all zero components and all
// repeated subexpressions vanish while it compiles, and what is left is the code that one would derive by hand.
// A functor with a loop that stays a loop leaves the masks of L unknown to the compiler. With two coordinates or more the pass is then dropped as a whole,
// and lines take its place (mechanics/derive/kept_lines.hpp).
//
// The solution is written out for each n (small_solve.hpp). Everything that could go wrong, a pivot that is not
// positive, a number that is not finite, is left to the general way to look at again and to name.

#include <atomic>

#include "qdot/ad/lagrange/euler_lagrange_math.hpp"
#include "qdot/ad/unroll.hpp"
#include "qdot/mechanics/equations/energy_functors.hpp"
#include "qdot/mechanics/equations/moving_positions.hpp"
#include "qdot/mechanics/equations/small_solve.hpp"
#include "qdot/mechanics/equations/solve.hpp"

namespace qdot {

namespace detail {

// Largest n for this way: compile time grows with n⁴ or so (a chain of 8 takes about 10 s).
inline constexpr int straight_line_limit = 8;

// Unoptimized and sanitized code keeps every component; lines are faster there.
#if !defined(__OPTIMIZE__) || defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool straight_line_pays = false;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
inline constexpr bool straight_line_pays = false;
#else
inline constexpr bool straight_line_pays = true;
#endif
#else
inline constexpr bool straight_line_pays = true;
#endif

// V of positions that move with q̇: it has no derivatives by velocities, and is made of less than half of the numbers that T is made of.
template <int n, class E>
[[gnu::flatten]] inline EulerLagrange<n> potential_of(const E& e, const double* q, const double* qdot, double t) {
  using Position = PositionJet<n, std::make_integer_sequence<int, n>, false>;
  Vector<Position, n> x;
  Position* const positions = x.data();
  unroll<n>([&](auto i) __attribute__((always_inline)) { positions[i] = Position::template coordinate<i>(q[i], qdot[i]); });
  const MovingPositions<EulerLagrange<n>> along_motion;
  if constexpr (potential_signature<E, n>() == PotentialSignature::position) return along_motion.both(Position(e.V(x))).value;
  else return along_motion.both(Position(e.V(x, Position::time(t)))).value;
}

// T of a state that consists of scalars of Lagrange's equations.
template <int n, class E, class S>
[[gnu::flatten]] inline S kinetic_energy_of(const E& e, const Vector<S, n>& x, const Vector<S, n>& v, const S& time) {
  if constexpr (kinetic_signature<E, n>() == KineticSignature::velocity) {
    return e.T(v);
  } else if constexpr (kinetic_signature<E, n>() == KineticSignature::state) {
    return e.T(x, v);
  } else {
    return e.T(x, v, time);
  }
}

// L with its components at a state.
//
// Not always_inline: GCC prepares the functions that others call before those others, but does not count calls from
// always_inline functions, and then finds T and V not ready to be inlined.
template <int n, class E>
[[gnu::flatten]] inline auto euler_lagrange_of(const E& e, const double* q, const double* qdot, double t) {
  using S = EulerLagrange<n>;
  Vector<S, n> x;
  Vector<S, n> v;
  S* const positions = x.data();
  S* const velocities = v.data();
  unroll<n>([&](auto i) __attribute__((always_inline)) {
    positions[i] = S::template coordinate<i>(q[i], qdot[i]);
    velocities[i] = S::template velocity<i>(qdot[i]);
  });
  return (kinetic_energy_of<n>(e, x, v, S::time(t)) - potential_of<n>(e, q, qdot, t)).whole();
}

// Clang decides late whether masks are constants, and keeps much of the pass that it then does not need. Whether it found a loop is
// therefore remembered: a property of the code of E, written once. GCC drops the pass.
#ifdef __clang__
inline constexpr bool remembers_loops = true;
#else
inline constexpr bool remembers_loops = false;
#endif
template <int n, class E>
inline std::atomic<bool> keeps_a_loop{false};

// Where M and r are asked for. Handed on to the use, so that the compiler sees that sin q is there already.
struct AtState {
  const double *q, *qdot;
  double t;
  int size = 0;  // number of coordinates, where it is known at run time only
};

// M and r at a state, handed to use.packed(at, M, r, present): the packed lower triangle, the right-hand side, and which entries of M may be other
// than zero. False when this is not the way, a loop in T or V, and where `use` says so.
template <int n, class E, class Use>
[[gnu::flatten]] inline bool straight_line_equations(const E& e, const AtState& at, const Use& use) {
  if (remembers_loops && keeps_a_loop<n, E>.load(std::memory_order_relaxed)) return false;
  const EulerLagrange<n> L = euler_lagrange_of<n>(e, at.q, at.qdot, at.t);
  if (n == 1 && has(L.g_mask | L.h_mask, 63)) return false;  // velocities that are no rates (mechanics/equations/moving_positions.hpp)
  // Of one coordinate nothing is gained by knowing them.
  if (n > 1 && !__builtin_constant_p(L.g_mask | L.h_mask)) {
    if (remembers_loops) keeps_a_loop<n, E>.store(true, std::memory_order_relaxed);
    return false;
  }
  double M[n * (n + 1) / 2];
  double r[n];
  unroll<n>([&](auto i) __attribute__((always_inline)) { r[i] = L.template x<i>(); });
  unroll<n*(n + 1) / 2>([&](auto k) __attribute__((always_inline)) { M[k] = L.template h<k>(); });
  return use.packed(at, M, r, L.h_mask);
}

}  // namespace detail
}  // namespace qdot
