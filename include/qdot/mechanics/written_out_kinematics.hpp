#pragma once
// SPDX-License-Identifier: MIT
//
// The kinematic door, written out.
//
//     struct Positions {
//       double m = 1.0, l = 1.0;
//       template <class Q>
//       constexpr void operator()(const Q& q, auto& bodies) const {
//         typename Q::Scalar x(0.0), y(0.0);
//         for (int k = 0; k < q.size(); ++k) {
//           x += l * sin(q[k]);
//           y -= l * cos(q[k]);
//           bodies.point_mass(m, vector(x, y));
//         }
//       }
//     };
//     const auto chain = written_out_kinematic_system<8>(Positions{.m = 0.3}, gravity_along<1>(-9.81));
//
// The compiler runs the functor, differentiates the positions, and derives the equations of T = Σ ½ m ṙ·ṙ as it does those of a T that is written
// (mechanics/written_out.hpp). What holds there holds here: everything constexpr, no branch on q, up to 32 coordinates. Bodies are
// point masses and planar bodies.
//
// gravity_along<1>(−9.81) says while compiling that x is level. uniform_gravity(0.0, −9.81) does not, and costs what a field in any
// direction costs: a tenth of the time of one pendulum or two.

#include <utility>

#include "qdot/mechanics/kinematic_system.hpp"
#include "qdot/mechanics/written_out.hpp"

namespace qdot {

namespace detail {

template <>
struct Example<UniformGravity> {
  static constexpr bool exists = true, another_exists = true;
  template <int which>
  static constexpr UniformGravity object() {
    return which == 0 ? uniform_gravity(0.73, -9.81, 0.57) : uniform_gravity(0.39, -1.62, 0.83);
  }
};

template <int axis>
struct Example<GravityAlong<axis>> {
  static constexpr bool exists = true, another_exists = true;
  template <int which>
  static constexpr GravityAlong<axis> object() {
    return {which == 0 ? -9.81 : -1.62};
  }
};

template <int n, class Place, class Potential, class Extra>
struct Example<KinematicEnergies<n, Place, Potential, Extra>> {
  static constexpr bool exists = Example<Place>::exists && Example<Potential>::exists && Example<Extra>::exists;
  static constexpr bool another_exists = Example<Place>::another_exists && Example<Potential>::another_exists && Example<Extra>::another_exists;
  template <int which>
  static constexpr KinematicEnergies<n, Place, Potential, Extra> object() {
    return {Example<Place>::template object<which>(), Example<Potential>::template object<which>(), Example<Extra>::template object<which>()};
  }
};

}  // namespace detail

/// kinematic_system() with its equations derived while compiling.
///
/// @param place    place(q, bodies) or place(q, t, bodies), constexpr
/// @param V        V(q), V(q, t), constexpr; uniform_gravity(gx, gy, gz) or gravity_along<axis>(g)
/// @param T_extra  a further kinetic term, constexpr
template <int n, class Place, class Potential = NoPotential, class Extra = detail::NoKineticTerm>
auto written_out_kinematic_system(Place place, Potential V = {}, Extra T_extra = {}) {
  static_assert(detail::require_kinematics<n, Place, Potential, Extra>());
  using Energies = detail::KinematicEnergies<n, Place, Potential, Extra>;
  return detail::checked_system<n>(detail::written_out_of<n>(Energies(std::move(place), std::move(V), std::move(T_extra))), n);
}

}  // namespace qdot
