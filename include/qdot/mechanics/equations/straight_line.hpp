#pragma once
// SPDX-License-Identifier: MIT
//
// M and r of small systems at the speed of equations derived by hand.
//
// One pass of T and V on the scalar of ad/lagrange/euler_lagrange.hpp gives M and r = X L = ∂L/∂q − D ∂L/∂q̇, and M q̈ = r. When the
// functors are straight-line code for the compiler (entries q[0], q[1], … or qdot::unroll), all zero components and all
// repeated subexpressions vanish while it compiles, and what is left is the code that one would derive by hand.
// A functor with a loop that stays a loop leaves the masks of L unknown to the compiler; the pass is then
// dropped, as a whole, in favour of the general one.
//
// The solution is L D Lᵀ, written out for each n. Everything that could go wrong, a pivot that is not
// positive, a number that is not finite, is left to the general way to look at again and to name.

#include <atomic>
#include <type_traits>
#include <utility>

#include "qdot/ad/lagrange/euler_lagrange_math.hpp"
#include "qdot/ad/unroll.hpp"
#include "qdot/mechanics/equations/energy_functors.hpp"
#include "qdot/mechanics/equations/free_turn.hpp"
#include "qdot/mechanics/equations/moving_positions.hpp"
#include "qdot/mechanics/equations/solve.hpp"

