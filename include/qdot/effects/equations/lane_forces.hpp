#pragma once
// SPDX-License-Identifier: MIT
//
// Forces of effects in the lanes of packs (ad/pack.hpp).
//
// M and r of many motions go by lines (mechanics/derive/lane_equations.hpp); forces are asked of the effects' own functors, with packs for numbers. An
// effect whose functor takes plain numbers only says nothing of packs, and its scene has no lanes. A functor may branch: where lanes part,
// it is asked for each lane by itself.

#include <tuple>
#include <type_traits>

#include "qdot/ad/pack_math.hpp"
#include "qdot/ad/unroll.hpp"
#include "qdot/effects/equations/forced_equations.hpp"
#include "qdot/mechanics/derive/lane_equations.hpp"

namespace qdot::detail {

// Whether an effect plays its roles for packs P as for numbers: E, and `InPacks` where its parameters are packs as well.
template <class E, class InPacks, class P, int n>
consteval bool plays_for_packs() {
  using V = Vector<P, n>;
  if constexpr (StateEffect<E> || ConstraintEffect<E, n>) {
    return false;
  } else if constexpr (ForceEffect<E, n>) {
    return requires(const InPacks& e, const V& q, const P& t) { e.force(q, q, t); };
  } else {
    return true;  // T and V are lines
  }
}

// Whether a system or scene may go in the lanes of packs P.
template <class Sys, class P>
inline constexpr bool scene_goes_in_lanes = may_have_lane_lines<Sys>;
template <class Sys, class... Effects, class P>
inline constexpr bool scene_goes_in_lanes<Scene<Sys, Effects...>, P> = [] {
  if constexpr (may_have_lane_lines<typename Scene<Sys, Effects...>::SystemType>) return (plays_for_packs<Effects, Effects, P, Sys::dof_at_compile_time>() && ...);
  else return false;
}();

// Writes to one lane.
template <int lanes, int width>
void set_lane(Pack<lanes, width>& pack, int lane, double x) {
  double all[lanes];
  pack.store(all);
  all[lane] = x;
  pack = Pack<lanes, width>::load(all);
}
template <int lanes, int width>
void set_lane(PackMask<lanes, width>& mask, int lane, bool truth) {
  mask = Pack<lanes, width>::of([&](int l) { return (l == lane ? truth : mask[l]) ? 1.0 : 0.0; }) > 0.5;
}

// The numbers of one lane in all of them.
template <class P>
P only(const P& x, int lane) { return P(x[lane]); }
template <class P, int n>
Vector<P, n> only(const Vector<P, n>& x, int lane) {
  Vector<P, n> r;
  for (int i = 0; i < n; ++i) r[i] = P(x[i][lane]);
  return r;
}

// Sums forces in lanes. The roles of the effects are those of Sc, whose own effects these are, or the same with packs for parameters.
template <class Sc, ForceSum sum>
class LaneForces {};
template <class Sys, class... Effects, ForceSum sum>
class LaneForces<Scene<Sys, Effects...>, sum> {
  static constexpr int n = Sys::dof_at_compile_time;

 public:
  // Q of the lanes in `wanted`; effects_of(lane): the effects with the parameters of a lane in all lanes.
  template <class Tuple, class EffectsOf, class P>
  void write(const Tuple& effects, const EffectsOf& effects_of, const P* q, const P* qdot, const P& t, const typename P::Mask& wanted, P* Q) {
    Vector<P, n> x, v, all;
    for (int i = 0; i < n; ++i) {
      x[i] = q[i];
      v[i] = qdot[i];
    }
    if (!summed(effects, x, v, t, all)) {
      all.setZero();
      for (int lane = 0; lane < P::size; ++lane) {
        if (!wanted[lane]) continue;
        const Vector<P, n> one = sum_of(effects_of(lane), only(x, lane), only(v, lane), only(t, lane));
        for (int i = 0; i < n; ++i) set_lane(all[i], lane, one[i][lane]);
      }
    }
    for (int i = 0; i < n; ++i) Q[i] = all[i];
  }

 private:
  static constexpr int most_partings = 16;  // an exception costs more than what it spares: then lanes are not asked together any more

  template <class Tuple, class P>
  static Vector<P, n> sum_of(const Tuple& effects, const Vector<P, n>& q, const Vector<P, n>& qdot, const P& t) {
    return sum_over<sum, false, Effects...>(effects, q, qdot, Vector<P, 0>(), t);
  }
  // All lanes together; false where they part.
  template <class Tuple, class P>
  bool summed(const Tuple& effects, const Vector<P, n>& q, const Vector<P, n>& qdot, const P& t, Vector<P, n>& Q) {
    if (partings_ >= most_partings) return false;
    try {
      Q = sum_of(effects, q, qdot, t);
      return true;
    } catch (const LanesPart&) {
      ++partings_;
      return false;
    }
  }

  int partings_ = 0;
};

}  // namespace qdot::detail
