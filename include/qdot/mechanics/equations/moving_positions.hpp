#pragma once
// SPDX-License-Identifier: MIT
//
// Velocities inside T at the cost of first derivatives.
//
// Where T calls velocity_of(r, q, q̇) or an angular velocity, r is evaluated on scalars of Lagrange's equations. With dual numbers around
// them that takes all second derivatives of r. They are not needed: of ṙ = J q̇ + ∂r/∂t Lagrange's equations ask for
//
//     ∂ṙ/∂q̇ = J ,     D ṙ = s = J̇ q̇ + … ,     X ṙ = ∂ṙ/∂q − D ∂ṙ/∂q̇ = ∂ṙ/∂q − J̇ = 0 ,
//
// the last because d/dt and ∂/∂q change places (the lemma by which Lagrange's equations are derived). J and s are what a position
// knows of itself (ad/places/position_jet.hpp). So r is evaluated on positions, and value and velocity are made from these.
//
// This holds where what r is given are positions, and the velocities beside them their rates. Coordinates and velocities are, and
// parts and functions of them. Anything else, such as quasi-velocities, or a coordinate that r has captured, is noticed: a bit of the masks is set that the
// compiler does not know, the pass is dropped, and the next step of the ladder has duals around its numbers.

#include <utility>

#include "qdot/ad/places/position_jet.hpp"
#include "qdot/mechanics/velocity.hpp"

namespace qdot::detail {

template <int n, int... Is, class K>
struct MovingPositions<EulerLagrange<n, std::integer_sequence<int, Is...>, K>> {
  static constexpr bool known = true;
  using S = EulerLagrange<n, std::integer_sequence<int, Is...>, K>;
  using Position = PositionJet<n>;

  Present wrong = 0;

  [[gnu::always_inline]] void read(const S& x, const S& v, Position& to) {
    to = Position(x.value);
    to.rate = v.value;
    to.bend = v.rate;
    to.has_rate = x.has_rate;
    to.has_bend = v.has_rate;
    to.mask = x.x_mask;
    wrong |= static_cast<Present>((x.g_mask | x.h_mask | v.x_mask | v.h_mask | (x.x_mask ^ v.g_mask)) != 0) | x.half | v.half;
    wrong |= differ(x.has_rate ? x.rate : 0.0, v.value);
    ((to.template J<Is>() = x.template x<Is>(), wrong |= differ(x.template x<Is>(), v.template g<Is>())), ...);
  }
  [[gnu::always_inline]] void read_time(const S& t, Position& to) {
    to = Position(t.value);
    to.rate = t.rate;
    to.has_rate = t.has_rate;
    wrong |= static_cast<Present>((t.g_mask | t.x_mask | t.h_mask) != 0) | (1U ^ t.has_rate) | differ(t.rate, 1.0);
  }
  template <bool remembers>
  [[gnu::always_inline]] ValueAndRate<S> both(const PositionJet<n, std::integer_sequence<int, Is...>, remembers>& position) const {
    const auto p = position.whole();
    ValueAndRate<S> r{S(p.value), S(p.rate)};
    r.value.rate = p.rate;
    r.value.has_rate = p.has_rate;
    r.value.x_mask = p.mask;
    r.rate.rate = p.bend;
    r.rate.has_rate = p.has_bend;
    // All that follows from a number has the bits of its g_mask; what follows from components may be there for other reasons.
    static_assert(n * (n + 1) / 2 < 64);
    const ComponentMask mark = unknown_if(wrong);
    r.value.g_mask = mark | (p.mask & bit(1, 63));
    r.rate.g_mask = p.mask | mark;
    ((r.value.template x<Is>() = p.template J<Is>(), r.rate.template g<Is>() = p.template J<Is>()), ...);
    return r;
  }

 private:
  // Of bits: the compiler must be sure that a number equals itself.
  [[gnu::always_inline]] static Present differ(double a, double b) {
    return static_cast<Present>(__builtin_bit_cast(long long, a) != __builtin_bit_cast(long long, b));
  }
};

}  // namespace qdot::detail