namespace qdot {

namespace detail {

// Largest n for this way: compile time grows with n⁴ or so (a chain of 8 takes about 10 s).
inline constexpr int straight_line_limit = 8;

// Unoptimized and sanitized code keeps every component; the general way is the faster one there.
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

// Stands for applied forces where there are none.
struct NoForces {};

// Index of M(i, j), i ≥ j, in the packed lower triangle.
constexpr int triangle_index(int i, int j) { return i * (i + 1) / 2 + j; }

// Whether entry k of a triangle may be other than zero; large triangles are full.
template <int k>
[[gnu::always_inline]] inline Present has_entry(ComponentMask present) {
  if constexpr (k < 64) {
    return has(present, k);
  } else {
    return 1;
  }
}

// b ← M⁻¹ b by L D Lᵀ; false when a pivot is below `threshold` of its diagonal entry or NaN. M is overwritten. Of packs a mask.
// Entries of M that are not `present` are zero, and what follows from them is left out when the compiler knows the mask.
// The entries of b are numbers or what can be multiplied by numbers.
template <int n, class Number, class Right>
[[gnu::always_inline]] inline auto solved_in_place(Number* M, Right* b, double threshold, ComponentMask present = ~ComponentMask(0)) {
  using Truth = decltype(M[0] > M[0]);
  Number inverse[n];
  Truth good = true;
  Number diagonal[n];
  unroll<n>([&](auto k) __attribute__((always_inline)) { diagonal[k] = M[triangle_index(k, k)]; });
  unroll<n>([&](auto k) __attribute__((always_inline)) {
    const Number pivot = M[triangle_index(k, k)];
    good &= pivot > threshold * diagonal[k];
    inverse[k] = 1.0 / pivot;
    unroll<n - 1 - k>([&](auto below) __attribute__((always_inline)) {
      constexpr int i = k + 1 + below;
      if (has_entry<triangle_index(i, k)>(present) == 0) return;
      const Number l = M[triangle_index(i, k)] * inverse[k];
      unroll<below + 1>([&](auto column) __attribute__((always_inline)) {
        constexpr int j = k + 1 + column;
        if (has_entry<triangle_index(j, k)>(present) == 0) return;
        M[triangle_index(i, j)] -= l * M[triangle_index(j, k)];
        if constexpr (triangle_index(i, j) < 64) present |= bit(1, triangle_index(i, j));
      });
      b[i] -= l * b[k];
    });
  });
  unroll<n>([&](auto done) __attribute__((always_inline)) {
    constexpr int k = n - 1 - done;
    Right s = b[k];
    unroll<n - 1 - k>([&](auto below) __attribute__((always_inline)) {
      constexpr int i = k + 1 + below;
      if (has_entry<triangle_index(i, k)>(present) != 0) s -= M[triangle_index(i, k)] * b[i];
    });
    b[k] = s * inverse[k];
  });
  return good;
}

// M = L D Lᵀ in place: L below the diagonal, where `present` says what may be other than zero, and 1/D in `inverse`. False as above.
// Where masks are not known beforehand but known to the compiler in the end, nothing branches on them that has to be thrown away later.
template <int n, class Number>
[[gnu::always_inline]] inline bool factored_in_place(Number* M, Number* inverse, double threshold, ComponentMask& present) {
  bool good = true;
  Number diagonal[n];
  unroll<n>([&](auto k) __attribute__((always_inline)) { diagonal[k] = M[triangle_index(k, k)]; });
  unroll<n>([&](auto k) __attribute__((always_inline)) {
    const Number pivot = M[triangle_index(k, k)];
    good &= pivot > threshold * diagonal[k];
    inverse[k] = 1.0 / pivot;
    Number l[n];
    unroll<n - 1 - k>([&](auto below) __attribute__((always_inline)) {
      constexpr int i = k + 1 + below;
      const Present there = has_entry<triangle_index(i, k)>(present);
      l[i] = product_if(there, M[triangle_index(i, k)], inverse[k]);
      unroll<below + 1>([&](auto column) __attribute__((always_inline)) {
        constexpr int j = k + 1 + column, ij = triangle_index(i, j);
        const Present both = there & has_entry<triangle_index(j, k)>(present);
        M[ij] = sum_of(has_entry<ij>(present), M[ij], both, product_if(both, -l[i], M[triangle_index(j, k)]));
        if constexpr (ij < 64) present |= bit(both, ij);
      });
    });
    unroll<n - 1 - k>([&](auto below) __attribute__((always_inline)) { M[triangle_index(k + 1 + below, k)] = l[k + 1 + below]; });
  });
  return good;
}

// b ← L⁻¹ b, where `mask` says which entries of b may be other than zero.
template <int n, class Number, class Right>
[[gnu::always_inline]] inline void forward_in_place(const Number* L, Right* b, ComponentMask present, ComponentMask& mask) {
  unroll<n>([&](auto k) __attribute__((always_inline)) {
    unroll<n - 1 - k>([&](auto below) __attribute__((always_inline)) {
      constexpr int i = k + 1 + below;
      const Present both = has_entry<triangle_index(i, k)>(present) & has(mask, k);
      b[i] = sum_of(has(mask, i), b[i], both, product_if(both, b[k], -L[triangle_index(i, k)]));
      mask |= bit(both, i);
    });
  });
}

// b ← L⁻ᵀ b.
template <int n, class Number, class Right>
[[gnu::always_inline]] inline void backward_in_place(const Number* L, Right* b, ComponentMask present) {
  unroll<n>([&](auto done) __attribute__((always_inline)) {
    constexpr int k = n - 1 - done;
    unroll<n - 1 - k>([&](auto below) __attribute__((always_inline)) {
      constexpr int i = k + 1 + below;
      const Present there = has_entry<triangle_index(i, k)>(present);
      b[k] = sum_of(1U, b[k], there, product_if(there, b[i], -L[triangle_index(i, k)]));
    });
  });
}

// False where a list of operations is not that of this object.
template <class E>
[[gnu::always_inline]] inline bool may_go_straight(const E& e) {
  if constexpr (GoesByList<E>) {
    return e.replays();
  } else {
    return true;
  }
}

// What T returns: the scalar that it is given, or one that knows of an angular velocity as well.
template <int n, class E, class S>
using ReturnedByT = decltype(returned_by_T<n>(std::declval<const E&>(), std::declval<const Vector<S, n>&>(), std::declval<const Vector<S, n>&>(), std::declval<const S&>()));
template <int n, class E, class S>
using ScalarOfT = std::conditional_t<is_turning_energy<ReturnedByT<n, E, S>>, ReturnedByT<n, E, S>, S>;

// L = T − V of a state that consists of scalars of Lagrange's equations.
template <int n, class E, class S>
[[gnu::flatten]] inline auto lagrangian_of(const E& e, const Vector<S, n>& x, const Vector<S, n>& v, const S& time) {
  ScalarOfT<n, E, S> T;
  S V;
  if constexpr (kinetic_signature<E, n>() == KineticSignature::velocity) {
    T = e.T(v);
  } else if constexpr (kinetic_signature<E, n>() == KineticSignature::state) {
    T = e.T(x, v);
  } else {
    T = e.T(x, v, time);
  }
  if constexpr (potential_signature<E, n>() == PotentialSignature::position) {
    V = e.V(x);
  } else {
    V = e.V(x, time);
  }
  return (T - V).whole();
}

// L with its components at a state.
//
// Not always_inline: GCC prepares the functions that others call before those others, but does not count calls from
// always_inline functions, and then finds T and V not ready to be inlined.
template <int n, class E, class Number>
[[gnu::flatten]] inline auto euler_lagrange_of(const E& e, const Number* q, const Number* qdot, const Number& t) {
  using S = EulerLagrange<n, Number>;
  Vector<S, n> x;
  Vector<S, n> v;
  S* const positions = x.data();
  S* const velocities = v.data();
  unroll<n>([&](auto i) __attribute__((always_inline)) {
    positions[i] = S::template coordinate<i>(q[i], qdot[i]);
    velocities[i] = S::template velocity<i>(qdot[i]);
  });
  return lagrangian_of<n>(e, x, v, S::time(t));
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

// Where M and r are asked for. Handed on to who uses them, so that the compiler sees that sin q is there already.
struct AtState {
  const double *q, *qdot;
  double t;
};

// Those of a free body (free_turn.hpp), handed to use.turned(at, turn).
template <int n, class Rotation, class Use>
[[gnu::always_inline]] inline bool turned_equations(const TurningEnergy<n, Rotation>& L, const AtState& at, const Use& use) {
  using Free = FreeTurn<n>;
  double M[Free::pairs], I[6], X[3], r[n];
  ComponentMask coupled = 0, inertia = 0, forces = 0;
  unroll<Free::pairs>([&](auto k) __attribute__((always_inline)) { M[k] = L.template h<k>(); });
  unroll<n>([&](auto i) __attribute__((always_inline)) {
    r[i] = L.template x<i>();
    forces |= bit(has(L.x_mask, i) & may_differ_from_zero(r[i]), i);
  });
  unroll<3>([&](auto a) __attribute__((always_inline)) {
    X[a] = L.template x<n + a>();
    unroll<n>([&](auto i) __attribute__((always_inline)) { coupled |= bit(has(L.h_mask, Free::index(n + a, i)), i); });
    unroll<a + 1>([&](auto b) __attribute__((always_inline)) {
      I[Free::index(a, b)] = L.template h<Free::index(n + a, n + b)>();
      inertia |= bit(has(L.h_mask, Free::index(n + a, n + b)), Free::index(a, b));
    });
  });
  if (coupled) return false;
  Free turn;
  turn.set(L.body, M, L.h_mask, r, forces, I, inertia, X);
  return turn.is_free && use.turned(at, turn);
}

// M and r at a state, handed to use.packed(at, M, r, present): the packed lower triangle, the right-hand side, and which entries of M may be other
// than zero. False when this is not the way, a loop in T or V, and where `use` says so.
template <int n, class E, class Use>
[[gnu::flatten]] inline bool straight_line_equations(const E& e, const AtState& at, const Use& use) {
  if (!may_go_straight(e)) return false;
  if (remembers_loops && keeps_a_loop<n, E>.load(std::memory_order_relaxed)) return false;
  const auto found = euler_lagrange_of<n>(e, at.q, at.qdot, at.t);
  if (!__builtin_constant_p(found.g_mask | found.h_mask)) {
    if (remembers_loops) keeps_a_loop<n, E>.store(true, std::memory_order_relaxed);
    return false;
  }
  if constexpr (is_turning_energy<std::remove_cv_t<decltype(found)>> && requires { &Use::turned; }) {
    if (turned_equations(found, at, use)) return true;
  }
  const EulerLagrange<n> L(found);
  double M[n * (n + 1) / 2];
  double r[n];
  unroll<n>([&](auto i) __attribute__((always_inline)) { r[i] = L.template x<i>(); });
  unroll<n*(n + 1) / 2>([&](auto k) __attribute__((always_inline)) { M[k] = L.template h<k>(); });
  return use.packed(at, M, r, L.h_mask);
}

}  // namespace detail
}  // namespace qdot
