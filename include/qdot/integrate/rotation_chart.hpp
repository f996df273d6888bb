#pragma once
// SPDX-License-Identifier: MIT
//
// A body in every attitude, with three coordinates.
//
// No three coordinates describe all rotations: Euler's angles are locked at a pole, the rotation vector v (axis times angle,
// rotation_from_vector) at |v| = 2π. But a second rotation vector describes the same attitude,
//
//     v' = (1 − 2π/|v|) v :       the turn by |v| one way round is the turn by 2π − |v| the other way round.
//
// This event changes to it where |v| grows beyond 3.5, to |v'| = 2π − 3.5 = 2.78; it happens again after |v| has grown by 0.72:
//
//     simulate(body, start, t_end, Dop853{}, {}, events(rotation_chart<0>()))
//
// R, ω and the energy are the same on both sides of a change, and T and V stay as they are; v jumps (Trajectory::before and at).
// Four coordinates do without it: a quaternion whose length has an inertia of its own, or is held by a constraint
// (tests/stress/quaternions.test.cpp).

#include <Eigen/Core>
#include <numbers>
#include <string>
#include <utility>

#include "qdot/integrate/event.hpp"

namespace qdot {

namespace detail {

inline constexpr double rotation_chart_edge = 3.5;  // rad; anything between π and 2π, with room on both sides

// v ← (1 − 2π/|v|) v, and its velocity with it.
template <Eigen::Index first>
struct OtherRotationVector {
  template <class S>
    requires requires(S& state) { state.qdot; }
  void operator()(S& state) const {
    const Eigen::Vector3d v = state.q.template segment<3>(first), vdot = state.qdot.template segment<3>(first);
    const double angle = v.norm(), share = 2.0 * std::numbers::pi / angle;
    state.q.template segment<3>(first) -= share * v;
    state.qdot.template segment<3>(first) -= share * (vdot - v * (v.dot(vdot) / (angle * angle)));
  }
};

}  // namespace detail

/// The event that keeps a rotation vector within |v| ≤ 3.5 by changing to the other vector of the same attitude.
///
/// One restart of the method for each change, about once in 0.9 turns.
///
/// @tparam first  index of the vector's first coordinate; the next two are its others
/// @param  name   as it appears in Run::events
template <Eigen::Index first>
auto rotation_chart(std::string name = "chart") {
  static_assert(first >= 0, "qdot::rotation_chart: the first coordinate of the rotation vector has an index from 0 on");
  return event(std::move(name),
               [](const auto& q) {
                 const double x = q[first], y = q[first + 1], z = q[first + 2];
                 return detail::rotation_chart_edge * detail::rotation_chart_edge - (x * x + y * y + z * z);
               })
      .falling()
      .action(detail::OtherRotationVector<first>{});
}

}  // namespace qdot
