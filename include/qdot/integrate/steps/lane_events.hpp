#pragma once
// SPDX-License-Identifier: MIT
//
// In which lanes a step passes an event.
//
// The lanes of a pack have made a step (integrate/steps/lane_steps.hpp), and each knows q, q̇ and q̈ at both ends of its own. Through these there is one
// polynomial of order 5, within h⁶ of the motion. An event's function is looked at on it in quarters of the step; a lane in which it changes its sign the
// way that the event asks for is told, and who goes on with it finds the time.

#include <Eigen/Core>
#include <tuple>
#include <type_traits>

#include "qdot/ad/pack.hpp"
#include "qdot/integrate/event.hpp"

namespace qdot::detail {

// g at a place of the step, in whichever form the user wrote it.
template <int n, class P, class G>
P event_in_lanes(const G& g, const Vector<P, n>& q, const Vector<P, n>& qdot, const P& t) {
  if constexpr (std::is_invocable_v<const G&, const Vector<P, n>&, const Vector<P, n>&, const P&>) {
    return result_of(g, q, qdot, t);
  } else if constexpr (std::is_invocable_v<const G&, const Vector<P, n>&, const Vector<P, n>&>) {
    return result_of(g, q, qdot);
  } else {
    static_assert(std::is_invocable_v<const G&, const Vector<P, n>&>,
                  "qdot: the function of an event of motions in lanes must be callable as g(q), g(q, qdot) or g(q, qdot, t) with packs of doubles: take const auto&");
    return result_of(g, q);
  }
}

// Lanes whose last step passes one of the events, or cannot say.
template <int n, class Steps, class... Events>
auto lanes_that_pass(const Steps& steps, const EventList<Events...>& events) {
  using P = std::remove_cvref_t<decltype(steps.h())>;
  using Mask = typename P::Mask;
  Mask passed = false;
  if constexpr (sizeof...(Events) > 0) {
    constexpr int parts = 4;
    const P h = steps.h();
    Vector<P, n> q[parts + 1], qdot[parts + 1];
    for (int i = 0; i < n; ++i) {  // q₀ + v₀ s + a₀ s² + c₃ s³ + c₄ s⁴ + c₅ s⁵
      const P q0 = steps.before()[i], q1 = steps.after()[i], v0 = h * steps.before()[n + i], v1 = h * steps.after()[n + i];
      const P a0 = 0.5 * h * h * steps.rate_before()[n + i], a1 = 0.5 * h * h * steps.rate_after()[n + i];
      const P d = q1 - q0 - v0 - a0, e = v1 - v0 - 2.0 * a0, f = a1 - a0;
      const P c3 = 10.0 * d - 4.0 * e + f, c4 = -15.0 * d + 7.0 * e - 2.0 * f, c5 = 6.0 * d - 3.0 * e + f;
      q[0][i] = q0;
      qdot[0][i] = steps.before()[n + i];
      for (int k = 1; k < parts; ++k) {
        const double s = static_cast<double>(k) / parts;
        q[k][i] = q0 + s * (v0 + s * (a0 + s * (c3 + s * (c4 + s * c5))));
        qdot[k][i] = (v0 + s * (2.0 * a0 + s * (3.0 * c3 + s * (4.0 * c4 + s * (5.0 * c5))))) / h;
      }
      q[parts][i] = q1;
      qdot[parts][i] = steps.after()[n + i];
    }
    const auto look = [&](const auto& event) {
      const P t = steps.t_before();
      P before = event_in_lanes<n, P>(event.g, q[0], qdot[0], t);
      for (int k = 1; k <= parts; ++k) {
        const P now = event_in_lanes<n, P>(event.g, q[k], qdot[k], t + (static_cast<double>(k) / parts) * h);
        if (event.direction != Direction::rising) passed |= (before >= P(0.0)) & (now <= P(0.0));
        if (event.direction != Direction::falling) passed |= (before <= P(0.0)) & (now >= P(0.0));
        passed |= now != now;
        before = now;
      }
    };
    std::apply([&](const auto&... event) { (look(event), ...); }, events.list);
  }
  return passed;
}

}  // namespace qdot::detail
