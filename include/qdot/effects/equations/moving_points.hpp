#pragma once
// SPDX-License-Identifier: MIT
//
// Points, lengths and rotation matrices of small systems, with how they move and with their derivatives, from one evaluation.
//
// What an applied force asks of a quantity x(q, t) is its value, its rate, and Jᵀ F with J = ∂x/∂q. Numbers that know how they move
// (ad/places/position_jet.hpp) carry all of it, and in straight-line code none of it that is zero: a damper between two of eight links costs two
// columns, and its sines are those of the system's own equations when both are compiled together (effects/equations/forced_equations.hpp).
//
// Of plain numbers, up to eight coordinates, and where the optimizer is on. For all others, and as what this is tested against, there are
// derivatives.hpp and velocity.hpp.

#include <type_traits>

#include "qdot/ad/places/position_jet.hpp"
#include "qdot/ad/unroll.hpp"
#include "qdot/ad/vector.hpp"
#include "qdot/mechanics/equations/straight_line.hpp"

namespace qdot::detail {

struct SlopeOfEffect {};  // the tag of the perturbations by which generalized forces are found

// Which scalars and numbers of coordinates go this way.
template <class S, int n>
inline constexpr bool moves_by_jets = std::is_same_v<S, double> && straight_line_pays && n >= 1 && n <= straight_line_limit;

// q and t on their way.
template <int n>
struct MovingCoordinates {
  Vector<PositionJet<n>, n> q;
  PositionJet<n> t;

  [[gnu::always_inline]] MovingCoordinates(const Vector<double, n>& at, const Vector<double, n>& qdot, double time) : t(PositionJet<n>::time(time)) {
    unroll<n>([&](auto i) __attribute__((always_inline)) { q[i] = PositionJet<n>::template coordinate<i>(at[i], qdot[i]); });
  }
};

// A constant has no rate.
template <int n>
[[gnu::always_inline]] inline double rate_of(const PositionJet<n>& x) { return x.has_rate ? x.whole().rate : 0.0; }

// Q += F ∂x/∂q. `present` says which entries of Q are more than a zero. What is not finite does not vanish because x does not move.
template <class S, int n, class Number>
[[gnu::always_inline]] inline void add_gradient(Vector<S, n>& Q, ComponentMask& present, const std::type_identity_t<S>& F, const Number& moving) {
  const Number& x = moving.whole();
  unroll<n>([&](auto i) __attribute__((always_inline)) {
    Q[i] = sum_of(has(present, i), Q[i], has(x.mask, i), product_if(has(x.mask, i), x.template J<i>(), F));
  });
  present |= x.mask;
  const S zero = x.mask ? S(0.0) : S(F * (x.value - x.value));
  Q[0] = sum_of(has(present, 0), Q[0], may_differ_from_zero(zero), zero);
  present |= may_differ_from_zero(zero);
}

}  // namespace qdot::detail
