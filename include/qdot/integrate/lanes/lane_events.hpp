#pragma once
// SPDX-License-Identifier: MIT
//
// In which lanes a step passes an event.
//
// The lanes of a pack have made a step (integrate/lanes/runge_kutta_lanes.hpp), and each knows its motion between both ends of its own. An event's function is
// looked at in equal parts of the step. A lane in which it changes its sign in the event's direction is reported, and the caller finds the time.

#include <Eigen/Core>
#include <tuple>
#include <type_traits>

#include "qdot/ad/forward/functor_result.hpp"
#include "qdot/ad/pack_math.hpp"
#include "qdot/integrate/event.hpp"

namespace qdot::detail {

// What lanes compute with: packs of eight, as lines have it (ad/formula/lane_lines.hpp), whose lanes may take a branch where all of them take the same.
using LanePack = Pack<8, register_lanes + may_branch>;

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

// A step in equal parts.
template <int n, class P, int parts>
struct StepPlaces {
  Vector<P, n> q[parts + 1], qdot[parts + 1];
  P t[parts + 1];

  StepPlaces of_lane(int lane) const {
    StepPlaces r;
    for (int k = 0; k <= parts; ++k) {
      r.q[k] = only(q[k], lane);
      r.qdot[k] = only(qdot[k], lane);
      r.t[k] = only(t[k], lane);
    }
    return r;
  }
};

// g at a place of the step, in whichever form the user wrote it.
template <int n, class P, class G>
P event_in_lanes(const G& g, const Vector<P, n>& q, const Vector<P, n>& qdot, const P& t) {
  if constexpr (detail::is_callable<const G&, const Vector<P, n>&, const Vector<P, n>&, const P&>) {
    return result_of(g, q, qdot, t);
  } else if constexpr (detail::is_callable<const G&, const Vector<P, n>&, const Vector<P, n>&>) {
    return result_of(g, q, qdot);
  } else {
    static_assert(detail::is_callable<const G&, const Vector<P, n>&>,
                  "qdot: the function of an event of motions in lanes must be callable as g(q), g(q, qdot) or g(q, qdot, t) with packs of doubles: take const auto&");
    return result_of(g, q);
  }
}

// Lanes whose step passes one of the events, or cannot say.
//
// @throws LanesPart  the function of an event takes a branch in some lanes and not in others
template <int n, class P, int parts, class... Events>
typename P::Mask lanes_that_pass(const StepPlaces<n, P, parts>& step, const EventList<Events...>& events) {
  typename P::Mask passed = false;
  const auto look = [&](const auto& event) {
    P before = event_in_lanes<n, P>(event.g, step.q[0], step.qdot[0], step.t[0]);
    for (int k = 1; k <= parts; ++k) {
      const P now = event_in_lanes<n, P>(event.g, step.q[k], step.qdot[k], step.t[k]);
      if (event.direction != Direction::rising) passed |= (before >= P(0.0)) & (now <= P(0.0));
      if (event.direction != Direction::falling) passed |= (before <= P(0.0)) & (now >= P(0.0));
      passed |= now != now;
      before = now;
    }
  };
  std::apply([&](const auto&... event) { (look(event), ...); }, events.list);
  return passed;
}

}  // namespace qdot::detail
